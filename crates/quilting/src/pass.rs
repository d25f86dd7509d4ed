//! What one pass of blocks over the output is told.

use selvedge_core::{Exemplars, Seed};

use crate::block_grid::BlockGrid;
use crate::options::{Continuation, Stage};
use crate::steering::Steering;

/// What a pass is told.
pub(crate) struct Pass<'a> {
    pub(crate) exemplars: &'a Exemplars<2>,
    pub(crate) grid: BlockGrid,
    /// Side of the blocks.
    pub(crate) block: u32,
    /// See [`per_mille`](crate::options::per_mille).
    pub(crate) per_mille: u32,
    pub(crate) stage: Stage,
    pub(crate) continuation: Continuation,
    /// See [`Options::spread`](crate::Options::spread).
    pub(crate) spread: f64,
    /// What the blocks follow besides their neighbours.
    pub(crate) steering: Option<Steering<'a>>,
    pub(crate) seed: Seed,
    pub(crate) progress: Progress,
}

/// What the observer is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    pub(crate) name: &'static str,
    /// Blocks of the passes before.
    pub(crate) before: u64,
    /// Blocks of all passes.
    pub(crate) of: u64,
}
