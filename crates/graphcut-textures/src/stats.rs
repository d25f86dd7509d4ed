//! Counts of one run.

use crate::settings::Settings;

/// Counts of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats<const D: usize> {
    /// What was chosen for it.
    pub settings: Settings<D>,
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
    /// Price of all seams after each finer size was decided; empty at one size. Of several windows both are those of
    /// one after the other, and the last is the price of all seams of the clip.
    pub settled: Vec<i64>,
}

impl<const D: usize> Stats<D> {
    /// Before the first patch.
    pub(crate) fn of(settings: &Settings<D>) -> Self {
        Self {
            settings: *settings,
            patches: 0,
            refinements: 0,
            improvements: 0,
            cuts: 0,
            cut_nodes: 0,
            energy: Vec::new(),
            settled: Vec::new(),
        }
    }

    /// Numbers of patches, refinements, improvements, cuts and their nodes, as checkpoints keep them.
    pub(crate) fn counts(&self) -> [u64; 5] {
        [self.patches, self.refinements, self.improvements, self.cuts, self.cut_nodes]
    }

    /// The same of a run that is gone on from.
    pub(crate) fn set_counts(&mut self, counts: [u64; 5]) {
        [self.patches, self.refinements, self.improvements, self.cuts, self.cut_nodes] = counts;
    }

    /// Counts those of a run over a part of the output as well.
    pub(crate) fn add(&mut self, part: &Self) {
        self.patches += part.patches;
        self.refinements += part.refinements;
        self.improvements += part.improvements;
        self.cuts += part.cuts;
        self.cut_nodes += part.cut_nodes;
        self.energy.extend(&part.energy);
        self.settled.extend(&part.settled);
    }
}
