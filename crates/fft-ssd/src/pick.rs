//! What questions to costs hand around: a candidate, as it is told, as it is sorted, and where it is looked for.

use std::cmp::Ordering;

/// A place where the template may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate<const D: usize> {
    /// The source, in the order of the searcher's.
    pub source: usize,
    /// Source position of the template's first sample, slowest axis first; negative where the template sticks out.
    pub position: [i32; D],
    /// Sum of the weighted squared differences.
    pub error: u64,
    /// Samples compared.
    pub samples: u64,
}

/// A candidate as questions sort it: mean error, then place in the list of all positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pick {
    pub(crate) error: u64,
    pub(crate) count: u32,
    pub(crate) flat: u32,
}

impl Pick {
    /// By mean error, then source, then position. A mean over no samples is 0.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        self.by_mean(other).then(self.flat.cmp(&other.flat))
    }

    pub(crate) fn by_mean(&self, other: &Self) -> Ordering {
        if self.count == other.count {
            return self.error.cmp(&other.error);
        }
        let scaled = |a: &Self, b: &Self| u128::from(a.error) * u128::from(b.count);
        scaled(self, other).cmp(&scaled(other, self))
    }
}

/// Neighbouring positions of one source, and their least error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) source: u32,
    pub(crate) start: u32,
    pub(crate) end: u32,
    pub(crate) least: u64,
}

impl Run {
    /// The places in the list of all positions.
    pub(crate) fn places(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}
