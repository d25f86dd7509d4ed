//! A region of a map and what lies around it, cut out, so that regions can be tried beside each other.

use selvedge_core::{Domain, Error, SampleId, SeamCosts, Window, collected, reserve, try_vec};

use crate::canvas::Canvas;
use crate::neighborhood::REACH;

/// A region is grown by so much at most in all.
pub(crate) const GROWN: u32 = 4;
/// How far around a region something is looked at: neighborhoods around it when it is grown, one sample more than
/// seams ask for.
pub(crate) const AROUND: u32 = GROWN + REACH as u32 + 1;

/// Some samples of a map, by themselves.
pub(crate) struct Site {
    window: Window<2>,
    output: Domain<2>,
    pub(crate) canvas: Canvas,
    /// By place, whether the region at hand has it; all false between calls.
    taken: Vec<bool>,
}

impl Site {
    /// Cuts out what stands around a region.
    pub(crate) fn new(canvas: &Canvas, region: &[usize]) -> Result<Self, Error> {
        let output = canvas.domain();
        let window = window_of(output, region)?.grown(output, [AROUND; 2], [AROUND; 2]);
        let canvas = canvas.cut(&window)?;
        let taken = try_vec(window.len(), false)?;
        Ok(Self { window, output, canvas, taken })
    }

    /// Places of the map as places here, in order.
    pub(crate) fn here(&self, places: &[usize]) -> Result<Vec<usize>, Error> {
        let here = |&place: &usize| {
            let at = self.window.unwrapped(self.output, self.output.position(place));
            let at = [0, 1].map(|a| (at[a] - self.window.start[a]) as u32);
            self.canvas.domain().index(at)
        };
        let mut here: Vec<usize> = collected(places.iter().map(here))?;
        here.sort_unstable();
        Ok(here)
    }

    /// The place of the map that a place here is.
    pub(crate) fn there(&self, place: usize) -> usize {
        let at = self.canvas.domain().position(place);
        self.output.index(self.window.position(self.output, at).expect("a window inside of the output"))
    }

    /// A region and what lies around it, but for fixed samples and holes.
    pub(crate) fn grown(&mut self, region: &[usize], by: u32) -> Result<Vec<usize>, Error> {
        let (domain, by) = (self.canvas.domain(), by as i32);
        let side = 2 * by + 1;
        let mut grown: Vec<usize> = Vec::new();
        for &place in region {
            let at = domain.position(place);
            let around = (0..side * side).filter_map(|i| domain.step(at, [i / side - by, i % side - by]));
            for to in around.map(|to| domain.index(to)) {
                let may = !self.taken[to] && !self.canvas.is_fixed(to) && self.canvas.id(to).is_assigned();
                if may {
                    reserve(&mut grown, 1)?;
                    grown.push(to);
                    self.taken[to] = true;
                }
            }
        }
        grown.iter().for_each(|&place| self.taken[place] = false);
        grown.sort_unstable();
        Ok(grown)
    }

    /// What all seams cost that a region's samples have a part in, each once, by some measures.
    pub(crate) fn prices(&mut self, region: &[usize], measures: [&SeamCosts<2>; 2]) -> [i64; 2] {
        let domain = self.canvas.domain();
        region.iter().for_each(|&place| self.taken[place] = true);
        let mut sums = [0; 2];
        let mut add = |at: [u32; 2], axis: usize| {
            let prices = measures.map(|costs| i64::from(costs.at(&self.canvas.map, at, axis)));
            sums = [sums[0] + prices[0], sums[1] + prices[1]];
        };
        for &place in region {
            let at = domain.position(place);
            for axis in 0..2 {
                add(at, axis);
                let mut back = [0; 2];
                back[axis] = -1;
                let before = domain.step(at, back).filter(|&before| !self.taken[domain.index(before)]);
                before.into_iter().for_each(|before| add(before, axis));
            }
        }
        region.iter().for_each(|&place| self.taken[place] = false);
        sums
    }

    /// What stands at some places.
    pub(crate) fn ids(&self, places: &[usize]) -> Result<Vec<SampleId>, Error> {
        collected(places.iter().map(|&place| self.canvas.id(place)))
    }
}

/// The smallest window that has all of some places, whole axes where they lie all around.
fn window_of(output: Domain<2>, places: &[usize]) -> Result<Window<2>, Error> {
    let mut window = Window::all(output);
    for axis in 0..2 {
        let mut along: Vec<u32> = collected(places.iter().map(|&place| output.position(place)[axis]))?;
        along.sort_unstable();
        along.dedup();
        let (Some(&first), Some(&last)) = (along.first(), along.last()) else { continue };
        let side = output.shape[axis];
        let (mut start, mut end) = (first as i32, last as i32 + 1);
        if output.periodic[axis] {
            // Around the widest gap.
            for pair in along.windows(2) {
                if end - start > (side - (pair[1] - pair[0]) + 1) as i32 {
                    (start, end) = (pair[1] as i32 - side as i32, pair[0] as i32 + 1);
                }
            }
        }
        let reached = (end - start) as u32 + 2 * AROUND;
        if !output.periodic[axis] || reached < side {
            (window.start[axis], window.shape[axis]) = (start, (end - start) as u32);
        }
    }
    Ok(window)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Exemplars, Grid, Origin, Rng, SeamMeasure, Seed, Source, SourceMap, Start, Transform};

    fn random(output: Domain<2>, rng: &mut Rng) -> (Exemplars<2>, Canvas) {
        let domain = Domain::open([6, 6]);
        let features = Grid::from_vec(domain, 1, (0..36).map(|_| rng.below(256) as u8).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        map.ids.plane_mut(0).iter_mut().for_each(|id| *id = SampleId::new(rng.below(36)));
        (exemplars, Canvas::new(Start { map, fixed: None, sources: None }).unwrap())
    }

    #[test]
    fn a_region_costs_each_seam_that_it_touches_once() {
        let mut rng = Seed(4).rng();
        for shape in [[5, 7], [40, 7], [50, 90]] {
            let output = Domain { shape, periodic: [true, false] };
            let (exemplars, canvas) = random(output, &mut rng);
            let measures = [SeamMeasure::Difference, SeamMeasure::Gradient];
            let costs = measures.map(|measure| SeamCosts::new(&exemplars, measure).unwrap());
            for _ in 0..20 {
                let near = [rng.below(shape[0]), rng.below(4)];
                let is_near = |[y, x]: [u32; 2]| (y + shape[0] - near[0]) % shape[0] < 6 && x.abs_diff(near[1]) < 4;
                let all = 0..output.len();
                let region: Vec<usize> = all.filter(|&i| is_near(output.position(i)) && rng.below(3) == 0).collect();
                let mut expected = [0; 2];
                for (at, axis) in output.positions().flat_map(|at| [(at, 0), (at, 1)]) {
                    let ends = [Some(at), output.next(at, axis)].into_iter().flatten().map(|end| output.index(end));
                    if ends.into_iter().any(|end| region.contains(&end)) {
                        (0..2).for_each(|m| expected[m] += i64::from(costs[m].at(&canvas.map, at, axis)));
                    }
                }
                let mut site = Site::new(&canvas, &region).unwrap();
                let here = site.here(&region).unwrap();
                let mut back: Vec<usize> = here.iter().map(|&place| site.there(place)).collect();
                assert_eq!(site.prices(&here, [&costs[0], &costs[1]]), expected, "{region:?}");
                assert!(here.iter().zip(&back).all(|(&here, &there)| site.canvas.id(here) == canvas.id(there)));
                back.sort_unstable();
                assert_eq!(back, region);
            }
        }
    }

    #[test]
    fn a_window_goes_around_the_widest_gap() {
        let output = Domain { shape: [9, 100], periodic: [false, true] };
        let place = |at: [u32; 2]| output.index(at);
        let window =
            |places: &[[u32; 2]]| window_of(output, &places.iter().map(|&at| place(at)).collect::<Vec<_>>()).unwrap();
        assert_eq!(window(&[[2, 3], [4, 99], [3, 97]]), Window { start: [2, -3], shape: [3, 7] });
        assert_eq!(window(&[[2, 3], [2, 30]]), Window { start: [2, 3], shape: [1, 28] });
        let all_around: Vec<[u32; 2]> = (0..7).map(|x| [x, 15 * x]).collect();
        assert_eq!(window(&all_around), Window { start: [0, 0], shape: [7, 100] }, "it comes too near itself");
    }
}
