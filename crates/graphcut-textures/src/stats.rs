//! Counts of one run.

use crate::options::{Placement, Stutter};
use crate::settings::Settings;

/// Counts of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats<const D: usize> {
    /// The placement that was used: never [`Placement::Auto`].
    pub placement: Placement,
    /// What [`Placement::Auto`] chose by: the strength of the exemplars' clearest
    /// [lattice](selvedge_analysis::Lattice::strength) (1 = 1000).
    pub regularity: Option<f64>,
    /// Sides of the error region that was used.
    pub region: [u32; D],
    /// How far patches could reach beyond it along each axis.
    pub reach: [u32; D],
    /// The variety that was used.
    pub variety: f64,
    /// How far patches lay from where a neighbour shows the same.
    pub apart: u32,
    /// Which of them lay nearer all the same: never [`Stutter::Auto`].
    pub stutter: Stutter,
    /// At how many sizes the map was solved.
    pub levels: u32,
    /// Patches laid until everything was covered, but for those that lay there and were moved by a sample to show what
    /// masks left open.
    pub patches: u64,
    /// Patches tried over bad seams.
    pub refinements: u64,
    /// Those of them that made seams cheaper.
    pub improvements: u64,
    /// Cuts that were solved.
    pub cuts: u64,
    /// Positions that cuts decided, over all cuts.
    pub cut_nodes: u64,
    /// Price of all seams when everything was covered, and after each refinement, at the smallest size.
    pub energy: Vec<i64>,
    /// Price of all seams after each finer size was decided; empty at one size.
    pub settled: Vec<i64>,
}

impl<const D: usize> Stats<D> {
    /// Before the first patch.
    pub(crate) fn of(settings: &Settings<D>) -> Self {
        Self {
            placement: settings.placement,
            regularity: settings.regularity,
            region: settings.region,
            reach: settings.reach,
            variety: settings.variety,
            apart: settings.apart,
            stutter: settings.stutter,
            levels: settings.levels,
            patches: 0,
            refinements: 0,
            improvements: 0,
            cuts: 0,
            cut_nodes: 0,
            energy: Vec::new(),
            settled: Vec::new(),
        }
    }

    /// Tells of the whole run what was chosen for it.
    pub(crate) fn tell(&mut self, settings: &Settings<D>) {
        (self.region, self.reach, self.apart, self.levels) =
            (settings.region, settings.reach, settings.apart, settings.levels);
    }
}
