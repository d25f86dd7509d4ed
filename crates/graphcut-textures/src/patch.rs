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

    /// The same patch with its offset wrapped into the output on periodic axes: equal keys are equal placements.
    pub(crate) fn wrapped(&self, output: Domain<D>) -> Self {
        let mut patch = *self;
        for axis in (0..D).filter(|&a| output.periodic[a]) {
            patch.offset[axis] = patch.offset[axis].rem_euclid(output.shape[axis] as i32);
        }
        patch
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
