//! What is odd about a file that could be read all the same.

use std::path::Path;

use crate::{Format, file_of, quoted};

/// What is odd about a file that could be read all the same; shown as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// The extension names another format than the content is.
    #[error("the name says {named}, but the content is {content}")]
    Misnamed {
        /// The format by content, which was read.
        content: Format,
        /// The format by name.
        named: Format,
    },
    /// An animation, of which one frame was read.
    #[error("only the first frame of the animation is used")]
    FirstFrameOnly,
    /// Frames of an animation that are shown longer than others.
    #[error("some of its frames are shown longer than others; they become frames of one rate")]
    UnevenDelays,
    /// A file with several pages, of which one was read.
    #[error("only the first page is used")]
    FirstPageOnly,
    /// A file of several pictures that are no pages, of which one was read.
    #[error("only the first of its pictures is used")]
    FirstPictureOnly,
    /// A picture that stands before an animation and is no part of it.
    #[error("its default picture is used, which is no frame of its animation")]
    DefaultPictureOnly,
    /// A JPEG that ends after its last sample, without saying so.
    #[error("its end marker is missing; nothing else is")]
    EndMarkerMissing,
    /// Samples that were infinite or no numbers.
    #[error("{count} value(s) that are not finite were replaced")]
    NotFinite {
        /// How many.
        count: u64,
    },
    /// Palette indices beyond the palette.
    #[error("{count} sample(s) have no colour in the palette and are black")]
    BeyondPalette {
        /// How many.
        count: u64,
    },
    /// A profile that was left out.
    #[error("its colour profile is damaged or over 16 MiB and is left out")]
    ProfileLeftOut,
    /// CMYK that was turned into RGB without a profile.
    #[error("cmyk was turned into rgb without its colour profile")]
    CmykConverted,
    /// Colours that were multiplied by alpha for the format.
    #[error("colours were multiplied by alpha, as {format} has them")]
    Multiplied {
        /// The format written.
        format: Format,
    },
    /// Colours that were divided by alpha for the format.
    #[error("colours were divided by alpha, as {format} has them")]
    Divided {
        /// The format written.
        format: Format,
    },
    /// Light below 0, which the format written does not hold.
    #[error("{count} sample(s) are below 0 and became 0, since {format} holds none")]
    Negative {
        /// How many.
        count: u64,
        /// The format written.
        format: Format,
    },
    /// Channels that were chosen, which a picture of so many has other names for.
    #[error("{from} {} named {to} in this exr", if from.contains(',') { "are" } else { "is" })]
    Renamed {
        /// Their names in the file read.
        from: String,
        /// In the file written.
        to: String,
    },
    /// A colour tag for which the format written has no place.
    #[error("its {tag} {} no place in this {format} and {} left out",
        if tag.ends_with('s') { "have" } else { "has" }, if tag.ends_with('s') { "are" } else { "is" })]
    TagLeftOut {
        /// The tag.
        tag: &'static str,
        /// The format written.
        format: Format,
    },
    /// What a file says of its colours or their place and nothing is made of.
    #[error("its {tag} {} neither followed nor kept", if tag.ends_with('s') { "are" } else { "is" })]
    TagUnread {
        /// The tag.
        tag: &'static str,
    },
    /// A colour tag that was not followed when integers became linear light.
    #[error("its {tag} is not followed: integers became linear light as if they were sRGB")]
    TagNotFollowed {
        /// The tag.
        tag: &'static str,
    },
    /// Integers of narrow range, whose black and white are not the ends of all integers.
    #[error("its colours are of narrow range: 16 to 235 of 255 became all from black to white")]
    NarrowRange,
    /// Colours that were divided by alpha, because they became light or stopped to be it.
    #[error("its colours were divided by alpha to change their depth, and are straight now")]
    Unmultiplied,
    /// Integers of colour that are more than their alpha, by which they were multiplied.
    #[error("{count} pixel(s) have more colour than their alpha allows; where it is divided they are clipped")]
    BeyondAlpha {
        /// How many.
        count: u64,
    },
    /// Channels that do not belong to the picture that was read.
    #[error("{what}")]
    ChannelsLeftOut {
        /// Which, and how they would be read.
        what: String,
    },
    /// Luma and chroma that became colours.
    #[error("luma and chroma became rgb: copies of samples are not exact")]
    ChromaConverted,
    /// What the program said that decoded a clip.
    #[error("ffmpeg says: {line}")]
    Said {
        /// Its last line.
        line: String,
    },
    /// 64-bit samples that were rounded to 32 bits.
    #[error("64-bit floats were rounded to 32 bits")]
    Rounded,
    /// Half and float channels that were read as float.
    #[error("half and float channels were both read as float")]
    Widened,
}

impl Warning {
    /// The warning about a file: what it says of `'file.exr[...]'` or `'file.tif[...]'` it says of that one.
    pub fn of(&self, file: &Path) -> String {
        let text = self.to_string();
        if !matches!(self, Self::ChannelsLeftOut { .. }) {
            return text;
        }
        // A choice that was made is not chosen from.
        let name = quoted(file_of(file));
        let own = format!("{}[", name.trim_end_matches('\''));
        ["exr", "tif"].iter().fold(text, |text, kind| text.replace(&format!("'file.{kind}["), &own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_called_by_its_own_name() {
        let left = Warning::ChannelsLeftOut { what: "not in the picture: Z; 'file.exr[Z]' reads it".into() };
        assert_eq!(left.of(Path::new("in/a.exr")), "not in the picture: Z; 'in/a.exr[Z]' reads it");
        assert_eq!(left.of(Path::new("none.exr[R,G,B]")), "not in the picture: Z; 'none.exr[Z]' reads it");
        assert_eq!(Warning::Rounded.of(Path::new("a.exr")), Warning::Rounded.to_string());
    }
}
