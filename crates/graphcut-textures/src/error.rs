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
    /// The output has no samples.
    #[error("an output of shape {shape:?} holds nothing")]
    EmptyOutput {
        /// The shape asked for, slowest axis first.
        shape: Vec<u32>,
    },
    /// No exemplar holds an error region.
    #[error("no exemplar holds a region of {} (the largest is {largest:?})", sides(region))]
    RegionExceedsExemplar {
        /// The region's shape, slowest axis first.
        region: Vec<u32>,
        /// The largest exemplar's shape, slowest axis first.
        largest: Vec<u32>,
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

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Range { .. } | Self::EmptyOutput { .. } => ErrorKind::Option,
            Self::Cut(error) => error.kind(),
            Self::Search(error) => error.kind(),
            Self::Core(error) => error.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Range { range, .. } => return format!("use {range}"),
            Self::EmptyOutput { .. } => "give every side at least 1",
            Self::RegionExceedsExemplar { .. } => "use a smaller region or a larger exemplar",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_but_a_wish_to_stop_leaves_a_run_incomplete() {
        let core = selvedge_core::Error::Allocation { bytes: 7 };
        for error in [Error::Cut(core.clone().into()), Error::Core(core), Error::EmptyOutput { shape: vec![0, 2] }] {
            assert!(!error.is_cancelled(), "{error}");
        }
    }
}
