//! What a run begins with.

use selvedge_core::{Grid, SourceMap};

/// What is there before the first label.
#[derive(Clone, Debug)]
pub struct Start {
    /// Samples that stand already; the rest is unassigned.
    pub map: SourceMap<2>,
    /// Positions whose sample stays; `None` for none. An unassigned one is filled.
    pub fixed: Option<Grid<bool, 2>>,
}
