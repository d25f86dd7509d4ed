//! A source laid over the output.

use selvedge_core::{Domain, Exemplars};

use crate::window::Window;

/// A translation of a source. `[Kwatra03 4]`
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Patch<const D: usize> {
    /// The source.
    pub(crate) source: usize,
    /// Output position = source position + offset; not wrapped.
    pub(crate) offset: [i32; D],
}

impl<const D: usize> Patch<D> {
    /// The part of the output that the whole source covers, not clipped. A periodic source covers every axis around
    /// which it wraps, from `around` on.
    pub(crate) fn footprint(&self, exemplars: &Exemplars<D>, around: &Window<D>) -> Window<D> {
        let domain = exemplars.sources()[self.source].domain();
        let mut footprint = Window { start: self.offset, shape: domain.shape };
        for axis in (0..D).filter(|&a| domain.periodic[a]) {
            (footprint.start[axis], footprint.shape[axis]) = (around.start[axis], around.shape[axis]);
        }
        footprint
    }

    /// The same patch with its offset wrapped around periodic axes of its source and of the output: equal keys are
    /// equal placements. (Around a source whose side does not go into the output's, only the source counts.)
    pub(crate) fn wrapped(&self, source: Domain<D>, output: Domain<D>) -> Self {
        let mut patch = *self;
        for axis in 0..D {
            let side = if source.periodic[axis] {
                source.shape[axis]
            } else if output.periodic[axis] {
                output.shape[axis]
            } else {
                continue;
            };
            patch.offset[axis] = patch.offset[axis].rem_euclid(side as i32);
        }
        patch
    }

    /// True if two patches show about the same place of an exemplar in a region, in different orientations. The exemplar
    /// meets its own reflection there: seams cost next to nothing, but the eye finds the symmetry at once.
    pub(crate) fn reflects(&self, other: &Self, exemplars: &Exemplars<D>, region: &Window<D>) -> bool {
        let [a, b] = [self, other].map(|p| exemplars.sources()[p.source].origin);
        if D < 2 || a.exemplar != b.exemplar || a.transform.orientation() == b.transform.orientation() {
            return false;
        }
        let [here, there] = [self, other].map(|p| p.place(exemplars, region));
        let side = f64::from(region.shape[D - 2].max(region.shape[D - 1]));
        (0..2).all(|axis| (here[axis] - there[axis]).abs() < 1.5 * side)
    }

    /// The exemplar's place under the middle of a region, on the last two axes, from the exemplar's centre.
    fn place(&self, exemplars: &Exemplars<D>, region: &Window<D>) -> [f64; 2] {
        let source = &exemplars.sources()[self.source];
        let from_centre = |axis: usize| {
            let middle = f64::from(region.start[axis] - self.offset[axis]) + f64::from(region.shape[axis]) / 2.0;
            middle - f64::from(source.domain().shape[axis]) / 2.0
        };
        source.origin.transform.from_centre([from_centre(D - 2), from_centre(D - 1)])
    }

    /// For each coordinate of a window along an axis, the place in the source's buffer, times its stride; `None`
    /// outside of the source.
    pub(crate) fn places(
        &self,
        source: Domain<D>,
        window: &Window<D>,
        axis: usize,
    ) -> impl Iterator<Item = Option<u32>> + use<D> {
        let (stride, side) = (source.strides()[axis] as u32, source.shape[axis] as i32);
        let (periodic, first) = (source.periodic[axis], window.start[axis] - self.offset[axis]);
        (0..window.shape[axis] as i32).map(move |l| {
            let p = if periodic { (first + l).rem_euclid(side) } else { first + l };
            (0 <= p && p < side).then(|| p as u32 * stride)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Source, Transform};

    #[test]
    fn reflections_are_found_where_they_meet() {
        let source = |mirror| {
            let features = Grid::from_vec(Domain::open([40, 60]), 1, vec![0; 2400]).unwrap();
            let transform = Transform::Exact { quarter_turns: 0, mirror };
            Source { features, valid: None, origin: Origin { exemplar: 0, transform } }
        };
        let exemplars = Exemplars::from_sources(vec![source(false), source(true)], vec![1]).unwrap();
        let plain = Patch { source: 0, offset: [0, 0] };
        // A copy mirrored about x = 59.5 meets the plain one at its right end.
        let mirrored = Patch { source: 1, offset: [0, 60] };
        let region = |x: i32| Window { start: [10, x], shape: [8, 8] };
        assert!(mirrored.reflects(&plain, &exemplars, &region(56)));
        assert!(!mirrored.reflects(&plain, &exemplars, &region(30)));
        let lower = Patch { source: 1, offset: [14, 60] };
        assert!(!lower.reflects(&plain, &exemplars, &region(56)), "other rows of the exemplar");
        assert!(!plain.reflects(&Patch { source: 0, offset: [0, 3] }, &exemplars, &region(30)), "one orientation");
    }
}
