//! Where patches were laid before.

use std::collections::{BTreeMap, BTreeSet};

use selvedge_core::Domain;

use crate::patch::Patch;

/// Vectors that differ by less than this along each axis count as the same.
const GRAIN: i32 = 4;

/// Offsets used before, and how patches stand to each other.
#[derive(Debug, Default)]
pub(crate) struct History<const D: usize> {
    used: BTreeSet<Patch<D>>,
    vectors: BTreeMap<(usize, [i32; D]), u32>,
}

impl<const D: usize> History<D> {
    /// True if this offset was used before.
    pub(crate) fn is_used(&self, patch: &Patch<D>, output: Domain<D>) -> bool {
        self.used.contains(&patch.wrapped(output))
    }

    /// Forgets used offsets: when there is no other left.
    pub(crate) fn forget_used(&mut self) {
        self.used.clear();
    }

    /// Notes an offset as tried.
    pub(crate) fn note_used(&mut self, patch: &Patch<D>, output: Domain<D>) {
        self.used.insert(patch.wrapped(output));
    }

    /// Notes how a patch stands to its neighbours.
    pub(crate) fn note_vectors(&mut self, patch: &Patch<D>, neighbours: &[Patch<D>]) {
        for key in neighbours.iter().filter_map(|n| vector(patch, n)) {
            *self.vectors.entry(key).or_default() += 1;
        }
    }

    /// How often patches stood to each other as this one would to its neighbours.
    pub(crate) fn repeats(&self, patch: &Patch<D>, neighbours: &[Patch<D>]) -> u32 {
        let count = |n: &Patch<D>| vector(patch, n).and_then(|key| self.vectors.get(&key)).copied().unwrap_or(0);
        neighbours.iter().map(count).sum()
    }
}

/// The vector between two patches of one source, coarsened, with one sign for both directions.
fn vector<const D: usize>(a: &Patch<D>, b: &Patch<D>) -> Option<(usize, [i32; D])> {
    if a.source != b.source {
        return None;
    }
    let v: [i32; D] = std::array::from_fn(|axis| (a.offset[axis] - b.offset[axis] + GRAIN / 2).div_euclid(GRAIN));
    let negative = v.iter().find(|&&c| c != 0).is_some_and(|&c| c < 0);
    Some((a.source, if negative { v.map(|c| -c) } else { v }))
}
