//! A source laid over an output.

use crate::{Domain, Exemplars, Grid, SampleId, SourceMap, Window};

/// A translation of a source. `[Kwatra03 4]`
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Patch<const D: usize> {
    /// The source.
    pub source: usize,
    /// Output position = source position + offset; not wrapped.
    pub offset: [i32; D],
}

impl<const D: usize> Patch<D> {
    /// The part of the output that the whole source covers, not clipped. A periodic source covers every axis around
    /// which it wraps, from `around` on.
    pub fn footprint(&self, exemplars: &Exemplars<D>, around: &Window<D>) -> Window<D> {
        let domain = exemplars.sources()[self.source].domain();
        let mut footprint = Window { start: self.offset, shape: domain.shape };
        for axis in (0..D).filter(|&a| domain.periodic[a]) {
            (footprint.start[axis], footprint.shape[axis]) = (around.start[axis], around.shape[axis]);
        }
        footprint
    }

    /// The same patch with its offset wrapped around periodic axes of its source and of the output: equal keys are
    /// equal placements. (Around a source whose side does not go into the output's, only the source counts.)
    #[must_use]
    pub fn wrapped(&self, source: Domain<D>, output: Domain<D>) -> Self {
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

    /// Place in the source's buffer of each position of a window of the output, row-major; `None` outside of the
    /// source.
    pub fn places(
        &self,
        source: Domain<D>,
        window: &Window<D>,
    ) -> impl ExactSizeIterator<Item = Option<usize>> + use<D> {
        window.moved(self.offset.map(|o| -o)).places(source)
    }

    /// The sample at each position of a window of the output, row-major; unassigned outside of the source and where
    /// that is masked.
    pub fn samples<'e>(
        &self,
        exemplars: &'e Exemplars<D>,
        window: &Window<D>,
    ) -> impl ExactSizeIterator<Item = SampleId> + use<'e, D> {
        let source = &exemplars.sources()[self.source];
        let first = exemplars.table().first(self.source);
        let valid = source.valid.as_deref().map(Grid::samples);
        self.places(source.domain(), window).map(move |place| match place {
            Some(place) if valid.is_none_or(|v| v[place]) => SampleId::new(first + place as u32),
            _ => SampleId::UNASSIGNED,
        })
    }
}

impl<const D: usize> SourceMap<D> {
    /// The patches that meet in a window, with offsets in the window's own turn of periodic axes, each once, in the
    /// order in which they are first met. A source that repeats itself is one patch however often it does.
    ///
    /// Time: the window's samples, times the patches that meet where many do.
    pub fn patches(&self, window: &Window<D>) -> Vec<Patch<D>> {
        let mut found: Vec<Patch<D>> = Vec::new();
        let (local, ids) = (window.local(), self.ids.plane(0));
        for (i, place) in window.places(self.domain()).enumerate() {
            let Some((source, from)) = place.and_then(|place| self.table.locate(ids[place])) else { continue };
            let (at, domain) = (local.position(i), self.table.sources()[source].1);
            let offset = domain.wrapped(std::array::from_fn(|a| window.start[a] + at[a] as i32 - from[a] as i32));
            let patch = Patch { source, offset };
            // Neighbours mostly belong to the patch found last.
            if !found.iter().rev().any(|f| *f == patch) {
                found.push(patch);
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Origin, Source, Transform};

    fn exemplars(domain: Domain<2>, valid: Option<Vec<bool>>) -> Exemplars<2> {
        let features = Grid::from_vec(domain, 1, (0..domain.len() as u8).collect()).unwrap();
        let valid = valid.map(|v| Grid::from_vec(domain, 1, v).unwrap());
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: valid.map(Into::into), origin }], vec![1]).unwrap()
    }

    #[test]
    fn a_patch_ends_with_its_source_and_goes_around_a_periodic_one() {
        let window = Window { start: [3, 4], shape: [2, 4] };
        let patch = Patch { source: 0, offset: [3, 5] };
        let ids = |e: &Exemplars<2>| {
            patch.samples(e, &window).map(|id| id.is_assigned().then(|| id.get())).collect::<Vec<_>>()
        };
        let valid = vec![true, true, false, true, true, true];
        let plain = exemplars(Domain::open([2, 3]), None);
        assert_eq!(ids(&plain), [None, Some(0), Some(1), Some(2), None, Some(3), Some(4), Some(5)]);
        let masked = exemplars(Domain { shape: [2, 3], periodic: [false, true] }, Some(valid));
        assert_eq!(ids(&masked), [None, Some(0), Some(1), None, Some(5), Some(3), Some(4), Some(5)]);
    }

    #[test]
    fn equal_placements_wrap_to_the_same_patch() {
        let output = Domain { shape: [20, 30], periodic: [false, true] };
        let wrapped = |y, x, source| Patch { source: 0, offset: [y, x] }.wrapped(source, output).offset;
        assert_eq!(wrapped(3, -5, Domain::open([9, 9])), [3, 25]);
        assert_eq!(wrapped(23, 31, Domain::open([9, 9])), [23, 1]);
        assert_eq!(wrapped(-8, 11, Domain::periodic([9, 9])), [1, 2], "around the source");
    }

    #[test]
    fn footprints_are_whole_sources_and_endless_around_periodic_ones() {
        let e = exemplars(Domain { shape: [2, 3], periodic: [false, true] }, None);
        let around = Window { start: [5, 6], shape: [7, 8] };
        let footprint = Patch { source: 0, offset: [-1, -2] }.footprint(&e, &around);
        assert_eq!(footprint, Window { start: [-1, 6], shape: [2, 8] });
    }

    #[test]
    fn patches_of_a_map_are_those_that_were_laid() {
        for periodic in [false, true] {
            let source = Domain { shape: [4, 3], periodic: [periodic, false] };
            let e = exemplars(source, None);
            let output = Domain { shape: [4, 8], periodic: [false, true] };
            let mut map = SourceMap::unassigned(&e, output).unwrap();
            let laid = [Patch { source: 0, offset: [0, 6] }, Patch { source: 0, offset: [1, 2] }];
            for patch in laid {
                let window = Window { start: [1, patch.offset[1]], shape: [2, 3] };
                for (place, id) in window.places(output).zip(patch.samples(&e, &window)) {
                    map.ids.plane_mut(0)[place.unwrap()] = id;
                }
            }
            // From column -2 on the first patch comes first, in its turn.
            let found = map.patches(&Window { start: [-1, -2], shape: [4, 8] });
            assert_eq!(found, [Patch { source: 0, offset: [0, -2] }, laid[1]]);
            assert_eq!(map.patches(&Window { start: [0, 5], shape: [9, 4] }), [laid[0]]);
        }
    }
}
