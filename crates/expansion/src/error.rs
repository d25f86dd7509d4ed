//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The cut failed: no memory, cancelled, or prices beyond their range.
    #[error("the cut failed: {0}")]
    Cut(#[from] selvedge_maxflow::MaxflowError),
    /// An error of the core.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Cut(error) => match error.kind() {
                selvedge_maxflow::ErrorKind::Memory => ErrorKind::Memory,
                _ => ErrorKind::Internal,
            },
            Self::Core(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Core(error) => error.remedy(),
            Self::Cut(_) if self.kind() == ErrorKind::Memory => "use a smaller region or exemplar".into(),
            Self::Cut(_) => "please report it".into(),
        }
    }

    /// True if the caller asked to stop: what stood before the move is whole, and nothing is wrong.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cut(error) if error.kind() == selvedge_maxflow::ErrorKind::Cancelled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_maxflow::MaxflowError;

    #[test]
    fn only_a_wish_to_stop_counts_as_cancelled() {
        let memory = Error::Cut(MaxflowError::OutOfMemory { nodes: 1, links: 2 });
        let range = Error::Cut(MaxflowError::CapacityTooLarge { node: 0, value: 1, max: 0 });
        let core = Error::Core(selvedge_core::Error::Allocation { bytes: 7 });
        assert!(Error::Cut(MaxflowError::Cancelled).is_cancelled());
        assert!([&memory, &range, &core].iter().all(|e| !e.is_cancelled()));
        let kinds = [memory, range, core].map(|e| e.kind());
        assert_eq!(kinds, [ErrorKind::Memory, ErrorKind::Internal, ErrorKind::Memory]);
    }
}
