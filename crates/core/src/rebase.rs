//! Maps taken over: from another table of sources, and from a source that lies under the output.

use crate::{Error, Exemplars, SampleId, SourceMap};

impl<const D: usize> SourceMap<D> {
    /// The same samples by the numbers that they have among `exemplars`, where source `s` of this map is source
    /// `to[s]`. What is masked there is a hole.
    ///
    /// # Errors
    /// [`Error::MissingSource`] if the map shows a source that has no counterpart, or one of another shape;
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If `to` has no entry for a source.
    pub fn rebased(&self, exemplars: &Exemplars<D>, to: &[Option<usize>]) -> Result<Self, Error> {
        let table = exemplars.table();
        let shape = |table: &crate::SourceTable<D>, source: usize| table.sources()[source].1.shape;
        let same = |s: usize| to[s].filter(|&t| shape(table, t) == shape(&self.table, s));
        let mut map = Self::unassigned(exemplars, self.domain())?;
        for (new, &id) in map.ids.plane_mut(0).iter_mut().zip(self.ids.plane(0)) {
            let Some(source) = self.table.source(id) else { continue };
            let here = same(source).ok_or(Error::MissingSource { number: source })?;
            let index = id.get() - self.table.first(source);
            let valid = exemplars.sources()[here].valid.as_deref();
            if valid.is_none_or(|v| v.samples()[index as usize]) {
                *new = SampleId::new(table.first(here) + index);
            }
        }
        Ok(map)
    }

    /// Every hole shows the sample of a source at its own position, where that is valid: a picture as what is gone on
    /// from.
    ///
    /// # Errors
    /// [`Error::Shape`] if the source has another shape than the map.
    pub fn lay_under(&mut self, exemplars: &Exemplars<D>, source: usize) -> Result<(), Error> {
        let (under, first) = (&exemplars.sources()[source], exemplars.table().first(source));
        let (expected, found) = (self.domain().shape.to_vec(), under.domain().shape.to_vec());
        if expected != found {
            return Err(Error::Shape { exemplar: under.origin.exemplar.into(), plane: 0, expected, found });
        }
        for (i, id) in self.ids.plane_mut(0).iter_mut().enumerate() {
            if !id.is_assigned() && under.valid.as_deref().is_none_or(|v| v.samples()[i]) {
                *id = SampleId::new(first + i as u32);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Grid, Origin, Source, Transform};

    fn source(exemplar: u16, shape: [u32; 1], valid: Option<Vec<bool>>) -> Source<1> {
        let domain = Domain::open(shape);
        let valid = valid.map(|v| Grid::from_vec(domain, 1, v).unwrap());
        let features = Grid::try_filled(domain, 1, 0).unwrap();
        Source { features, valid: valid.map(Into::into), origin: Origin { exemplar, transform: Transform::IDENTITY } }
    }

    fn ids(map: &SourceMap<1>) -> Vec<Option<u32>> {
        map.ids.plane(0).iter().map(|id| id.is_assigned().then(|| id.get())).collect()
    }

    #[test]
    fn samples_take_the_numbers_of_their_new_table_and_what_is_masked_there_is_a_hole() {
        let old = Exemplars::from_sources(vec![source(0, [2], None), source(1, [3], None)], vec![1]).unwrap();
        let masked = source(1, [3], Some(vec![true, false, true]));
        let new = Exemplars::from_sources(vec![masked, source(7, [4], None), source(0, [2], None)], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&old, Domain { shape: [6], periodic: [true] }).unwrap();
        map.ids.plane_mut(0)[1..].copy_from_slice(&[4, 3, 2, 1, 0].map(SampleId::new));
        let rebased = map.rebased(&new, &[Some(2), Some(0)]).unwrap();
        assert_eq!(ids(&rebased), [None, Some(2), None, Some(0), Some(8), Some(7)]);
        assert_eq!((&rebased.table, rebased.domain()), (new.table(), map.domain()));
        // There and back again.
        let whole = Exemplars::from_sources(vec![source(1, [3], None), source(0, [2], None)], vec![1]).unwrap();
        let there = map.rebased(&whole, &[Some(1), Some(0)]).unwrap();
        assert_eq!(there.rebased(&old, &[Some(1), Some(0)]).unwrap(), map);
    }

    #[test]
    fn a_source_that_shows_must_be_there_and_one_that_does_not_need_not() {
        let exemplars = Exemplars::from_sources(vec![source(0, [2], None), source(1, [3], None)], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([1])).unwrap();
        map.ids.plane_mut(0)[0] = SampleId::new(1);
        assert_eq!(map.rebased(&exemplars, &[Some(0), None]).unwrap(), map);
        assert_eq!(map.rebased(&exemplars, &[None, Some(1)]), Err(Error::MissingSource { number: 0 }));
        assert_eq!(map.rebased(&exemplars, &[Some(1), None]), Err(Error::MissingSource { number: 0 }), "other shape");
    }

    #[test]
    fn a_picture_under_the_output_shows_through_holes_where_it_is_valid() {
        let under = source(1, [3], Some(vec![true, true, false]));
        let exemplars = Exemplars::from_sources(vec![source(0, [2], None), under], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([3])).unwrap();
        map.ids.plane_mut(0)[0] = SampleId::new(1);
        map.lay_under(&exemplars, 1).unwrap();
        assert_eq!(ids(&map), [Some(1), Some(3), None]);
        assert!(matches!(map.lay_under(&exemplars, 0), Err(Error::Shape { .. })));
    }
}
