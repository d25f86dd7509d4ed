//! Which neighborhood of the exemplars each one of the output is pulled towards, and how much that counts.

use selvedge_core::{Exemplars, SampleId, Seed};

use crate::neighborhoods::{Neighborhoods, places};

/// A neighborhood of the exemplars: `z_p`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) source: u32,
    /// Its first sample.
    pub(crate) at: [u32; 2],
}

impl Place {
    /// A sample of it, around the source's periodic axes.
    pub(crate) fn sample(self, exemplars: &Exemplars<2>, by: [u32; 2]) -> [u32; 2] {
        let shape = exemplars.sources()[self.source as usize].domain().shape;
        [0, 1].map(|a| (self.at[a] + by[a]) % shape[a])
    }

    /// What stands at a distance from it, around the source's periodic axes; `None` beyond open edges.
    pub(crate) fn moved(self, exemplars: &Exemplars<2>, by: [i32; 2]) -> Option<Self> {
        let domain = exemplars.sources()[self.source as usize].domain();
        domain.step(self.at, by).map(|at| Self { at, ..self })
    }

    pub(crate) fn id(self, exemplars: &Exemplars<2>, by: [u32; 2]) -> SampleId {
        exemplars.table().id(self.source as usize, self.sample(exemplars, by))
    }
}

/// A random one for each neighborhood: what the algorithm starts from. `[Kwatra05 3]`
///
/// `None` if no neighborhood of the exemplars is valid.
pub(crate) fn random(exemplars: &Exemplars<2>, all: &Neighborhoods, seed: Seed) -> Option<Vec<Place>> {
    let of = |(source, s): (usize, _)| places(s, all.size).map(move |at| Place { source: source as u32, at });
    let sources = exemplars.sources().iter().map(AsRef::as_ref).enumerate();
    let offered: Vec<Place> = sources.flat_map(of).collect();
    if offered.is_empty() {
        return None;
    }
    let draw = |number: usize| {
        let mut rng = seed.derive("texture-optimization/start", number as u64).rng();
        offered[rng.below(offered.len() as u32) as usize]
    };
    Some((0..all.len()).map(draw).collect())
}
