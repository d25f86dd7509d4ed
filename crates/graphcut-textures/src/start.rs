//! What a run begins with: an output that is partly there, and what must stay.

use selvedge_core::{Exemplars, Grid, SourceMap};

use crate::Error;

/// What is there before the first patch.
#[derive(Clone, Debug)]
pub struct Start<const D: usize> {
    /// Samples that stand already; the rest is unassigned.
    pub map: SourceMap<D>,
    /// Positions whose sample stays; `None` for none. An unassigned one is filled once and may change.
    pub fixed: Option<Grid<bool, D>>,
    /// By position, bit `s` says whether source `s` may be used there; `None` for all everywhere.
    pub sources: Option<Grid<u64, D>>,
}

impl<const D: usize> Start<D> {
    /// Everything has the output's shape, and every hole a source.
    pub(crate) fn check(&self, exemplars: &Exemplars<D>) -> Result<(), Error> {
        let output = self.map.domain();
        if output.is_empty() {
            return Err(Error::EmptyOutput { shape: output.shape.to_vec() });
        }
        check_map(exemplars, &self.map)?;
        let shapes = [
            ("mask of fixed samples", self.fixed.as_ref().map(Grid::domain)),
            ("field of sources", self.sources.as_ref().map(Grid::domain)),
        ];
        for (what, found) in shapes {
            let Some(found) = found.filter(|f| f.shape != output.shape) else { continue };
            return Err(Error::Shape { what, expected: output.shape.to_vec(), found: found.shape.to_vec() });
        }
        let Some(sources) = &self.sources else { return Ok(()) };
        let usable = |s: &selvedge_core::Source<D>| s.valid.as_ref().is_none_or(|v| v.samples().contains(&true));
        let usable = exemplars.sources().iter().take(64).enumerate().filter(|(_, s)| usable(s));
        let bits = usable.fold(0_u64, |bits, (s, _)| bits | 1 << s);
        let ids = self.map.ids.plane(0);
        let stuck = (0..ids.len()).find(|&i| !ids[i].is_assigned() && sources.plane(0)[i] & bits == 0);
        match stuck {
            Some(i) => Err(Error::NoSource { at: output.position(i).to_vec() }),
            None => Ok(()),
        }
    }
}

/// A map names only samples that the exemplars hold.
pub(crate) fn check_map<const D: usize>(exemplars: &Exemplars<D>, map: &SourceMap<D>) -> Result<(), Error> {
    let samples = exemplars.table().len();
    let foreign = map.ids.plane(0).iter().find(|id| id.is_assigned() && samples <= id.get());
    match foreign {
        Some(id) => Err(Error::ForeignMap { id: id.get(), samples }),
        None if map.table.len() != samples => Err(Error::ForeignMap { id: map.table.len(), samples }),
        None => Ok(()),
    }
}
