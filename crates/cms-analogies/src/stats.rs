//! Counts of one run.

/// An energy in its parts, in the units of [`SeamCosts`](selvedge_core::SeamCosts): 16 a grey level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Energy {
    /// How far the output is from the constraints.
    pub agreement: i64,
    /// The price of all seams.
    pub boundary: i64,
    /// What is shown more often than other parts of the exemplars; 0 without [`spread`](crate::Options::spread).
    pub usage: i64,
}

impl Energy {
    /// All together.
    pub fn sum(self) -> i64 {
        self.agreement + self.boundary + self.usage
    }
}

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// Places for which labels were searched, or labels drawn at random.
    pub searches: u64,
    /// Labels that were tried.
    pub expansions: u64,
    /// Those of them that changed the output.
    pub improvements: u64,
    /// Samples that had a choice, over all expansions.
    pub nodes: u64,
    /// Samples beside these that a label was defined for, but that its agreement alone ruled out.
    pub pruned: u64,
    /// Terms that were lowered so that a cut could be made: 0 where seams are a metric.
    pub truncated: u64,
    /// Costs of a sample that were too large to be told apart.
    pub saturated: u64,
    /// `E'` when everything was covered, and after each expansion that changed something, in the order in which they
    /// were laid: labels of which none touches another are laid one after the other, but found beside each other.
    /// `[CMS eq. 6]`
    pub energy: Vec<i64>,
    /// `E'` at the end, what was minimised. `[CMS eq. 6]`
    pub model: Energy,
    /// `E` at the end, what was meant. `[CMS eq. 3]`
    pub truth: Energy,
}

impl Stats {
    /// Adds the work of another level; energies stay.
    pub(crate) fn add(&mut self, other: &Self) {
        self.searches += other.searches;
        self.expansions += other.expansions;
        self.improvements += other.improvements;
        self.nodes += other.nodes;
        self.pruned += other.pruned;
        self.truncated += other.truncated;
        self.saturated += other.saturated;
    }
}
