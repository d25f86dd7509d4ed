//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A mask has another shape than what it lies over.
    #[error("the {what} is {found:?}, but {expected:?} is needed")]
    Shape {
        /// Which one.
        what: &'static str,
        /// The shape that it needs, slowest axis first.
        expected: Vec<u32>,
        /// The shape found.
        found: Vec<u32>,
    },
    /// An error of the core: the map names samples that it does not hold, for one.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Shape { .. } => ErrorKind::Input,
            Self::Core(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Shape { .. } => "make them the same size".to_owned(),
            Self::Core(error) => error.remedy(),
        }
    }
}
