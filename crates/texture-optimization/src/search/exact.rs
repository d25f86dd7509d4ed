//! The search of a level, on samples rounded to 8 bits: all places where something changed, or what continues it.

use std::ops::Range;

use selvedge_core::{Exemplars, Grid, SimdLevel, Usage, par};
use selvedge_fft_ssd::{Coverage, Neighbor, Windows};

use super::Found;
use super::coherent::{Listed, changed, place};
use super::displaced::Displaced;
use super::evenness;
use super::tree::Tree;
use super::weights::fitting;
use crate::Error;
use crate::assignment::Place;
use crate::gradient::seen;
use crate::neighborhoods::Neighborhoods;

/// Neighborhoods along a side of what is searched together where some have not changed. Smaller parts would spend more
/// on what lies around them, larger ones look for more that is known.
const PART: usize = 8;

/// The search of one level. It remembers what it saw, since a neighborhood that did not change keeps its answer.
#[derive(Debug)]
pub(crate) struct Exact<'a> {
    places: Displaced<'a>,
    how: How,
    listed: Option<Listed<'a>>,
    tree: Option<Tree>,
    before: Option<Before>,
    /// What all searches so far found, where what is used often counts less.
    uses: Option<Usage<2>>,
}

/// How a level is searched.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct How {
    /// See [`Options::complete`](crate::Options::complete).
    pub(crate) alpha: Option<f64>,
    /// See [`Options::spread`](crate::Options::spread).
    pub(crate) spread: f64,
    /// Whether all places are asked but once.
    pub(crate) coherent: bool,
    /// Whether a tree is asked for what is near.
    pub(crate) tree: bool,
    /// Channels whose differences are compared as well: the exemplars have them after their own.
    pub(crate) differences: Option<usize>,
}

/// What was seen, and what was found there.
#[derive(Debug)]
struct Before {
    seen: Grid<u8, 2>,
    neighbors: Vec<Neighbor>,
    /// Which of them changed then.
    moved: Vec<bool>,
    coverage: Option<Coverage>,
}

impl<'a> Exact<'a> {
    pub(crate) fn new(exemplars: &'a Exemplars<2>, all: &'a Neighborhoods, how: How, simd: SimdLevel) -> Self {
        let places = Displaced { exemplars, weights: fitting(exemplars.weights(), all.size), all, simd };
        Self { places, how, listed: None, tree: None, before: None, uses: None }
    }

    /// For each neighborhood the nearest of the exemplars, the first of equal ones; `None` if there is none.
    ///
    /// Time `O(changed samples * samples of the exemplars * channels)`, whatever the size.
    pub(crate) fn search(&mut self, x: &Grid<f64, 2>) -> Result<Option<Found>, Error> {
        let seen = seen(x, self.how.differences)?;
        let whole = [0, 1].map(|a| 0..self.places.all.shape()[a]);
        let before = self.before.take();
        let known: Vec<Place> = before.iter().flat_map(|before| before.neighbors.iter().map(place)).collect();
        let mut coverage = None;
        let (neighbors, searched) = match (before, self.how.alpha) {
            _ if self.how.tree => (self.by_tree(&seen)?, self.places.all.len()),
            (Some(before), _) if self.how.coherent => {
                let refined = self.refined(&before, &seen)?;
                coverage = before.coverage;
                refined
            }
            (_, alpha) if self.how.spread != 0.0 => {
                let all = alpha.map(|_| self.places.coverage(&seen, &whole)).transpose()?;
                let found = self.evenly(&seen, whole, all.as_ref().zip(alpha))?;
                coverage = all.filter(|_| self.how.coherent);
                (found, self.places.all.len())
            }
            (_, Some(alpha)) => {
                let all = self.places.coverage(&seen, &whole)?;
                let found = self.places.complete(&seen, whole, (&all, alpha))?;
                coverage = self.how.coherent.then_some(all);
                (found, self.places.all.len())
            }
            (None, None) => (self.places.part(&seen, whole)?, self.places.all.len()),
            (Some(before), None) => {
                self.again(&before.seen, &seen, before.neighbors.into_iter().map(Some).collect())?
            }
        };
        Ok(self.noted(seen, neighbors, (&known, coverage), searched))
    }

    /// Keeps what was found, beside what was known before; `None` if no place is valid.
    fn noted(
        &mut self,
        seen: Grid<u8, 2>,
        neighbors: Vec<Option<Neighbor>>,
        (known, coverage): (&[Place], Option<Coverage>),
        searched: usize,
    ) -> Option<Found> {
        let neighbors = neighbors.into_iter().collect::<Option<Vec<Neighbor>>>()?;
        let places: Vec<Place> = neighbors.iter().map(place).collect();
        let distances = neighbors.iter().map(|n| n.error as f64 / self.compared()).collect();
        let moved = places.iter().enumerate().map(|(i, place)| known.get(i) != Some(place)).collect();
        self.uses.iter_mut().for_each(|uses| places.iter().for_each(|p| uses.note(p.source as usize, p.at)));
        self.before = Some(Before { seen, neighbors, moved, coverage });
        Some(Found { places, distances, searched })
    }

    /// The first search of a level whose neighborhoods came from somewhere: what is offered in parts where that fits
    /// by `limit` in the mean, and all places elsewhere. What continues them then is the nearest alone, or each frame
    /// would decide otherwise.
    pub(crate) fn search_carried(
        &mut self,
        x: &Grid<f64, 2>,
        offered: &(dyn Fn(usize) -> Vec<Place> + Sync),
        limit: f64,
    ) -> Result<Option<Found>, Error> {
        let seen = seen(x, self.how.differences)?;
        let listed = self.listed()?;
        let found = par::map_indexed(self.places.all.len(), |number| {
            let mut candidates = offered(number);
            candidates.retain(|place| listed.holds(*place));
            listed.best(&seen, number, &candidates, |_, error| error as f64)
        });
        self.listed = Some(listed);
        let columns = self.places.all.shape()[1];
        let lacks = |part: &[Range<usize>; 2]| {
            let own = part[0].clone().flat_map(|y| part[1].clone().map(move |x| y * columns + x));
            let errors: Option<u64> = own.map(|number| found[number].map(|found| found.error)).sum();
            let most = limit * self.compared() * (part[0].len() * part[1].len()) as f64;
            errors.is_none_or(|errors| most < errors as f64)
        };
        let whole = [0, 1].map(|a| 0..self.places.all.shape()[a]);
        let mut parts: Vec<[Range<usize>; 2]> = self.parts().filter(lacks).collect();
        // Each part is searched with what lies around it: most of them cost more than all at once.
        if self.parts().count() < 2 * parts.len() {
            parts = vec![whole.clone()];
        }
        // What came is no better known to be complete than what is found anew.
        let lacking = self.how.alpha.filter(|_| !parts.is_empty());
        let coverage = lacking.map(|_| self.places.coverage(&seen, &whole)).transpose()?;
        let (neighbors, searched) = self.some(&seen, parts, found, coverage.as_ref())?;
        Ok(self.noted(seen, neighbors, (&[], None), searched))
    }

    /// What a tree finds, which is made first.
    fn by_tree(&mut self, seen: &Grid<u8, 2>) -> Result<Vec<Option<Neighbor>>, Error> {
        let listed = self.listed()?;
        let Displaced { exemplars, weights, all, .. } = &self.places;
        let tree = self.tree.get_or_insert_with(|| Tree::new(exemplars, weights, all.size));
        let found = par::map_indexed(all.len(), |number| tree.nearest((all, number), seen, &listed));
        self.listed = Some(listed);
        Ok(found)
    }

    fn listed(&mut self) -> Result<Listed<'a>, Error> {
        match self.listed.take() {
            Some(listed) => Ok(listed),
            None => Ok(Listed::new(self.places.exemplars, self.places.weights.clone(), self.places.all)?),
        }
    }

    /// What neighborhoods have that continue those around them, where these or the samples changed.
    fn refined(&mut self, before: &Before, seen: &Grid<u8, 2>) -> Result<(Vec<Option<Neighbor>>, usize), Error> {
        let listed = self.listed()?;
        let changed = changed(self.places.all, &before.seen, seen);
        let sources = self.places.exemplars.sources();
        let widths: Vec<usize> = sources
            .iter()
            .map(|s| Windows { side: self.places.all.size, step: 1 }.over(s.domain()).shape[1] as usize)
            .collect();
        let times = |place: Place| match &self.uses {
            Some(uses) => evenness::times(uses, place),
            None => 1.0,
        };
        let scores =
            before.coverage.as_ref().zip(self.how.alpha).map(|(coverage, alpha)| (coverage, coverage.added(alpha)));
        let score = |place: Place, error: u64| match scores {
            Some((coverage, added)) => {
                let at = place.at[0] as usize * widths[place.source as usize] + place.at[1] as usize;
                times(place) * error as f64 / (coverage.least(place.source as usize)[at] as f64 + added)
            }
            None => times(place) * error as f64,
        };
        let found = par::map_indexed(self.places.all.len(), |number| {
            if !changed[number] && !self.places.all.around(number).any(|other| before.moved[other]) {
                return (before.neighbors[number], false);
            }
            let candidates = listed.around(&before.neighbors, number);
            (listed.best(seen, number, &candidates, score).unwrap_or(before.neighbors[number]), true)
        });
        let searched = found.iter().filter(|(_, searched)| *searched).count();
        self.listed = Some(listed);
        Ok((found.into_iter().map(|(neighbor, _)| Some(neighbor)).collect(), searched))
    }

    /// What an error is divided by to be a mean: samples times the weights of channels.
    fn compared(&self) -> f64 {
        let weights: f64 = self.places.weights.iter().map(|&w| f64::from(w)).sum();
        f64::from(self.places.all.size) * f64::from(self.places.all.size) * weights
    }

    /// The same after some samples changed.
    fn again(
        &self,
        before: &Grid<u8, 2>,
        seen: &Grid<u8, 2>,
        neighbors: Vec<Option<Neighbor>>,
    ) -> Result<(Vec<Option<Neighbor>>, usize), Error> {
        let parts = self.parts().filter(|part| self.changed(before, seen, part)).collect();
        self.some(seen, parts, neighbors, None)
    }

    /// All places for the neighborhoods of some parts, by their scores where `coverage` is known.
    fn some(
        &self,
        seen: &Grid<u8, 2>,
        parts: Vec<[Range<usize>; 2]>,
        mut neighbors: Vec<Option<Neighbor>>,
        coverage: Option<&Coverage>,
    ) -> Result<(Vec<Option<Neighbor>>, usize), Error> {
        let columns = self.places.all.shape()[1];
        let found = par::map_indexed(parts.len(), |i| match coverage.zip(self.how.alpha) {
            Some(by) => self.places.complete(seen, parts[i].clone(), by),
            None => self.places.part(seen, parts[i].clone()),
        });
        let mut searched = 0;
        for (part, found) in parts.into_iter().zip(found) {
            let found = found?;
            searched += found.len();
            for (row, found) in part[0].clone().zip(found.chunks(part[1].len())) {
                neighbors[row * columns..][part[1].clone()].copy_from_slice(found);
            }
        }
        Ok((neighbors, searched))
    }

    fn parts(&self) -> impl Iterator<Item = [Range<usize>; 2]> + use<> {
        let [rows, columns] = self.places.all.shape();
        let along = |n: usize| (0..n).step_by(PART).map(move |from| from..n.min(from + PART));
        along(rows).flat_map(move |y| along(columns).map(move |x| [y.clone(), x]))
    }

    /// Whether any sample of a part's neighborhoods changed.
    fn changed(&self, before: &Grid<u8, 2>, seen: &Grid<u8, 2>, part: &[Range<usize>; 2]) -> bool {
        let covered = [0, 1].map(|a| self.places.covered(a, &part[a]));
        let shape = self.places.all.domain.shape;
        (0..seen.channels()).any(|c| {
            let at = |y: u32, x: u32| self.places.all.domain.index([y % shape[0], x % shape[1]]);
            let rows = covered[0].clone();
            rows.flat_map(|y| covered[1].clone().map(move |x| at(y, x))).any(|i| before.plane(c)[i] != seen.plane(c)[i])
        })
    }

    /// The same, or the nearest, where a place that was used often counts more: in the first search by what is found
    /// without that.
    fn evenly(
        &mut self,
        seen: &Grid<u8, 2>,
        whole: [Range<usize>; 2],
        by: Option<(&Coverage, f64)>,
    ) -> Result<Vec<Option<Neighbor>>, Error> {
        let uses = match self.uses.take() {
            Some(uses) => uses,
            None => {
                let mut uses = Usage::new(self.places.exemplars, [self.places.all.size; 2], self.how.spread)?;
                let found = match by {
                    Some(by) => self.places.complete(seen, whole.clone(), by)?,
                    None => self.places.part(seen, whole.clone())?,
                };
                found.iter().flatten().for_each(|f| uses.note(f.source as usize, f.position));
                uses
            }
        };
        let counted = evenness::counted(self.places.exemplars, self.places.all.size, by, &uses);
        self.uses = Some(uses);
        self.places.complete(seen, whole, (&counted, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::falloff::Falloff;
    use crate::search::reference::Measure;
    use crate::testing::{exemplars, output};
    use selvedge_core::{Domain, Rng, Seed};

    fn noise(rng: &mut Rng, domain: Domain<2>) -> Grid<f64, 2> {
        let samples = (0..domain.len() * 2).map(|_| f64::from(rng.below(256))).collect();
        Grid::from_vec(domain, 2, samples).unwrap()
    }

    const LEVELS: [SimdLevel; 4] = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Auto];

    #[test]
    fn found_neighborhoods_are_those_of_the_definition_and_kept_ones_are_those_found() {
        let mut kept = 0;
        for case in 0..24 {
            let mut rng = Seed(case).derive("exact", 0).rng();
            let size = [8, 12][case as usize % 2];
            let exemplars = exemplars(&mut rng, [14, 17], true);
            let mut domain = output(&mut rng, size);
            domain.shape[1] += 20;
            let all = Neighborhoods::new(domain, size);
            let simd = LEVELS[case as usize / 2 % 4];
            let mut exact = Exact::new(&exemplars, &all, How::default(), simd);
            let mut x = noise(&mut rng, all.domain);
            for step in 0..3 {
                let found = exact.search(&x).unwrap().unwrap();
                let flat = Falloff::flat(size);
                let measure = Measure { exemplars: &exemplars, all: &all, falloff: &flat, mu: 0.0, texture: 2 };
                let plain = measure.search(&x, None).unwrap();
                assert_eq!(found.places, plain.places, "{case} {step}");
                let apart = found.distances.iter().zip(&plain.distances).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-9);
                assert!(0 < step || found.searched == all.len());
                kept += all.len() - found.searched;
                // One corner of the output changes.
                (0..2).for_each(|c| x.set(c, [rng.below(2), rng.below(3)], f64::from(rng.below(256))));
            }
        }
        assert!(500 < kept, "most neighborhoods are far from what changed: {kept}");
    }
    #[test]
    fn complete_neighborhoods_are_those_of_the_definition() {
        let mut others = 0;
        for case in 0..16 {
            let mut rng = Seed(case).derive("complete", 0).rng();
            let size = [8, 12][case as usize % 2];
            let exemplars = exemplars(&mut rng, [14, 17], true);
            let all = Neighborhoods::new(output(&mut rng, size), size);
            let x = noise(&mut rng, all.domain);
            // At 0 all that are nearest to some place score 1, but for what floats round.
            let alpha = [0.1, 0.2, 5.0][case as usize % 3];
            let how = How { alpha: Some(alpha), ..How::default() };
            let mut exact = Exact::new(&exemplars, &all, how, LEVELS[case as usize / 2 % 4]);
            let found = exact.search(&x).unwrap().unwrap();
            let flat = Falloff::flat(size);
            let measure = Measure { exemplars: &exemplars, all: &all, falloff: &flat, mu: 0.0, texture: 2 };
            let plain = |alpha| measure.search(&x, alpha).unwrap();
            let complete = plain(Some(alpha));
            assert_eq!(found.places, complete.places, "{case}");
            let apart = found.distances.iter().zip(&complete.distances).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-9);
            let nearest = plain(None).places;
            others += found.places.iter().zip(&nearest).filter(|(a, b)| a != b).count();
        }
        assert!(100 < others, "completeness changes what is found: {others}");
    }
}
