//! A map, and what blending has to know besides.

use selvedge_core::{Domain, Grid, Patch, SampleId, SourceMap, Window};

use crate::Error;

/// A map, what of its sources may show, and where it is copied.
#[derive(Clone, Debug)]
pub(crate) struct MapView<'m, const D: usize> {
    pub(crate) map: &'m SourceMap<D>,
    /// By source: which of its samples may show.
    valid: Vec<Option<&'m Grid<bool, D>>>,
    /// Positions that are copied, whatever is near.
    pub(crate) kept: Option<&'m Grid<bool, D>>,
}

impl<'m, const D: usize> MapView<'m, D> {
    pub(crate) fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>) -> Result<Self, Error> {
        if map.ids.channels() != 1 {
            return Err(selvedge_core::Error::Channels { what: "map", found: map.ids.channels() }.into());
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

    /// A box and what is `margin` around it: as far as the output reaches on open axes, around periodic ones as often
    /// as that goes.
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

    /// True if a sample's source says that it may show.
    pub(crate) fn may_show(&self, id: SampleId) -> bool {
        let Some(source) = self.map.table.source(id) else { return false };
        let valid = self.valid.get(source).copied().flatten();
        valid.is_none_or(|v| v.samples()[(id.get() - self.map.table.first(source)) as usize])
    }

    /// A patch's samples over a window, row-major; unassigned outside of its source and where that is not valid.
    pub(crate) fn samples_of(&self, patch: &Patch<D>, window: &Window<D>, to: &mut Vec<SampleId>) {
        let first = self.map.table.first(patch.source);
        let valid = self.valid.get(patch.source).copied().flatten().map(Grid::samples);
        to.clear();
        to.extend(patch.places(self.map.table.sources()[patch.source].1, window).map(|place| match place {
            Some(place) if valid.is_none_or(|v| v[place]) => SampleId::new(first + place as u32),
            _ => SampleId::UNASSIGNED,
        }));
    }
}

fn check_shape<const D: usize>(what: &'static str, expected: Domain<D>, found: Option<Domain<D>>) -> Result<(), Error> {
    match found.filter(|f| f.shape != expected.shape) {
        Some(f) => Err(Error::Shape { what, expected: expected.shape.to_vec(), found: f.shape.to_vec() }),
        None => Ok(()),
    }
}
