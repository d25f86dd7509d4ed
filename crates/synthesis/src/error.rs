//! What can be wrong with a synthesis of candidates.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What graph cuts say.
    #[error(transparent)]
    Graphcut(#[from] selvedge_graphcut_textures::Error),
    /// What texture optimization says.
    #[error(transparent)]
    Optimization(#[from] selvedge_texture_optimization::Error),
    /// What the measures say.
    #[error(transparent)]
    Metrics(#[from] selvedge_metrics::Error),
    /// What the core says, such as that memory is short.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Graphcut(e) => e.kind(),
            Self::Optimization(e) => e.kind(),
            Self::Metrics(e) => e.kind(),
            Self::Core(e) => e.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Graphcut(e) => e.remedy(),
            Self::Optimization(e) => e.remedy(),
            Self::Metrics(e) => e.remedy(),
            Self::Core(e) => e.remedy(),
        }
    }
}
