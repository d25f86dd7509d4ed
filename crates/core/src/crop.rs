//! The part of a source that may be used at all.

use std::ops::Range;

use crate::{Domain, Error, Exemplars, SampleId, Source, SourceTable, Window};

impl<const D: usize> Source<D> {
    /// The smallest box that holds every valid sample; all of the source along axes on which it is periodic. Empty
    /// where no sample is valid. Takes a look at every sample of a mask.
    pub fn valid_box(&self) -> Window<D> {
        let domain = self.domain();
        let Some(valid) = &self.valid else { return Window::all(domain) };
        let (mut first, mut end) = (domain.shape, [0; D]);
        for at in domain.positions().zip(valid.samples()).filter_map(|(at, &valid)| valid.then_some(at)) {
            first = std::array::from_fn(|a| first[a].min(at[a]));
            end = std::array::from_fn(|a| end[a].max(at[a] + 1));
        }
        for a in (0..D).filter(|&a| domain.periodic[a]) {
            (first[a], end[a]) = (0, domain.shape[a]);
        }
        Window { start: first.map(|n| n as i32), shape: std::array::from_fn(|a| end[a].saturating_sub(first[a])) }
    }

    /// The same source without what lies outside of a box, such as its [`valid_box`](Self::valid_box): open along axes
    /// that the box does not fill, its samples numbered anew.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If the box reaches beyond the source.
    pub fn cropped(&self, to: &Window<D>) -> Result<Self, Error> {
        let valid = self.valid.as_ref().map(|valid| valid.cropped(to)).transpose()?;
        Ok(Self { features: self.features.cropped(to)?, valid: valid.map(Into::into), origin: self.origin })
    }
}

/// The [`valid_box`](Source::valid_box) of every source, and the samples in them numbered through: what a method looks
/// at that would look at every sample, so that a mask of few costs as little.
#[derive(Clone, Debug)]
pub struct ValidBoxes<'e, const D: usize> {
    table: &'e SourceTable<D>,
    boxes: Vec<Window<D>>,
}

impl<'e, const D: usize> ValidBoxes<'e, D> {
    /// Of all sources.
    pub fn of(exemplars: &'e Exemplars<D>) -> Self {
        let boxes = exemplars.sources().iter().map(|source| source.valid_box()).collect();
        Self { table: exemplars.table(), boxes }
    }

    /// The box of each source.
    pub fn boxes(&self) -> &[Window<D>] {
        &self.boxes
    }

    /// What of each source may be used at most, with its topology.
    pub fn domains(&self) -> impl Iterator<Item = Domain<D>> + Clone {
        let sources = self.table.sources().iter().zip(&self.boxes);
        sources.map(|((_, domain), valid)| Domain { shape: valid.shape, ..*domain })
    }

    /// Samples in all boxes.
    pub fn len(&self) -> u32 {
        self.boxes.iter().map(|valid| valid.len() as u32).sum()
    }

    /// True if no sample is valid.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples of a range of numbers, in order: each a step from the one before.
    pub fn samples(&self, range: Range<u32>) -> impl Iterator<Item = SampleId> {
        let mut next = 0;
        self.boxes.iter().filter(|valid| !valid.is_empty()).flat_map(move |valid| {
            let (first, row) = (next, valid.shape[D - 1]);
            next += valid.len() as u32;
            let own = range.start.max(first)..range.end.min(next);
            let rows = own.start.saturating_sub(first) / row..own.end.saturating_sub(first).div_ceil(row);
            rows.flat_map(move |number| {
                let of_row = own.start.max(first + number * row)..own.end.min(first + (number + 1) * row);
                let id = self.sample(of_row.start).get();
                (id..id + of_row.len() as u32).map(SampleId::new)
            })
        })
    }

    /// A sample by its number in all boxes, in the order of (source, position).
    ///
    /// # Panics
    /// If there are no more.
    pub fn sample(&self, number: u32) -> SampleId {
        let mut number = number as usize;
        for (source, valid) in self.boxes.iter().enumerate() {
            if number < valid.len() {
                let within = valid.local().position(number);
                return self.table.id(source, std::array::from_fn(|a| within[a] + valid.start[a] as u32));
            }
            number -= valid.len();
        }
        panic!("all boxes hold {} samples", self.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Origin, Transform};

    fn source(periodic: [bool; 2], valid: impl Fn([u32; 2]) -> bool) -> Source<2> {
        let domain = Domain { shape: [5, 6], periodic };
        let features = Grid::from_vec(domain, 2, (0..60).collect()).unwrap();
        let valid = Grid::from_vec(domain, 1, domain.positions().map(valid).collect()).unwrap();
        Source { features, valid: Some(valid.into()), origin: Origin { exemplar: 0, transform: Transform::IDENTITY } }
    }

    #[test]
    fn the_box_is_what_holds_every_valid_sample() {
        let two = |at| [[1, 2], [3, 4]].contains(&at);
        assert_eq!(source([false; 2], two).valid_box(), Window { start: [1, 2], shape: [3, 3] });
        assert_eq!(source([false, true], two).valid_box(), Window { start: [1, 0], shape: [3, 6] });
        assert!(source([false; 2], |_| false).valid_box().is_empty());
        assert_eq!(source([false; 2], |_| true).valid_box(), Window { start: [0, 0], shape: [5, 6] });
    }

    #[test]
    fn boxes_number_their_samples_through() {
        let whole = source([false; 2], |_| true);
        let few = source([false; 2], |[y, x]| (y, x) == (2, 3) || (y, x) == (3, 4));
        let exemplars = Exemplars::from_sources(vec![few, whole], vec![1; 2]).unwrap();
        let boxes = ValidBoxes::of(&exemplars);
        let id = |number| exemplars.locate(boxes.sample(number)).unwrap();
        assert_eq!((boxes.len(), boxes.is_empty()), (4 + 30, false));
        assert_eq!(
            [0, 1, 2, 3, 4, 33].map(id),
            [(0, [2, 3]), (0, [2, 4]), (0, [3, 3]), (0, [3, 4]), (1, [0, 0]), (1, [4, 5])]
        );
        for range in [0..34, 0..0, 1..3, 3..5, 7..30, 33..34] {
            let one_by_one: Vec<SampleId> = range.clone().map(|number| boxes.sample(number)).collect();
            assert_eq!(boxes.samples(range).collect::<Vec<_>>(), one_by_one);
        }
        assert_eq!(boxes.domains().map(|d| d.shape).collect::<Vec<_>>(), [[2, 2], [5, 6]]);
    }

    #[test]
    fn what_is_cropped_keeps_samples_validity_and_the_axes_that_are_whole() {
        let source = source([false, true], |[y, x]| (1..4).contains(&y) && x != 3);
        let cropped = source.cropped(&source.valid_box()).unwrap();
        assert_eq!(cropped.domain(), Domain { shape: [3, 6], periodic: [false, true] });
        for at @ [y, x] in cropped.domain().positions() {
            assert_eq!([0, 1].map(|c| cropped.features.get(c, at)), [0, 1].map(|c| source.features.get(c, [y + 1, x])));
            assert_eq!(cropped.valid.as_deref().unwrap().get(0, at), x != 3);
        }
        let corner = source.cropped(&Window { start: [0, 0], shape: [1, 5] }).unwrap();
        assert_eq!(corner.domain(), Domain::open([1, 5]));
    }
}
