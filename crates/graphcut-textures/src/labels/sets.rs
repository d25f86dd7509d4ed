//! Which labels may show where.

use selvedge_core::{Domain, Exemplars, Grid, SampleId, Start, Window};

use crate::error::Error;
use crate::labels::label::Label;
use crate::labels::options::LabelOptions;

/// Labels, and what says where each may show.
pub(super) struct Sets<'a, const D: usize> {
    pub(super) exemplars: &'a Exemplars<D>,
    pub(super) labels: &'a [Label<D>],
    output: Domain<D>,
    only: Option<&'a Grid<u64, D>>,
    sources: Option<Grid<u64, D>>,
}

impl<'a, const D: usize> Sets<'a, D> {
    pub(super) fn new(
        exemplars: &'a Exemplars<D>,
        labels: &'a [Label<D>],
        options: &'a LabelOptions<D>,
        start: &mut Start<D>,
    ) -> Self {
        Self::of(exemplars, labels, options, start.map.domain(), start.sources.take())
    }

    pub(super) fn of(
        exemplars: &'a Exemplars<D>,
        labels: &'a [Label<D>],
        options: &'a LabelOptions<D>,
        output: Domain<D>,
        sources: Option<Grid<u64, D>>,
    ) -> Self {
        Self { exemplars, labels, output, only: options.only.as_ref(), sources }
    }

    /// The sample of a label at a position given unwrapped: in this turn of periodic axes, or in the turn in which the
    /// source has it.
    pub(super) fn sample(&self, label: usize, at: [i32; D]) -> SampleId {
        let Label { source, offset } = self.labels[label];
        let of = &self.exemplars.sources()[source];
        let domain = of.domain();
        let mut from = [0; D];
        for axis in 0..D {
            let (mut place, side) = (at[axis] - offset[axis], domain.shape[axis] as i32);
            if domain.periodic[axis] {
                place = place.rem_euclid(side);
            } else if !(0..side).contains(&place) {
                if !self.output.periodic[axis] {
                    return SampleId::UNASSIGNED;
                }
                place = place.rem_euclid(self.output.shape[axis] as i32);
                if side <= place {
                    return SampleId::UNASSIGNED;
                }
            }
            from[axis] = place as u32;
        }
        let valid = of.valid.as_deref().is_none_or(|valid| valid.get(0, from));
        if valid { self.exemplars.table().id(source, from) } else { SampleId::UNASSIGNED }
    }

    /// True if the caller lets a label show at a place.
    pub(super) fn lets(&self, label: usize, place: usize) -> bool {
        self.only.is_none_or(|only| only.plane(0)[place] >> label & 1 == 1)
            && self.sources.as_ref().is_none_or(|s| s.plane(0)[place] >> self.labels[label].source & 1 == 1)
    }

    pub(super) fn output(&self) -> Domain<D> {
        self.output
    }

    /// The labels that may show at a place, as bits.
    pub(super) fn at(&self, place: usize) -> u64 {
        let at = self.output.position(place).map(|p| p as i32);
        let shows = |label: &usize| self.lets(*label, place) && self.sample(*label, at).is_assigned();
        (0..self.labels.len()).filter(shows).fold(0, |bits, label| bits | 1 << label)
    }

    /// What of a window a label can reach.
    pub(super) fn reach(&self, label: usize, window: &Window<D>) -> Option<Window<D>> {
        if self.output.periodic.contains(&true) {
            return Some(*window);
        }
        self.labels[label].footprint(self.exemplars, window).shared(window)
    }

    /// True if the source of a label has all of a window, without going around.
    fn holds(&self, label: usize, window: &Window<D>) -> bool {
        let Label { source, offset } = self.labels[label];
        let from = window.moved(offset.map(|o| -o));
        from.inside(Domain::open(self.exemplars.sources()[source].domain().shape)) == from
    }

    /// What a label offers over a window, row-major.
    pub(super) fn offered(&self, label: usize, window: &Window<D>) -> Result<Vec<SampleId>, Error> {
        let mut offered = selvedge_core::try_vec(window.len(), SampleId::UNASSIGNED)?;
        if !self.output.periodic.contains(&true) || self.holds(label, window) {
            offered.iter_mut().zip(self.labels[label].samples(self.exemplars, window)).for_each(|(to, id)| *to = id);
            return Ok(offered);
        }
        for (id, local) in offered.iter_mut().zip(window.local().positions()) {
            *id = self.sample(label, std::array::from_fn(|a| window.start[a] + local[a] as i32));
        }
        Ok(offered)
    }
}
