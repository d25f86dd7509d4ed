//! Working memory that a caller keeps between searches.

use crate::cover::CoverScratch;
use crate::direct::DirectScratch;
use crate::placement::Range;

/// Working memory of a search. Keep one a thread: after the first search nothing is allocated.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(crate) ranges: Vec<Range>,
    pub(crate) direct: DirectScratch,
    pub(crate) cover: CoverScratch,
}

impl Scratch {
    /// Empty; grows with the first search.
    pub fn new() -> Self {
        Self::default()
    }
}
