//! What is wrong with a clip that is wrong with no picture.

use selvedge_core::{ErrorKind, Limits};

/// What is wrong with a clip.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClipProblem {
    /// No rate.
    #[error("'{text}' is no rate")]
    Rate {
        /// What was typed or stands in a file.
        text: String,
    },
    /// No range of frames.
    #[error("'{text}' is no range of frames")]
    Range {
        /// What was typed.
        text: String,
    },
    /// No flipbook.
    #[error("'{text}' is no flipbook")]
    Flipbook {
        /// What was typed.
        text: String,
    },
    /// A picture that is no such flipbook.
    #[error("{width}x{height} px are not {columns}x{rows} frames{}", if *pad == 0 { String::new() } else { format!(" with {pad} px around each") })]
    Cells {
        /// Samples along x.
        width: u32,
        /// Samples along y.
        height: u32,
        /// Frames beside each other.
        columns: u32,
        /// Frames below each other.
        rows: u32,
        /// Samples around each frame.
        pad: u32,
    },
    /// More frames than a flipbook has places.
    #[error("{frames} frames are more than a flipbook of {columns}x{rows} holds")]
    Full {
        /// Frames.
        frames: u32,
        /// Frames beside each other.
        columns: u32,
        /// Frames below each other.
        rows: u32,
    },
    /// A name that is that of no clip.
    #[error("is the name of no clip")]
    NoClip,
    /// A file of one picture.
    #[error("is a single picture, no clip")]
    Still,
    /// The first bytes belong to no clip that is read.
    #[error("is no clip in a format that can be read")]
    UnknownContainer,
    /// A container whose data contradict themselves or end early.
    #[error("damaged {container} file ({cause})")]
    Damaged {
        /// The container.
        container: &'static str,
        /// What is wrong.
        cause: String,
    },
    /// A container that is read and not written.
    #[error("{container} clips are read, not written")]
    OnlyRead {
        /// The container.
        container: &'static str,
    },
    /// Sound, but beyond what is read or written.
    #[error("{what} {} not supported in {container}", crate::error::verb(what))]
    Unsupported {
        /// The container.
        container: &'static str,
        /// What was found.
        what: String,
    },
    /// A container of other programs, without the program for it.
    #[error("needs ffmpeg, which was not found")]
    NoFfmpeg {
        /// Whether it was to be written.
        writes: bool,
    },
    /// The program for other containers failed.
    #[error("ffmpeg failed: {said}")]
    Failed {
        /// Its last line.
        said: String,
        /// Whether it was to write.
        writes: bool,
    },
    /// The program for other containers did nothing.
    #[error("ffmpeg did nothing for {seconds} s, and was ended")]
    Hangs {
        /// How long it was waited for.
        seconds: u64,
    },
    /// Options of a codec for what is not encoded by another program.
    #[error("is encoded without ffmpeg")]
    NoCodec,
    /// A pattern or folder without files.
    #[error("no frame of this name was found")]
    NoFrames,
    /// A number between others has no file.
    #[error("frame {number} is missing{}", before.map_or(String::new(), |n| format!(" after {n}")))]
    Gap {
        /// The number.
        number: u32,
        /// The number before it.
        before: Option<u32>,
    },
    /// A range reaches beyond the frames of an animation.
    #[error("frame {number} is missing{}, of frames 1 to {frames}",
        if frames < number { format!(" after {frames}") } else { String::new() })]
    Place {
        /// The first place that there is not.
        number: u32,
        /// Frames of the animation.
        frames: u32,
    },
    /// Two files have the same number.
    #[error("frame {number} is there twice, also as '{other}'")]
    Doubled {
        /// The number.
        number: u32,
        /// The other file.
        other: String,
    },
    /// A file in a folder of frames that has no name like theirs.
    #[error("is no frame like '{first}'")]
    Foreign {
        /// The first frame.
        first: String,
    },
    /// A frame that differs from the first one.
    #[error("frame {number} has {found}, but the first one {first}")]
    Differs {
        /// The frame's number or place.
        number: u32,
        /// What it has.
        found: String,
        /// What the first frame has.
        first: String,
    },
    /// A frame's file is another one than when it was read first.
    #[error("has changed since it was read first")]
    Changed,
    /// Fewer frames are written, or more, than were said.
    #[error("{found} frames were written where {expected} were announced")]
    Count {
        /// Frames announced.
        expected: u32,
        /// Frames written.
        found: u32,
    },
    /// All frames together are over the cap.
    #[error("{frames} frames of {width}x{height} px are {samples} px, over the cap of {limit} px")]
    Samples {
        /// Frames.
        frames: u32,
        /// Samples along x.
        width: u32,
        /// Samples along y.
        height: u32,
        /// All multiplied.
        samples: u64,
        /// The cap.
        limit: u64,
    },
}

impl ClipProblem {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Rate { .. } | Self::Range { .. } | Self::Flipbook { .. } | Self::NoClip | Self::OnlyRead { .. } => {
                ErrorKind::Option
            }
            Self::NoCodec | Self::Failed { writes: true, .. } | Self::NoFfmpeg { writes: true } => ErrorKind::Option,
            Self::NoFrames => ErrorKind::FileSystem,
            Self::Count { .. } => ErrorKind::Internal,
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Rate { .. } => "use a number or a fraction above 0, such as 25 or 30000/1001",
            Self::Range { .. } => "use FIRST-LAST or FIRST-LASTxSTEP, such as 1-100x2",
            Self::Flipbook { .. } => "use COLUMNSxROWS, such as 8x8",
            Self::Cells { .. } => "give the numbers of its columns and rows, and what lies around its frames",
            Self::Full { .. } => "use more columns or rows, or fewer frames",
            Self::NoClip => {
                "name frames as name.####.png, a folder, or .gif, .png, .y4m, .mp4, .mov, .webm, .mkv or .avi"
            }
            Self::NoFrames => "check the name, and the number of its digits",
            Self::Still => "give frames as name.####.png, or an animation",
            Self::UnknownContainer => "pipe it: ffmpeg -i FILE -f yuv4mpegpipe -pix_fmt yuv444p - | selvedge ... -",
            Self::NoFfmpeg { writes: false } => {
                "install it, or pipe: ffmpeg -i FILE -f yuv4mpegpipe -pix_fmt yuv444p - | selvedge ... -"
            }
            Self::NoFfmpeg { writes: true } => "install it, or pipe: selvedge ... -o - | ffmpeg -i - FILE",
            Self::Failed { writes: false, .. } => "write or copy the file again, or see what ffmpeg says of it",
            Self::Failed { writes: true, .. } => "give it options and a container that go together",
            Self::Hangs { .. } => "see what it does with this file by itself",
            Self::NoCodec => "leave its options out, or name a file .mp4, .mov, .webm, .mkv or .avi",
            Self::OnlyRead { .. } => "write a sequence, apng, gif or y4m",
            Self::Damaged { .. } => "write or copy the file again",
            Self::Unsupported { .. } => "use a sequence of png, tiff or exr files",
            Self::Gap { .. } => "make it, or choose a range and step without it",
            Self::Place { .. } => "choose a range within them",
            Self::Doubled { .. } => "move one of them away",
            Self::Foreign { .. } => "name the frames by a pattern, such as 'name.####.png'",
            Self::Differs { .. } => "give frames of one size, depth and layout",
            Self::Changed => "leave the clip's files as they are while they are read",
            Self::Count { .. } => "please report it",
            Self::Samples { .. } => "use a smaller clip, or a range of its frames",
        }
        .to_owned()
    }
}

/// Refuses more samples than a clip of such frames may have, each of (width, height).
pub(super) fn check_samples((width, height): (u64, u64), frames: u32, limits: &Limits) -> Result<(), ClipProblem> {
    let samples = width.saturating_mul(height).saturating_mul(frames.into());
    // Sample numbers end below 2^32.
    let limit = limits.samples.min(u64::from(u32::MAX) - 1);
    if samples <= limit {
        return Ok(());
    }
    let (width, height) = (width as u32, height as u32);
    Err(ClipProblem::Samples { frames, width, height, samples, limit })
}
