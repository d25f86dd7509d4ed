//! Where patches were laid before.

use std::collections::{BTreeMap, BTreeSet};

use selvedge_core::{Domain, Patch};

/// Vectors in one cell of so many samples a side count as the same: cuts and refinement lay copies a few samples off,
/// and the eye finds such rows as well. With 1 only exact repetitions would count; a grain as large as structures are
/// would forbid neighbours that show something else. What lies between is a guess.
const GRAIN: i32 = 4;

/// Repeated vectors are counted out of so many patches. A count alone grows with the output, and on large ones nothing
/// but variety would be left; a share alone makes the first repetition of a run's second patch weigh as much as that of
/// all. So below that many patches a repetition counts whole.
const OF: u32 = 64;

/// Offsets used before, and how patches stand to each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct History<const D: usize> {
    pub(crate) used: BTreeSet<Patch<D>>,
    pub(crate) vectors: BTreeMap<(usize, [i32; D]), u32>,
    /// Patches whose vectors were noted.
    pub(crate) noted: u32,
}

impl<const D: usize> History<D> {
    /// True if this offset was used before.
    pub(crate) fn is_used(&self, patch: &Patch<D>, source: Domain<D>, output: Domain<D>) -> bool {
        self.used.contains(&patch.wrapped(source, output))
    }

    /// Forgets used offsets: when there is no other left.
    pub(crate) fn forget_used(&mut self) {
        self.used.clear();
    }

    /// Notes an offset as tried.
    pub(crate) fn note_used(&mut self, patch: &Patch<D>, source: Domain<D>, output: Domain<D>) {
        self.used.insert(patch.wrapped(source, output));
    }

    /// Notes how a patch stands to its neighbours.
    pub(crate) fn note_vectors(&mut self, patch: &Patch<D>, neighbours: &[Patch<D>]) {
        self.noted += 1;
        for key in neighbours.iter().filter_map(|n| vector(patch, n)) {
            *self.vectors.entry(key).or_default() += 1;
        }
    }

    /// How often patches stood to each other as this one would to its neighbours, out of [`OF`] patches: an output has
    /// no more of a lattice because there is more of it.
    pub(crate) fn repeats(&self, patch: &Patch<D>, neighbours: &[Patch<D>]) -> f64 {
        let times: u32 = neighbours.iter().map(|n| self.times(patch, n)).sum();
        f64::from(times) * f64::from(OF) / f64::from(self.noted.max(OF))
    }

    /// How often patches stood to each other as these two do.
    pub(crate) fn times(&self, one: &Patch<D>, other: &Patch<D>) -> u32 {
        vector(one, other).and_then(|key| self.vectors.get(&key)).copied().unwrap_or(0)
    }
}

/// The vector between two patches of one source, coarsened, with one sign for both directions.
fn vector<const D: usize>(a: &Patch<D>, b: &Patch<D>) -> Option<(usize, [i32; D])> {
    if a.source != b.source {
        return None;
    }
    let v: [i32; D] = std::array::from_fn(|axis| a.offset[axis] - b.offset[axis]);
    let negative = v.iter().find(|&&c| c != 0).is_some_and(|&c| c < 0);
    let v = if negative { v.map(|c| -c) } else { v };
    Some((a.source, v.map(|c| (c + GRAIN / 2).div_euclid(GRAIN))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(y: i32, x: i32) -> Patch<2> {
        Patch { source: 0, offset: [y, x] }
    }

    #[test]
    fn equal_placements_are_used_once() {
        let (source, output) = (Domain::open([9, 9]), Domain { shape: [20, 30], periodic: [false, true] });
        let mut history = History::default();
        history.note_used(&patch(3, -5), source, output);
        assert!(history.is_used(&patch(3, 25), source, output), "around the output");
        assert!(!history.is_used(&patch(23, -5), source, output) && !history.is_used(&patch(3, -4), source, output));
        let torus = Domain::periodic([9, 9]);
        history.note_used(&patch(1, 2), torus, output);
        assert!(history.is_used(&patch(-8, 11), torus, output), "around the source");
        history.forget_used();
        assert!(!history.is_used(&patch(3, -5), source, output));
    }

    #[test]
    fn vectors_are_told_apart_in_steps_of_four_samples() {
        let same = |a: [i32; 2], b: [i32; 2]| {
            vector(&patch(a[0], a[1]), &patch(0, 0)) == vector(&patch(b[0], b[1]), &patch(0, 0))
        };
        assert!(same([10, 40], [13, 41]) && same([12, 0], [13, 1]) && same([-10, 7], [10, -7]));
        assert!(!same([10, 40], [14, 40]) && !same([9, 40], [10, 40]) && !same([10, 40], [10, -40]));
    }

    #[test]
    fn what_stood_so_before_is_found_among_all_that_was_laid() {
        let mut rng = selvedge_core::Seed(3).rng();
        for case in 0..50 {
            let mut any = || patch(rng.below(40) as i32 - 20, rng.below(40) as i32 - 20);
            let (mut history, mut laid) = (History::default(), Vec::new());
            for _ in 0..12 {
                let (one, neighbours) = (any(), [any(), any()]);
                let times = |n| laid.iter().filter(|&&(a, b)| vector(&a, &b) == vector(&one, n)).count() as u32;
                assert_eq!(
                    neighbours.each_ref().map(|n| history.times(&one, n)),
                    neighbours.each_ref().map(times),
                    "{case}"
                );
                history.note_vectors(&one, &neighbours);
                laid.extend(neighbours.map(|n| (n, one)));
            }
        }
    }

    #[test]
    fn vectors_are_counted_in_both_directions_and_by_the_number_of_patches() {
        let mut history = History::default();
        history.note_vectors(&patch(0, 0), &[patch(10, 40)]);
        assert_eq!(history.repeats(&patch(50, 90), &[patch(40, 50)]), 1.0);
        assert_eq!(history.repeats(&patch(50, 90), &[patch(60, 130), patch(40, 50)]), 2.0);
        assert_eq!(history.repeats(&patch(50, 90), &[patch(60, 90)]), 0.0);
        assert_eq!(history.repeats(&patch(0, 0), &[Patch { source: 1, offset: [10, 40] }]), 0.0);
        (1..256).for_each(|_| history.note_vectors(&patch(0, 0), &[]));
        assert_eq!(history.repeats(&patch(50, 90), &[patch(40, 50)]), 0.25);
    }
}
