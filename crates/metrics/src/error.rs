//! What can go wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An output's channels differ from the exemplars'.
    #[error("the output has {found} feature channels, the exemplars have {expected}")]
    Channels {
        /// Of the exemplars.
        expected: usize,
        /// Of the output.
        found: usize,
    },
    /// A map and its output, or a map and its exemplars, differ in size.
    #[error("the map is {} px, but {} px are needed", across(found), across(expected))]
    Map {
        /// Shape needed, slowest axis first; or the number of exemplar samples.
        expected: Vec<u32>,
        /// Shape found.
        found: Vec<u32>,
    },
    /// An exemplar or an output is too small to be compared.
    #[error("{} px are too few to judge", across(shape))]
    TooSmall {
        /// Its shape, slowest axis first.
        shape: Vec<u32>,
    },
    /// What the core says, such as that memory is short.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
    /// What the search says.
    #[error(transparent)]
    Search(#[from] selvedge_fft_ssd::Error),
}

/// A shape as people write it, the fastest axis first.
fn across(shape: &[u32]) -> String {
    shape.iter().rev().map(u32::to_string).collect::<Vec<_>>().join("x")
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Core(e) => e.kind(),
            Self::Search(e) => e.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Channels { .. } => "convert one of them",
            Self::Map { .. } => "give the map that was written with the output",
            Self::TooSmall { .. } => "give at least 32 along each side",
            Self::Core(e) => return e.remedy(),
            Self::Search(e) => return e.remedy(),
        }
        .to_owned()
    }
}
