//! Where exemplars fit that may be moved along some axes alone, as clips in time: few enough places to compare each by
//! itself. `[Kwatra03 7B]`

use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Look, Patch, Source, Window, par};

use crate::candidates::Candidate;
use crate::squares::squares;
use crate::usable::Usable;

/// Compares what is known in `window` with the sources, moved along the free axes alone, wherever one covers `region`,
/// a part of it, with samples that are all valid. What else sticks out of a source, or is not valid there, is not
/// compared.
///
/// # Complexity
/// `O(offsets window)`: a clip of 60 frames of 240 x 132 over a region of 10 frames takes 50 million differences, a
/// tenth of what the transforms of a search along all axes would.
pub(crate) fn slide<const D: usize>(
    exemplars: &Exemplars<D>,
    look: &Look,
    (region, window): (&Window<D>, &Window<D>),
    free: [bool; D],
    usable: Usable,
) -> Vec<Candidate<D>> {
    let mut patches = Vec::new();
    for (source, of) in exemplars.sources().iter().enumerate().filter(|&(source, _)| usable.has(source)) {
        let along = |a: usize| offsets(of.domain(), region, a, free[a]);
        let ranges: [Vec<i32>; D] = std::array::from_fn(along);
        let counts = Domain::open(std::array::from_fn::<_, D, _>(|a| ranges[a].len() as u32));
        patches.extend(counts.positions().map(|at| {
            let offset = std::array::from_fn(|a| ranges[a][at[a] as usize]);
            Patch { source, offset }
        }));
    }
    let compared = par::map_indexed(patches.len(), |i| {
        let patch = patches[i];
        let sides = Sides { source: &exemplars.sources()[patch.source], weights: exemplars.weights(), look, window };
        sides.covers(&patch, region).then(|| sides.candidate(patch))
    });
    compared.into_iter().flatten().collect()
}

/// The offsets along an axis at which a source covers a region.
fn offsets<const D: usize>(source: Domain<D>, region: &Window<D>, axis: usize, free: bool) -> Vec<i32> {
    let (start, side) = (region.start[axis], source.shape[axis] as i32);
    match (free, source.periodic[axis]) {
        (true, true) => (0..side).collect(),
        (true, false) => (region.end(axis) - side..=start).collect(),
        (false, true) => vec![0],
        (false, false) => (0..i32::from(0 <= start && region.end(axis) <= side)).collect(),
    }
}

/// What is known, and a source that is laid over it.
struct Sides<'a, const D: usize> {
    source: &'a Source<D>,
    weights: &'a [u8],
    look: &'a Look,
    window: &'a Window<D>,
}

impl<const D: usize> Sides<'_, D> {
    /// True if all samples that the patch shows in a region are valid.
    fn covers(&self, patch: &Patch<D>, region: &Window<D>) -> bool {
        let Some(valid) = &self.source.valid else { return true };
        let moved = region.moved(patch.offset.map(|n| -n));
        moved.places(self.source.domain()).all(|place| place.is_some_and(|place| valid.plane(0)[place]))
    }

    /// The mean squared difference where both are known.
    fn candidate(&self, patch: Patch<D>) -> Candidate<D> {
        let domain = self.source.domain();
        let (len, known) = (self.window.len(), self.look.known());
        let valid = self.source.valid.as_deref().map(|v| v.plane(0));
        let (mut sum, mut samples) = (0_u64, 0_u64);
        for (first, run) in runs(&self.window.moved(patch.offset.map(|n| -n)), domain) {
            let known = &known[first..][..run.len()];
            let used = |i: usize| known[i] && valid.is_none_or(|v| v[run.start + i]);
            let whole = valid.is_none() && !known.contains(&false);
            samples += if whole { run.len() as u64 } else { (0..run.len()).filter(|&i| used(i)).count() as u64 };
            for (c, &weight) in self.weights.iter().enumerate() {
                let here = &self.look.features()[c * len + first..][..run.len()];
                let there = &self.source.features.plane(c)[run.clone()];
                let of = if whole {
                    squares(here, there)
                } else {
                    let used = (0..run.len()).filter(|&i| used(i));
                    used.map(|i| u64::from(here[i].abs_diff(there[i])).pow(2)).sum()
                };
                sum += of * u64::from(weight);
            }
        }
        Candidate { patch, cost: sum as f64 / samples.max(1) as f64 }
    }
}

/// Stretches of a window that stand side by side in a domain: where each begins in the window, and its places in the
/// domain.
fn runs<const D: usize>(window: &Window<D>, domain: Domain<D>) -> Box<dyn Iterator<Item = (usize, Range<usize>)>> {
    let last = D - 1;
    if domain.periodic[last] {
        let places = window.places(domain).enumerate();
        return Box::new(places.filter_map(|(i, place)| place.map(|place| (i, place..place + 1))));
    }
    let row = window.shape[last] as usize;
    let from = (-window.start[last]).max(0);
    let len = window.end(last).min(domain.shape[last] as i32) - window.start[last] - from;
    let mut firsts = *window;
    firsts.start[last] += from;
    firsts.shape[last] = u32::from(0 < len);
    let runs = firsts.places(domain).enumerate();
    Box::new(
        runs.filter_map(move |(i, place)| place.map(|place| (i * row + from as usize, place..place + len as usize))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::{Matcher, Matches};
    use selvedge_core::{Grid, Origin, SampleId, Seed, SimdLevel, SourceMap, Transform};

    fn exemplars(case: u64) -> Exemplars<3> {
        let mut rng = Seed(case).rng();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let mut source = |shape| {
            let domain = Domain { shape, periodic: [case % 4 == 3, false, false] };
            let noise: Vec<u8> = (0..2 * domain.len()).map(|_| rng.below(256) as u8).collect();
            // Seldom masked, so that some patches cover the region.
            let valid = (0..domain.len()).map(|_| 0 < rng.below(40)).collect();
            let valid = (case % 2 == 1).then(|| Grid::from_vec(domain, 1, valid).unwrap());
            Source { features: Grid::from_vec(domain, 2, noise).unwrap(), valid: valid.map(Into::into), origin }
        };
        Exemplars::from_sources(vec![source([9, 6, 7]), source([6, 5, 8])], vec![1, 3]).unwrap()
    }

    #[test]
    fn what_slides_is_what_a_full_search_finds_among_offsets_in_time() {
        let mut found = 0;
        for case in 0..40 {
            let (e, mut rng) = (exemplars(case), Seed(100 + case).rng());
            let output = Domain { shape: [12, 4, 6], periodic: [case % 3 == 0, false, false] };
            let mut map = SourceMap::unassigned(&e, output).unwrap();
            for id in map.ids.plane_mut(0) {
                let sample = rng.below(e.table().len());
                *id = if rng.below(3) == 0 { SampleId::UNASSIGNED } else { SampleId::new(sample) };
            }
            let region = Window { start: [rng.below(8) as i32, 0, 0], shape: [2, 4, 6] };
            let entire = Window { start: [region.start[0] - 3, 0, 0], shape: [7, 4, 6] };
            for window in [region, entire] {
                let costs = |free: [bool; 3]| {
                    let matcher = Matcher::new(&e, &[], ([1; 3], free), SimdLevel::Auto).unwrap();
                    let mut matches = Matches::default();
                    matcher.search(&map, &region, &window, Usable::all(), &mut matches).unwrap();
                    let turned = |mut patch: Patch<3>| {
                        let side = e.sources()[patch.source].domain();
                        if side.periodic[0] {
                            patch.offset[0] = patch.offset[0].rem_euclid(side.shape[0] as i32);
                        }
                        patch
                    };
                    let still = matcher.found(&matches).filter(|c| c.patch.offset[1..] == [0, 0]);
                    let mut all: Vec<(Patch<3>, f64)> = still.map(|c| (turned(c.patch), c.cost)).collect();
                    all.sort_by_key(|found| found.0);
                    all
                };
                let slid = costs([true, false, false]);
                assert_eq!(slid, costs([true; 3]), "case {case}");
                found += slid.len();
            }
        }
        assert!(200 < found, "{found} places in all");
    }
}
