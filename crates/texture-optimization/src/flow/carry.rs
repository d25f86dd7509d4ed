//! What of a frame moves on into the next: for each sample the place of the exemplars that it shows, between samples.
//!
//! Frames are made of whole samples of the exemplars, and flows of parts of them. What stood in a frame is therefore
//! not warped again and again, which would blur it, nor rounded in every frame, which would hold still what moves by
//! less than half a sample: the place is carried as it is, and the next frame is wished for at it.

use std::collections::VecDeque;

use selvedge_core::{CameFrom, Domain, Error, Exemplars, Grid, SampleId, SourceMap, collected};

use crate::assignment::Place;
use crate::control::Wishes;

/// Samples by which what a frame shows may differ from what was wished for there and still be the same thing: else it
/// is another, and is carried from where it is.
const APART: f64 = 1.0;

/// Where each sample of a frame stands in the exemplars.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Carried {
    pub(super) domain: Domain<2>,
    places: Vec<Option<Spot>>,
}

/// A place of a source, between samples.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    source: usize,
    at: [f64; 2],
}

impl Carried {
    /// What a map shows.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn of(map: &SourceMap<2>) -> Result<Self, Error> {
        Self::of_ids(map.ids.plane(0), map)
    }

    /// What another map of the same sources and output shows.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn of_ids(ids: &[SampleId], like: &SourceMap<2>) -> Result<Self, Error> {
        let spot = |&id: &SampleId| {
            let (source, at) = like.table.locate(id)?;
            Some(Spot { source, at: at.map(f64::from) })
        };
        Ok(Self { domain: like.domain(), places: collected(ids.iter().map(spot))? })
    }

    /// Whether all of it stands in sources that these exemplars have.
    pub(super) fn is_of(&self, exemplars: &Exemplars<2>) -> bool {
        self.places.iter().flatten().all(|spot| spot.source < exemplars.sources().len())
    }

    /// The same as words, for a file: three a sample, of which the first one is 0 for none.
    pub(super) fn words(&self) -> impl Iterator<Item = u64> + '_ {
        self.places.iter().flat_map(|spot| match spot {
            Some(Spot { source, at: [y, x] }) => [*source as u64 + 1, y.to_bits(), x.to_bits()],
            None => [0; 3],
        })
    }

    /// What [`words`](Self::words) made; `None` for fewer, or what stands nowhere.
    pub(super) fn of_words(domain: Domain<2>, word: &mut dyn FnMut() -> Option<u64>) -> Option<Self> {
        let mut spot = || {
            let (source, at) = (word()?, [word()?, word()?].map(f64::from_bits));
            let source = usize::try_from(source).ok()?;
            at.iter().all(|v| v.is_finite()).then(|| source.checked_sub(1).map(|source| Spot { source, at }))
        };
        let places = (0..domain.len()).map(|_| spot()).collect::<Option<_>>()?;
        Some(Self { domain, places })
    }

    /// Where everything goes: each sample of the next frame stands where the sample that it comes from stood, and goes
    /// on from it by the rest of the way, also from beyond open edges.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn moved(&self, origins: &[CameFrom]) -> Result<Self, Error> {
        let one = |origin: &CameFrom| {
            let (near, by) = origin.nearest(self.domain);
            let Spot { source, at } = self.places[self.domain.index(near)]?;
            Some(Spot { source, at: [0, 1].map(|axis| at[axis] + by[axis]) })
        };
        Ok(Self { domain: self.domain, places: collected(origins.iter().map(one))? })
    }

    /// The same where a body alone is: what is outside of it goes on from what is nearest inside, as the exemplar does,
    /// so that nothing that stands there pulls across the border; and so do `colors`.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn of_body(&self, body: &Grid<bool, 2>, colors: &mut Grid<f64, 2>) -> Result<Self, Error> {
        let (mut places, mut known) = (collected(self.places.iter().copied())?, body.plane(0).to_vec());
        let mut next: VecDeque<usize> = (0..known.len()).filter(|&i| known[i]).collect();
        while let Some(from) = next.pop_front() {
            for by in [[-1, 0], [0, -1], [0, 1], [1, 0]] {
                let Some(to) = self.domain.step(self.domain.position(from), by) else { continue };
                let to = self.domain.index(to);
                if std::mem::replace(&mut known[to], true) {
                    continue;
                }
                let on = |Spot { source, at }| Spot { source, at: [0, 1].map(|a| at[a] + f64::from(by[a])) };
                places[to] = places[from].map(on);
                (0..colors.channels()).for_each(|c| colors.plane_mut(c)[to] = colors.plane(c)[from]);
                next.push_back(to);
            }
        }
        Ok(Self { domain: self.domain, places })
    }

    /// Shows at a place what another shows there.
    pub(crate) fn take(&mut self, place: usize, other: &Self) {
        self.places[place] = other.places[place];
    }

    /// What is shown now, of what was carried here: the parts of samples that were lost in it are kept.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn settled(&self, exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Result<Self, Error> {
        let mut settled = Self::of(map)?;
        for (own, wished) in settled.places.iter_mut().zip(&self.places) {
            let (Some(own), Some(wished)) = (own, wished) else { continue };
            let domain = exemplars.sources()[own.source].domain();
            let near = |axis: usize| apart(domain, axis, wished.at[axis], own.at[axis]).abs() <= APART;
            if own.source == wished.source && near(0) && near(1) {
                own.at = wished.at;
            }
        }
        Ok(settled)
    }

    /// Places at which a neighborhood would go on as it came: by its middle, and by the middles of its quarters.
    pub(crate) fn offered(&self, exemplars: &Exemplars<2>, first: [u32; 2], size: u32) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        let (half, quarter) = (size / 2, size / 4);
        let points =
            [[half, half], [quarter, quarter], [quarter, 3 * quarter], [3 * quarter, quarter], [3 * quarter; 2]];
        for by in points {
            let n = self.domain.shape;
            let at = self.domain.index([0, 1].map(|axis| (first[axis] + by[axis]) % n[axis]));
            let Some(Spot { source, at }) = self.places[at] else { continue };
            let domain = exemplars.sources()[source].domain();
            // Where motion is not known it may have gone far beyond any picture.
            let back = [0, 1].map(|axis| ((at[axis] + 0.5).floor() as i32).saturating_sub_unsigned(by[axis]));
            let Some(at) = domain.step([0; 2], back) else { continue };
            let place = Place { source: source as u32, at };
            if !places.contains(&place) {
                places.push(place);
            }
        }
        places
    }

    /// Colours to begin with, and wishes by `lambda` for those that are sure: of the exemplars between their samples;
    /// and how many these are.
    pub(crate) fn wishes(
        &self,
        exemplars: &Exemplars<2>,
        (origins, lambda): (&[CameFrom], f64),
        before: &Grid<f64, 2>,
    ) -> Result<(Wishes, usize), Error> {
        let none = || Grid::try_filled(self.domain, exemplars.channels(), 0.0);
        let (mut colors, mut weights) = (none()?, none()?);
        let (mut color, mut sure) = (vec![0.0; exemplars.channels()], 0);
        for (i, (spot, origin)) in self.places.iter().zip(origins).enumerate() {
            let shows = spot.is_some_and(|spot| shown(exemplars, spot, &mut color));
            if !shows {
                // Off the exemplar: what stood there, to begin with.
                let (near, _) = origin.nearest(self.domain);
                color.iter_mut().enumerate().for_each(|(c, v)| *v = before.get(c, near));
            }
            let is_sure = shows && origin.is_sure;
            sure += usize::from(is_sure);
            let weight = if is_sure { lambda } else { 0.0 };
            for (c, &color) in color.iter().enumerate() {
                (colors.plane_mut(c)[i], weights.plane_mut(c)[i]) = (color, weight);
            }
        }
        Ok((Wishes { colors, weights, texture: exemplars.channels() }, sure))
    }
}

/// The way from one position to another along an axis, the shorter one around a periodic axis.
fn apart(domain: Domain<2>, axis: usize, to: f64, from: f64) -> f64 {
    let (by, n) = (to - from, f64::from(domain.shape[axis]));
    if domain.periodic[axis] { by - (by / n + 0.5).floor() * n } else { by }
}

/// The features at a place between samples; false where a sample of it is off the source or masked.
fn shown(exemplars: &Exemplars<2>, spot: Spot, color: &mut [f64]) -> bool {
    let source = &exemplars.sources()[spot.source];
    let domain = source.domain();
    let is_off =
        |axis: usize| !domain.periodic[axis] && !(0.0..=f64::from(domain.shape[axis] - 1)).contains(&spot.at[axis]);
    if is_off(0) || is_off(1) {
        return false;
    }
    color.fill(0.0);
    for (at, weight) in domain.corners(spot.at) {
        if source.valid.as_deref().is_some_and(|valid| !valid.get(0, at)) {
            return false;
        }
        for (c, v) in color.iter_mut().enumerate() {
            *v += weight * f64::from(source.features.get(c, at));
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::exemplars;
    use selvedge_core::{Direction, Flow, Seed};

    /// A map of samples in a row, and a flow of parts of samples.
    #[test]
    fn parts_of_samples_add_up() {
        let exemplars = exemplars(&mut Seed(1).rng(), [12, 15], false);
        let domain = Domain::periodic([6, 7]);
        let mut map = SourceMap::unassigned(&exemplars, domain).unwrap();
        let id = |[y, x]: [u32; 2]| exemplars.table().id(0, [y + 2, x + 3]);
        domain.positions().for_each(|at| map.ids.set(0, at, id(at)));
        let by = Grid::from_vec(domain, 2, [vec![0.25; 42], vec![0.0; 42]].concat()).unwrap();
        let all = Flow { by, known: None }.came_from(Direction::Forward).unwrap();
        let mut carried = Carried::of(&map).unwrap();
        for step in 1..=4 {
            let moved = carried.moved(&all).unwrap();
            let spot = moved.places[domain.index([3, 3])].unwrap();
            assert_eq!(spot.at, [5.0 - 0.25 * f64::from(step), 6.0], "{step}");
            // The frame shows whole samples.
            carried = moved.settled(&exemplars, &map).unwrap();
        }
        let other = carried.moved(&all).unwrap().settled(&exemplars, &map).unwrap();
        assert_eq!(other.places[domain.index([3, 3])].unwrap().at, [5.0, 6.0], "what is too far is another thing");
    }
}
