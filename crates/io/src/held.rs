//! What formats hold: sizes, channels and depths, known before anything is encoded.

use crate::error::Problem;
use crate::{Depth, Format};

impl Format {
    /// Refuses a picture of this height and width, colour channels, alpha and depth that the format cannot hold.
    ///
    /// # Errors
    /// [`Problem::NoSamples`], [`Problem::SideNotHeld`], [`Problem::DepthNotHeld`], [`Problem::ChannelsNotHeld`].
    pub fn check(self, [height, width]: [u32; 2], channels: usize, alpha: bool, depth: Depth) -> Result<(), Problem> {
        let format = self;
        if width == 0 || height == 0 {
            return Err(Problem::NoSamples { width: width.into(), height: height.into() });
        }
        let limit = self.longest_side();
        if limit < width.max(height) {
            return Err(Problem::SideNotHeld { format, width, height, limit });
        }
        if !self.depths().contains(&depth) {
            return Err(Problem::DepthNotHeld { format, depth });
        }
        // EXR has names for any number of channels.
        let held = if self == Self::Exr { 0 < channels } else { matches!(channels, 1 | 3) };
        if !held || (alpha && !self.holds_alpha()) {
            return Err(Problem::ChannelsNotHeld { format, channels, alpha });
        }
        Ok(())
    }

    /// Samples a side at most.
    const fn longest_side(self) -> u32 {
        match self {
            Self::Webp => 16_383,
            Self::Jpeg | Self::Tga => 65_535,
            _ => u32::MAX,
        }
    }

    pub(crate) const fn holds_alpha(self) -> bool {
        !matches!(self, Self::Jpeg | Self::Hdr)
    }
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Plane, Role, Samples};

    use super::*;
    use crate::{Metadata, WriteOptions, encode};

    fn plane(channels: usize, alpha: bool, depth: Depth) -> Plane<2> {
        let domain = Domain::open([2, 3]);
        let samples = Samples::try_zeros(domain, channels, depth).unwrap();
        Plane { alpha, ..Plane::new(Role::Color, samples) }
    }

    #[test]
    fn what_is_said_to_be_held_can_be_written() {
        for format in Format::ALL.into_iter().filter(|f| !f.depths().is_empty()) {
            for colors in 1..5 {
                for (alpha, depth) in format.depths().iter().flat_map(|&d| [(false, d), (true, d)]) {
                    if format.check([2, 3], colors, alpha, depth).is_ok() {
                        let plane = plane(colors + usize::from(alpha), alpha, depth);
                        let options = WriteOptions { format: Some(format), ..WriteOptions::default() };
                        let written = encode(&plane, &Metadata::default(), "a", &options);
                        assert!(written.is_ok(), "{format} {colors} {alpha} {depth:?}: {written:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_not_held_is_refused_with_formats_that_hold_it() {
        let remedy = |problem: Result<(), Problem>| problem.unwrap_err().remedy();
        assert_eq!(remedy(Format::Jpeg.check([2, 3], 3, true, Depth::U8)), "write png, tiff, webp or tga");
        assert_eq!(remedy(Format::Hdr.check([2, 3], 3, true, Depth::F32)), "write tiff or exr");
        assert_eq!(remedy(Format::Webp.check([2, 16_384], 3, false, Depth::U8)), "write png, jpeg, tiff or tga");
        assert!(Format::Webp.check([2, 16_383], 3, false, Depth::U8).is_ok());
        assert_eq!(remedy(Format::Png.check([2, 3], 2, false, Depth::U8)), "write one or three channels, or exr");
        assert!(Format::Gif.check([2, 3], 3, false, Depth::U8).is_err(), "it is only read");
    }
}
