//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option is out of its range.
    #[error("{option} is {value}, which is out of range")]
    Range {
        /// The option's name.
        option: &'static str,
        /// What it was set to.
        value: f64,
        /// What it may be, in words.
        range: &'static str,
    },
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
    /// The map has not exactly one channel.
    #[error("the map has {found} channels")]
    Channels {
        /// Its channels.
        found: usize,
    },
    /// An error of the core: the map names samples that it does not hold, for one.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Range { .. } => ErrorKind::Option,
            Self::Shape { .. } | Self::Channels { .. } => ErrorKind::Input,
            Self::Core(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Range { range, .. } => format!("use {range}"),
            Self::Shape { .. } => "make them the same size".to_owned(),
            Self::Channels { .. } => "give it one".to_owned(),
            Self::Core(error) => error.remedy(),
        }
    }
}
