//! Working memory that a caller keeps between searches.

use crate::placement::Range;

/// Working memory of a search. Keep one a thread: after the first search nothing is allocated.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(crate) ranges: Vec<Range>,
}

impl Scratch {
    /// Empty; grows with the first search.
    pub fn new() -> Self {
        Self::default()
    }
}
