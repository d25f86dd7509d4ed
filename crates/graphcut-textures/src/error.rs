//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No exemplar holds an error region.
    #[error("no exemplar holds a region of {} (the largest is {largest:?})", sides(region))]
    RegionExceedsExemplar {
        /// The region's shape, slowest axis first.
        region: Vec<u32>,
        /// The largest exemplar's shape, slowest axis first.
        largest: Vec<u32>,
    },
    /// A loop is made of one clip.
    #[error("a loop is made of one clip as it is, not of {found}")]
    OneClip {
        /// Sources there are.
        found: usize,
    },
    /// A clip that cannot loop.
    #[error("a clip of {frames} frames cannot loop")]
    Frames {
        /// Its frames.
        frames: u32,
    },
    /// The clip is shorter than the loop asked for.
    #[error("a clip of {frames} frames has no loop of {period}")]
    Period {
        /// The shortest loop asked for.
        period: u32,
        /// The clip's frames.
        frames: u32,
    },
    /// No jump was given.
    #[error("there is no jump to be cut")]
    NoJumps,
    /// A frame of a clip that is read again could not be had.
    #[error("frame {frame} of the clip cannot be read")]
    Unread {
        /// Its number.
        frame: u32,
    },
    /// A jump that is not in the clip.
    #[error("a clip of {frames} frames has no jump back from frame {from} to frame {to}")]
    Jump {
        /// The last frame before it.
        from: u32,
        /// The first frame after it.
        to: u32,
        /// The clip's frames.
        frames: u32,
    },
    /// A surface that does not fit the clip and its jump.
    #[error("{}", surface(found, expected, at.as_ref(), *frames))]
    Surface {
        /// Its sides.
        found: [u32; 2],
        /// The sides of the clip's frames.
        expected: [u32; 2],
        /// The first pixel that would show a frame that there is not.
        at: Option<[u32; 2]>,
        /// The clip's frames.
        frames: u32,
    },
    /// The caller asked to stop before there was anything to show.
    #[error("stopped before there was a result")]
    Cancelled,
    /// No labels, or too many.
    #[error("{found} labels, of which at least 1 and at most {} can be told apart", crate::labels::label::MOST_LABELS)]
    Labels {
        /// How many there are.
        found: usize,
    },
    /// A label of a source that there is not.
    #[error("a label is of source {number}, and there are {sources}")]
    LabelSource {
        /// The label's source.
        number: usize,
        /// Sources of the exemplars.
        sources: usize,
    },
    /// Positions where no label may show.
    #[error("no label may show at {at:?} (nor at {} other positions)", places - 1)]
    NoLabel {
        /// The first of them, slowest axis first.
        at: Vec<u32>,
        /// How many there are.
        places: usize,
    },
    /// A stroke where its label cannot show.
    #[error("{} cannot show at place {place}", label.map_or("anything".to_owned(), |label| format!("label {label}")))]
    Stroke {
        /// The place in the output's buffer.
        place: usize,
        /// The label, if one was asked for.
        label: Option<usize>,
    },
    /// Levels were asked for, but something stands in the output, or not all may show everywhere.
    #[error("an output that begins with something in it cannot be solved at {levels} levels")]
    LevelsOfStart {
        /// What was asked for.
        levels: u32,
    },
    /// Too few frames to be woven at once.
    #[error("{frames} frames at once are too few, of this clip {least} are the least")]
    AtOnce {
        /// What was asked for.
        frames: u32,
        /// As many as it takes.
        least: u32,
    },
    /// A checkpoint of another run, or none at all.
    #[error("the checkpoint has another {what} than this run")]
    Checkpoint {
        /// What differs.
        what: &'static str,
    },
    /// A cut failed.
    #[error(transparent)]
    Cut(#[from] selvedge_expansion::Error),
    /// The search failed.
    #[error(transparent)]
    Search(#[from] selvedge_fft_ssd::Error),
    /// An error of the core.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

/// The sides of a box in words.
fn sides(shape: &[u32]) -> String {
    match shape {
        [first, rest @ ..] if rest.iter().all(|n| n == first) => format!("{first} samples a side"),
        _ => format!("{shape:?} samples"),
    }
}

/// What is wrong with a surface, in words.
fn surface(found: &[u32; 2], expected: &[u32; 2], at: Option<&[u32; 2]>, frames: u32) -> String {
    match at {
        Some([y, x]) => format!("the surface shows frames at ({x}, {y}) that a clip of {frames} does not have"),
        None => {
            format!("a surface of {}x{} does not fit frames of {}x{}", found[1], found[0], expected[1], expected[0])
        }
    }
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::NoJumps | Self::LevelsOfStart { .. } | Self::AtOnce { .. } => ErrorKind::Option,
            Self::Cancelled => ErrorKind::Internal,
            Self::Cut(error) => error.kind(),
            Self::Search(error) => error.kind(),
            Self::Core(error) => error.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::LevelsOfStart { .. } => "use 1 level",
            Self::AtOnce { least, .. } => return format!("weave {least} or more at once"),
            Self::Checkpoint { .. } => "begin again without it",
            Self::RegionExceedsExemplar { .. } => "use a smaller region or a larger exemplar",
            Self::OneClip { .. } => "give one clip, neither turned nor mirrored",
            Self::Frames { .. } => "give a clip of 2 to 65535 frames",
            Self::Period { frames, .. } => {
                return format!("ask for a loop of at most {frames} frames, or give a longer clip");
            }
            Self::Unread { .. } => "leave the clip's files as they are during the run",
            Self::NoJumps => "give at least one jump",
            Self::Jump { frames, .. } => return format!("give frames below {frames}, the later one first"),
            Self::Surface { .. } => "use the surface of a loop of this clip, with the same jump",
            Self::Cancelled => "start again",
            Self::Labels { .. } => "give from 1 to 64 labels",
            Self::LabelSource { .. } => "give the source as well",
            Self::NoLabel { .. } => "let a label show there",
            Self::Stroke { .. } => "paint inside of the output, where that label is",
            Self::Cut(error) => return error.remedy(),
            Self::Search(error) => return error.remedy(),
            Self::Core(error) => return error.remedy(),
        }
        .to_owned()
    }

    /// True if the caller asked to stop.
    pub(crate) fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled) || matches!(self, Self::Cut(error) if error.is_cancelled())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_but_a_wish_to_stop_leaves_a_run_incomplete() {
        let core = selvedge_core::Error::Allocation { bytes: 7 };
        for error in [Error::Cut(core.clone().into()), Error::Core(core), Error::NoJumps] {
            assert!(!error.is_cancelled(), "{error}");
        }
    }
}
