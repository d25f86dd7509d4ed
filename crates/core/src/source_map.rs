//! Which exemplar sample stands at each output sample.

use crate::{Domain, Error, Exemplars, Grid, SampleId, SourceTable};

/// For each output sample the exemplar sample that stands there, with its own table of sources, so that it stands
/// alone.
///
/// A seam lies between neighbours whose samples do not continue each other; see [`is_seam`](Self::is_seam).
#[derive(Clone, Debug, PartialEq)]
pub struct SourceMap<const D: usize> {
    /// One sample number a position.
    pub ids: Grid<SampleId, D>,
    /// The sources that the numbers refer to.
    pub table: SourceTable<D>,
}

impl<const D: usize> SourceMap<D> {
    /// A map with nothing assigned.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn unassigned(exemplars: &Exemplars<D>, domain: Domain<D>) -> Result<Self, Error> {
        Ok(Self { ids: Grid::try_filled(domain, 1, SampleId::UNASSIGNED)?, table: exemplars.table().clone() })
    }

    /// Takes a map read from elsewhere.
    ///
    /// # Errors
    /// [`Error::UnknownSample`] if it names a sample that no source holds.
    pub fn new(ids: Grid<SampleId, D>, table: SourceTable<D>) -> Result<Self, Error> {
        let unknown = ids.plane(0).iter().find(|id| id.is_assigned() && table.len() <= id.get());
        match unknown {
            Some(id) => Err(Error::UnknownSample { id: id.get(), samples: u64::from(table.len()) }),
            None => Ok(Self { ids, table }),
        }
    }

    /// Shape and topology of the output.
    pub fn domain(&self) -> Domain<D> {
        self.ids.domain()
    }

    /// Source and position of the sample at a position; `None` if unassigned.
    pub fn locate(&self, at: [u32; D]) -> Option<(usize, [u32; D])> {
        self.table.locate(self.ids.get(0, at))
    }

    /// True if a seam lies between a position and the next one along an axis: both are assigned, and the one does
    /// not continue the other. False at an open border.
    pub fn is_seam(&self, at: [u32; D], axis: usize) -> bool {
        let Some(next) = self.domain().next(at, axis) else { return false };
        let (here, there) = (self.ids.get(0, at), self.ids.get(0, next));
        let mut by = [0; D];
        by[axis] = 1;
        here.is_assigned() && there.is_assigned() && self.table.step(here, by) != Some(there)
    }

    /// Number of positions with nothing assigned.
    pub fn holes(&self) -> usize {
        self.ids.plane(0).iter().filter(|id| !id.is_assigned()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source_table::tests::table;

    #[test]
    fn seams_lie_where_patches_do_not_continue() {
        let ids = [0, 1, 4, u32::MAX].map(SampleId::new).to_vec();
        let map = SourceMap::new(Grid::from_vec(Domain::periodic([1, 4]), 1, ids).unwrap(), table()).unwrap();
        assert_eq!([0, 1, 2, 3].map(|x| map.is_seam([0, x], 1)), [false, true, false, false]);
        assert_eq!(map.holes(), 1);
    }

    #[test]
    fn unknown_samples_are_errors() {
        let ids = Grid::from_vec(Domain::open([1, 1]), 1, vec![SampleId::new(10)]).unwrap();
        assert_eq!(SourceMap::new(ids, table()), Err(Error::UnknownSample { id: 10, samples: 10 }));
    }
}
