//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Without a constraint there is nothing to follow.
    #[error("there is no constraint to follow")]
    NoConstraint,
    /// Constraints say what an output is to be like, which has one size.
    #[error("one constraint lies under an output of {} px, another one under {} px", across(expected), across(found))]
    Target {
        /// The first one's shape, slowest axis first.
        expected: Vec<u32>,
        /// The other one's.
        found: Vec<u32>,
    },
    /// A picture to match to one of low resolution has not a multiple of its size.
    #[error("a picture of {} px is not {} px, as the coarse one asks for", across(found), across(expected))]
    Low {
        /// The shape that it should have, slowest axis first.
        expected: Vec<u32>,
        /// Its own.
        found: Vec<u32>,
    },
    /// Neighborhoods are larger than what they are compared in.
    #[error("neighborhoods of {side} samples a side do not fit into {what} of {} px", across(shape))]
    Neighborhood {
        /// Their side in samples of the output.
        side: u32,
        /// What they do not fit into.
        what: &'static str,
        /// Its shape, slowest axis first.
        shape: Vec<u32>,
    },
    /// A map to begin with is not of the output's shape and topology.
    #[error("the map to start from is not of {} px, as constraints are, or closes around other axes", across(expected))]
    Start {
        /// The output's shape, slowest axis first.
        expected: Vec<u32>,
    },
    /// A flow does not lie over the frame that it moves.
    #[error("the flow has {} vectors, and the frame is of {} px", across(found), across(expected))]
    Flow {
        /// The frame's shape, slowest axis first.
        expected: Vec<u32>,
        /// The flow's.
        found: Vec<u32>,
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

/// A shape as people write it, the fastest axis first.
fn across(shape: &[u32]) -> String {
    shape.iter().rev().map(u32::to_string).collect::<Vec<_>>().join("x")
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Cut(error) => error.kind(),
            Self::Search(error) => error.kind(),
            Self::Core(error) => error.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::NoConstraint => "give at least one",
            Self::Target { .. } | Self::Low { .. } => "make all of one size",
            Self::Neighborhood { .. } => "use smaller neighborhoods or larger pictures",
            Self::Start { .. } => "give a map of the size of the constraints",
            Self::Flow { .. } => "give a flow of the frames' size",
            Self::Cut(error) => return error.remedy(),
            Self::Search(error) => return error.remedy(),
            Self::Core(error) => return error.remedy(),
        }
        .to_owned()
    }

    /// True if the caller asked to stop.
    pub(crate) fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cut(error) if error.is_cancelled())
    }
}
