//! Counts of a run.

use selvedge_core::Grid;

use crate::Level;

/// What happened at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelStats {
    /// The level.
    pub level: Level,
    /// Neighborhoods of the output.
    pub neighborhoods: u64,
    /// Per iteration the energy, as the mean squared distance of a sample in squared grey levels: normalised by samples
    /// and size. `[Kwatra05 fig. 3]`
    pub energy: Vec<f64>,
    /// Per iteration the robust energy, as the mean over neighborhoods.
    pub robust: Vec<f64>,
    /// Neighborhoods that were looked for, over all iterations; the others had not changed.
    pub searched: u64,
    /// Iterations after which the robust energy was greater than before.
    pub rises: u32,
    /// Whether the last iteration changed no neighborhood, and did not only come last.
    pub settled: bool,
}

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// Level by level.
    pub levels: Vec<LevelStats>,
    /// Levels of the schedule that did not fit.
    pub left_out: Vec<Level>,
    /// How far the neighborhoods of the last level were from what was found for them in its last iteration, as they
    /// lie: mean squared differences of a sample in squared grey levels.
    pub distances: Option<Grid<f32, 2>>,
    /// By level the mean distance of the neighborhoods in the first iteration.
    pub(crate) first: Vec<f64>,
}

impl Stats {
    /// Iterations over all levels.
    pub fn iterations(&self) -> usize {
        self.levels.iter().map(|l| l.energy.len()).sum()
    }

    /// The energy at the end.
    pub fn energy(&self) -> Option<f64> {
        self.levels.last().and_then(|l| l.energy.last().copied())
    }
}
