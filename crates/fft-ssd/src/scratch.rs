//! Working memory that a caller keeps between searches.

use crate::cover::CoverScratch;
use crate::direct::DirectScratch;
use crate::fft::FftScratch;
use crate::placement::Range;

/// Working memory of a search. Keep one a thread: after the first search of a size no large buffer is allocated.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(crate) ranges: Vec<Range>,
    pub(crate) direct: DirectScratch,
    pub(crate) fft: FftScratch,
    pub(crate) cover: CoverScratch,
    pub(crate) repeated: u64,
}

impl Scratch {
    /// Empty; grows with the first search.
    pub fn new() -> Self {
        Self::default()
    }

    /// Searches by Fourier transforms that were repeated by the direct engine, because a value to be rounded was
    /// farther from an integer than the rounding bound allows. Always 0, unless the bound's derivation or the machine
    /// is wrong.
    pub fn repeated(&self) -> u64 {
        self.repeated
    }
}
