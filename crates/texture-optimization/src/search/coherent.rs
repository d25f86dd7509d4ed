//! Neighborhoods that continue those around them: candidates instead of all places.

use selvedge_core::{Error, Exemplars, Grid, par};
use selvedge_fft_ssd::Neighbor;

use crate::assignment::Place;
use crate::neighborhoods::{Neighborhoods, places};

/// Distances at listed places, on samples rounded to 8 bits: the same numbers as those of the exact search.
#[derive(Debug)]
pub(crate) struct Listed<'a> {
    exemplars: &'a Exemplars<2>,
    weights: Vec<u8>,
    all: &'a Neighborhoods,
    /// By source, where a neighborhood can stand.
    offered: Vec<Grid<bool, 2>>,
}

impl<'a> Listed<'a> {
    pub(crate) fn new(exemplars: &'a Exemplars<2>, weights: Vec<u8>, all: &'a Neighborhoods) -> Result<Self, Error> {
        let offered = exemplars.sources().iter().map(|source| {
            let mut grid = Grid::try_filled(source.domain(), 1, false)?;
            places(source, all.size).for_each(|at| grid.set(0, at, true));
            Ok(grid)
        });
        Ok(Self { exemplars, weights, all, offered: offered.collect::<Result<_, Error>>()? })
    }

    /// Whether a neighborhood can stand at a place.
    pub(crate) fn holds(&self, place: Place) -> bool {
        self.offered[place.source as usize].get(0, place.at)
    }

    /// What stands at a distance from a place, around periodic axes, if a neighborhood can.
    fn moved(&self, place: Place, by: [i32; 2]) -> Option<Place> {
        place.moved(self.exemplars, by).filter(|place| self.holds(*place))
    }

    /// The own place of a neighborhood, and those at which the eight around it would be continued.
    pub(crate) fn around(&self, own: &[Neighbor], number: usize) -> Vec<Place> {
        let mut candidates = vec![place(&own[number])];
        for other in self.all.around(number) {
            let continued = self.moved(place(&own[other]), self.all.way(other, number));
            candidates.extend(continued.filter(|place| !candidates.contains(place)));
        }
        candidates
    }

    /// The best of some places by `score`, which is asked for the place and its error; the first of equal ones.
    pub(crate) fn best(
        &self,
        seen: &Grid<u8, 2>,
        number: usize,
        candidates: &[Place],
        score: impl Fn(Place, u64) -> f64,
    ) -> Option<Neighbor> {
        let mut best: Option<(f64, Neighbor)> = None;
        for &place in candidates {
            let error = self.error(seen, number, place);
            let score = score(place, error);
            if best.is_none_or(|b| score < b.0) {
                best = Some((score, Neighbor { source: place.source, position: place.at, error }));
            }
        }
        best.map(|b| b.1)
    }

    /// `sum of W_c (x - z)^2`.
    fn error(&self, seen: &Grid<u8, 2>, number: usize, place: Place) -> u64 {
        let (first, size) = (self.all.first(number), self.all.size);
        let source = &self.exemplars.sources()[place.source as usize].features;
        let (here, there) = (self.all.domain, source.domain());
        let mut sum = 0;
        for (c, &weight) in self.weights.iter().enumerate() {
            let (mut of_channel, mut done) = (0_u64, 0);
            // Both may wrap: pieces of columns that neither of them breaks.
            while done < size {
                let x = (first[1] + done) % here.shape[1];
                let z = (place.at[1] + done) % there.shape[1];
                let piece = (size - done).min(here.shape[1] - x).min(there.shape[1] - z);
                for row in 0..size {
                    let from = here.index([(first[0] + row) % here.shape[0], x]);
                    let to = there.index([(place.at[0] + row) % there.shape[0], z]);
                    let pairs =
                        seen.plane(c)[from..][..piece as usize].iter().zip(&source.plane(c)[to..][..piece as usize]);
                    // A row of the largest neighborhood fits 32 bits.
                    let squares = pairs.map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum::<u32>();
                    of_channel += u64::from(squares);
                }
                done += piece;
            }
            sum += u64::from(weight) * of_channel;
        }
        sum
    }
}

pub(crate) fn place(neighbor: &Neighbor) -> Place {
    Place { source: neighbor.source, at: neighbor.position }
}

/// What a picture looks like now, of which of its neighborhoods changed since before.
pub(crate) fn changed(all: &Neighborhoods, before: &Grid<u8, 2>, seen: &Grid<u8, 2>) -> Vec<bool> {
    let domain = all.domain;
    let width = domain.shape[1] as usize;
    // Rows in which a column of neighborhoods changed: along rows first, then down.
    let along = par::map_indexed(domain.shape[0] as usize, |y| {
        let of =
            |x: usize| (0..seen.channels()).any(|c| before.plane(c)[y * width + x] != seen.plane(c)[y * width + x]);
        let mut sums = vec![0_u32; width + 1];
        (0..width).for_each(|x| sums[x + 1] = sums[x] + u32::from(of(x)));
        let within = |first: u32| {
            let end = (first + all.size) as usize;
            let wrapped = end.saturating_sub(width);
            sums[end - wrapped] - sums[first as usize] + sums[wrapped]
        };
        all.firsts[1].iter().map(|&first| within(first) != 0).collect::<Vec<bool>>()
    });
    let rows = domain.shape[0];
    par::map_indexed(all.len(), |number| {
        let column = number % all.firsts[1].len();
        let first = all.first(number)[0];
        (first..first + all.size).any(|y| along[(y % rows) as usize][column])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::falloff::Falloff;
    use crate::search::reference::Measure;
    use crate::testing::{exemplars, output};
    use selvedge_core::Seed;

    #[test]
    fn errors_are_those_of_the_definition_and_candidates_continue_their_neighbors() {
        for case in 0..20 {
            let mut rng = Seed(case).rng();
            let exemplars = exemplars(&mut rng, [13, 17], true);
            let all = Neighborhoods::new(output(&mut rng, 8), 8);
            let listed = Listed::new(&exemplars, exemplars.weights().to_vec(), &all).unwrap();
            let samples = (0..all.domain.len() * 2).map(|_| rng.below(256) as u8).collect();
            let seen = Grid::from_vec(all.domain, 2, samples).unwrap();
            let x = seen.map(f64::from).unwrap();
            let own: Vec<Neighbor> = crate::assignment::random(&exemplars, &all, Seed(case))
                .unwrap()
                .into_iter()
                .map(|p| Neighbor { source: p.source, position: p.at, error: 0 })
                .collect();
            let weights: f64 = exemplars.weights().iter().map(|&w| f64::from(w)).sum();
            for number in 0..all.len() {
                let candidates = listed.around(&own, number);
                assert_eq!(candidates[0], place(&own[number]));
                let mut least = f64::INFINITY;
                for &candidate in &candidates {
                    let of = (number, candidate);
                    let flat = Falloff::flat(8);
                    let measure = Measure { exemplars: &exemplars, all: &all, falloff: &flat, mu: 0.0, texture: 2 };
                    let plain = measure.distance(&x, of, f64::INFINITY);
                    assert!((listed.error(&seen, number, candidate) as f64 / (64.0 * weights) - plain).abs() < 1e-9);
                    least = least.min(plain);
                }
                let best = listed.best(&seen, number, &candidates, |_, error| error as f64).unwrap();
                assert!((best.error as f64 / (64.0 * weights) - least).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn neighborhoods_change_where_a_sample_of_them_does() {
        for case in 0..40 {
            let mut rng = Seed(case).rng();
            let all = Neighborhoods::new(output(&mut rng, 8), 8);
            let before = Grid::try_filled(all.domain, 2, 7_u8).unwrap();
            let mut seen = before.clone();
            let at = all.domain.position(rng.below(all.domain.len() as u32) as usize);
            seen.set(rng.below(2) as usize, at, 8);
            let shape = all.domain.shape;
            for (number, changed) in changed(&all, &before, &seen).into_iter().enumerate() {
                let first = all.first(number);
                let holds = (0..2).all(|axis| (at[axis] + shape[axis] - first[axis]) % shape[axis] < 8);
                assert_eq!(changed, holds, "{case} {number}");
            }
        }
    }
}
