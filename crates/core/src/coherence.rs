//! What a place is likely to hold, by what stands around it: samples that continue its neighbours'. (Ashikhmin 2001)

use crate::{Domain, Exemplars, SampleId, SourceMap};

/// Candidates whose positions are kept while others are looked for, for speed alone.
const KNOWN: usize = 4;

/// Proposes samples for single places of a map: a neighbour's patch, continued. An exhaustive search mostly ends at one
/// of these, and looks at a thousand times as many.
///
/// ```
/// use selvedge_core::{Coherence, Domain, Exemplars, Grid, Plane, Role, SampleId, Samples, SourceMap};
/// # fn main() -> Result<(), selvedge_core::Error> {
/// let plane = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(Domain::open([1, 9]), 1, (0..9).collect())?));
/// let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
/// let mut map = SourceMap::unassigned(&exemplars, Domain::open([1, 4]))?;
/// map.ids.plane_mut(0)[..2].copy_from_slice(&[SampleId::new(3), SampleId::new(7)]);
/// let mut found = Vec::new();
/// // Of its neighbours within two samples 7 goes on in 8, and 3 two samples on in 5.
/// Coherence::new(&exemplars).around(&map, [0, 2], 2, |_| true, &mut found);
/// assert_eq!(found, [SampleId::new(8), SampleId::new(5)]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Coherence<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
}

impl<'e, const D: usize> Coherence<'e, D> {
    /// Proposes samples of these exemplars.
    pub fn new(exemplars: &'e Exemplars<D>) -> Self {
        Self { exemplars }
    }

    /// The samples that continue what is known within `radius` of a place along each axis, valid ones, each once: those
    /// of the nearest neighbours first, then by position. `is_known` is asked by place in the map's buffer.
    ///
    /// Time `O((2 radius + 1)^D * found)`.
    pub fn around(
        &self,
        map: &SourceMap<D>,
        at: [u32; D],
        radius: u32,
        is_known: impl Fn(usize) -> bool,
        found: &mut Vec<SampleId>,
    ) {
        found.clear();
        let (domain, ids, r) = (map.domain(), map.ids.plane(0), radius as i32);
        let around = Domain::<D>::open([2 * radius + 1; D]);
        // Most places are far from all borders.
        let inside = (0..D).all(|a| radius <= at[a] && at[a] + radius < domain.shape[a]);
        let here = domain.index(at);
        // Where the first ones lie: what is around a place mostly continues in few of them.
        let mut first = [None; KNOWN];
        for distance in 1..=r {
            for by in around.positions().map(|p| p.map(|v| v as i32 - r)) {
                if by.iter().map(|v| v.abs()).max() != Some(distance) {
                    continue;
                }
                let place = if inside {
                    let along = by.iter().zip(domain.strides()).map(|(&by, stride)| by as isize * stride as isize);
                    Some(here.wrapping_add_signed(along.sum()))
                } else {
                    domain.step(at, by).map(|p| domain.index(p))
                };
                let Some(place) = place.filter(|&p| is_known(p)) else { continue };
                let id = ids[place];
                if id.is_assigned() && !first.iter().map_while(|&at| at).any(|at| self.is_at(id, at, by)) {
                    self.propose(id, by.map(|v| -v), &mut first, found);
                }
            }
        }
    }

    /// True if a sample is the one `by` away from a position of a source, which it does not reach around a border.
    fn is_at(&self, id: SampleId, (source, at): (usize, [u32; D]), by: [i32; D]) -> bool {
        let table = self.exemplars.table();
        let domain = Domain::open(table.sources()[source].1.shape);
        domain.step(at, by).is_some_and(|at| table.id(source, at) == id)
    }

    fn propose(
        &self,
        id: SampleId,
        by: [i32; D],
        first: &mut [Option<(usize, [u32; D])>; KNOWN],
        found: &mut Vec<SampleId>,
    ) {
        let Some(to) = self.exemplars.step(id, by) else { return };
        if found.contains(&to) {
            return;
        }
        let Some((source, at)) = self.exemplars.locate(to) else { return };
        if self.exemplars.sources()[source].valid.as_deref().is_none_or(|valid| valid.get(0, at)) {
            first.get_mut(found.len()).into_iter().for_each(|first| *first = Some((source, at)));
            found.push(to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Origin, Source, Transform};

    #[test]
    fn what_is_masked_or_outside_is_not_proposed() {
        let source = Source {
            features: Grid::try_filled(Domain::open([1, 8]), 1, 0).unwrap(),
            valid: Some(Grid::from_vec(Domain::open([1, 8]), 1, (0..8).map(|x| x != 3).collect()).unwrap().into()),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        let exemplars = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain { shape: [1, 5], periodic: [false, true] }).unwrap();
        map.ids.plane_mut(0)[..4].copy_from_slice(&[2, 6, 7, 5].map(SampleId::new));
        let mut found = Vec::new();
        let mut around = |coherence: &Coherence<'_, 2>, x, known: &dyn Fn(usize) -> bool| {
            coherence.around(&map, [0, x], 1, known, &mut found);
            found.iter().map(|id| id.get()).collect::<Vec<_>>()
        };
        let plain = Coherence::new(&exemplars);
        assert_eq!(around(&plain, 1, &|_| true), [6], "3 is masked, and 7 goes back to 6");
        assert_eq!(
            around(&plain, 3, &|_| true),
            Vec::<u32>::new(),
            "7 ends the source, and nothing stands on the right"
        );
        assert_eq!(around(&plain, 4, &|_| true), [6, 1], "around the border");
        assert_eq!(around(&plain, 4, &|place| place != 3), [1]);
    }
}
