//! A map, and what blending has to know besides.

use selvedge_core::{Domain, Grid, SampleId, SourceMap};

use crate::Error;
use crate::region::{Patch, Window};

/// A map, what of its sources may show, and where it is copied.
#[derive(Clone, Debug)]
pub(crate) struct Laid<'m, const D: usize> {
    pub(crate) map: &'m SourceMap<D>,
    /// By source: which of its samples may show.
    valid: Vec<Option<&'m Grid<bool, D>>>,
    /// Positions that are copied, whatever is near.
    pub(crate) kept: Option<&'m Grid<bool, D>>,
}

impl<'m, const D: usize> Laid<'m, D> {
    pub(crate) fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>) -> Result<Self, Error> {
        if map.ids.channels() != 1 {
            return Err(Error::Channels { found: map.ids.channels() });
        }
        let samples = map.table.len();
        if let Some(id) = map.ids.plane(0).iter().find(|id| id.is_assigned() && samples <= id.get()) {
            return Err(selvedge_core::Error::UnknownSample { id: id.get(), samples: samples.into() }.into());
        }
        let of_sources = valid.iter().map(|v| v.map(Grid::domain)).chain(std::iter::repeat(None));
        for ((_, domain), found) in map.table.sources().iter().zip(of_sources) {
            check_shape("validity of a source", *domain, found)?;
        }
        Ok(Self { map, valid, kept: None })
    }

    pub(crate) fn keeping(mut self, kept: &'m Grid<bool, D>) -> Result<Self, Error> {
        check_shape("mask of fixed samples", self.map.domain(), Some(kept.domain()))?;
        self.kept = Some(kept);
        Ok(self)
    }

    /// A box and what is `margin` around it: as far as the output reaches on open axes, around periodic ones as often as
    /// that goes.
    pub(crate) fn around(&self, inner: &Window<D>, margin: u32) -> Window<D> {
        let output = self.map.domain();
        let mut outer = *inner;
        for axis in 0..D {
            let (mut start, mut end) = (inner.start[axis] - margin as i32, inner.end(axis) + margin as i32);
            if !output.periodic[axis] {
                (start, end) = (start.max(0), end.min(output.shape[axis] as i32));
            }
            (outer.start[axis], outer.shape[axis]) = (start, (end - start) as u32);
        }
        outer
    }

    /// A patch's samples over a window, row-major; unassigned outside of its source and where that is not valid.
    pub(crate) fn samples_of(&self, patch: &Patch<D>, window: &Window<D>, to: &mut Vec<SampleId>) {
        let source = self.map.table.sources()[patch.source].1;
        let first = self.map.table.first(patch.source);
        let valid = self.valid.get(patch.source).copied().flatten().map(|v| v.plane(0));
        to.clear();
        to.resize(window.len(), SampleId::UNASSIGNED);
        let (last, width) = (D - 1, window.shape[D - 1] as usize);
        for (row, to) in to.chunks_exact_mut(width).enumerate() {
            let at = window.row(row);
            let Some(base) = row_of(source, patch, &at) else { continue };
            let (begin, side) = (at[last] - patch.offset[last], source.shape[last] as i32);
            for (x, to) in (begin..).zip(to) {
                let x = if source.periodic[last] { x.rem_euclid(side) } else { x };
                if (0..side).contains(&x) {
                    let place = base + x as u32;
                    if valid.is_none_or(|v| v[place as usize]) {
                        *to = SampleId::new(first + place);
                    }
                }
            }
        }
    }
}

/// Place in a source's buffer where the row begins in which a position of the output lies; `None` outside of open axes.
fn row_of<const D: usize>(source: Domain<D>, patch: &Patch<D>, at: &[i32; D]) -> Option<u32> {
    let mut place = 0;
    for (axis, at) in at.iter().enumerate().take(D - 1) {
        let (p, side) = (at - patch.offset[axis], source.shape[axis] as i32);
        let p = if source.periodic[axis] { p.rem_euclid(side) } else { p };
        if !(0..side).contains(&p) {
            return None;
        }
        place = (place + p as u32) * source.shape[axis + 1];
    }
    Some(place)
}

fn check_shape<const D: usize>(what: &'static str, expected: Domain<D>, found: Option<Domain<D>>) -> Result<(), Error> {
    match found.filter(|f| f.shape != expected.shape) {
        Some(f) => Err(Error::Shape { what, expected: expected.shape.to_vec(), found: f.shape.to_vec() }),
        None => Ok(()),
    }
}
