//! The sources of a run, all their samples numbered through.

use crate::{Domain, Error, Origin};

/// The number of an exemplar sample: all samples of all sources are numbered through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct SampleId(u32);

impl SampleId {
    /// Stands where nothing was assigned yet.
    pub const UNASSIGNED: Self = Self(u32::MAX);

    /// Sample number `id`.
    pub const fn new(id: u32) -> Self {
        Self(id)
    }

    /// Its number.
    #[inline]
    pub const fn get(self) -> u32 {
        self.0
    }

    /// False for [`UNASSIGNED`](Self::UNASSIGNED).
    #[inline]
    pub const fn is_assigned(self) -> bool {
        self.0 != u32::MAX
    }
}

/// The sources of a run and where each one's samples begin in the numbering.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTable<const D: usize> {
    sources: Vec<(Origin, Domain<D>)>,
    first: Vec<u32>,
}

impl<const D: usize> SourceTable<D> {
    /// Numbers the samples of sources in order.
    ///
    /// # Errors
    /// [`Error::TooManySamples`] if there are 2^32 - 1 or more.
    pub fn new(sources: Vec<(Origin, Domain<D>)>) -> Result<Self, Error> {
        let limit = u64::from(u32::MAX);
        let mut first = vec![0];
        let mut samples = 0_u64;
        for (_, domain) in &sources {
            samples = samples.saturating_add(domain.checked_len().map_or(u64::MAX, |n| n as u64));
            if limit <= samples {
                return Err(Error::TooManySamples { samples, limit });
            }
            first.push(samples as u32);
        }
        Ok(Self { sources, first })
    }

    /// Origin and domain of each source.
    pub fn sources(&self) -> &[(Origin, Domain<D>)] {
        &self.sources
    }

    /// Samples in all sources: there is one at least, or there would be no exemplars.
    #[expect(clippy::len_without_is_empty, reason = "it never is")]
    pub fn len(&self) -> u32 {
        self.first[self.sources.len()]
    }

    /// The number of a source's first sample.
    #[inline]
    pub fn first(&self, source: usize) -> u32 {
        self.first[source]
    }

    /// The sample at a position of a source.
    ///
    /// # Panics
    /// If there is no such source; if the position lies outside of it, in debug builds, and elsewhere the sample is
    /// another one.
    #[inline]
    pub fn id(&self, source: usize, at: [u32; D]) -> SampleId {
        SampleId(self.first[source] + self.sources[source].1.index(at) as u32)
    }

    /// True if the sample is one of this source.
    #[inline]
    pub(crate) fn holds(&self, source: usize, id: SampleId) -> bool {
        (self.first[source]..self.first[source + 1]).contains(&id.0)
    }

    /// Which source holds a sample; `None` if unassigned or unknown.
    #[inline]
    pub fn source(&self, id: SampleId) -> Option<usize> {
        (id.0 < self.len()).then(|| self.first.partition_point(|&first| first <= id.0) - 1)
    }

    /// Source and position of a sample; `None` if unassigned or unknown.
    #[inline]
    pub fn locate(&self, id: SampleId) -> Option<(usize, [u32; D])> {
        let source = self.source(id)?;
        let index = (id.0 - self.first[source]) as usize;
        Some((source, self.sources[source].1.position(index)))
    }

    /// The sample `by` away in the same source: the patch, continued. `None` where the source ends.
    #[inline]
    pub fn step(&self, id: SampleId, by: [i32; D]) -> Option<SampleId> {
        let (source, at) = self.locate(id)?;
        Some(self.id(source, self.sources[source].1.step(at, by)?))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Transform;

    /// Two sources: 2x3 samples, then 2x2.
    pub(crate) fn table() -> SourceTable<2> {
        let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
        SourceTable::new(vec![(origin(0), Domain::open([2, 3])), (origin(1), Domain::open([2, 2]))]).unwrap()
    }

    #[test]
    fn samples_are_numbered_through() {
        let t = table();
        assert_eq!(t.len(), 10);
        assert_eq!(t.locate(SampleId::new(5)), Some((0, [1, 2])));
        assert_eq!(t.locate(SampleId::new(6)), Some((1, [0, 0])));
        assert_eq!(t.locate(SampleId::new(10)), None);
        assert_eq!(t.locate(SampleId::UNASSIGNED), None);
        assert_eq!(t.id(1, [1, 1]), SampleId::new(9));
    }

    #[test]
    fn patches_end_where_their_source_ends() {
        let t = table();
        assert_eq!(t.step(SampleId::new(1), [1, 1]), Some(SampleId::new(5)));
        assert_eq!(t.step(SampleId::new(5), [0, 1]), None);
        assert_eq!(t.step(SampleId::new(6), [0, -1]), None);
    }

    #[test]
    fn too_many_samples_are_errors() {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let all = SourceTable::new(vec![(origin, Domain::open([1 << 16, 1 << 16]))]);
        assert!(matches!(all, Err(Error::TooManySamples { .. })));
    }
}
