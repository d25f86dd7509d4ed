//! What can be wrong with a map.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A blur that is negative, too large, or no number.
    #[error("a blur of {sigma} px is out of range")]
    Blur {
        /// The blur asked for.
        sigma: f64,
        /// The widest allowed.
        limit: f64,
    },
    /// An error of the core.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Blur { .. } => ErrorKind::Option,
            Self::Core(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Blur { limit, .. } => format!("use 0 to {limit}"),
            Self::Core(error) => error.remedy(),
        }
    }
}
