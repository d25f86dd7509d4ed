//! The definition: every place, unrounded samples, the fall-off of averages.

use selvedge_core::{Exemplars, Grid, par};

use super::Found;
use crate::assignment::Place;
use crate::falloff::Falloff;
use crate::neighborhoods::{Neighborhoods, places};
use crate::robust;

/// What both steps weigh: how far a neighborhood is from a place, the mean of `G W_c (x - z)^2` and of `mu` times as
/// much of each difference between samples beside each other within it.
pub(crate) struct Measure<'a> {
    pub(crate) exemplars: &'a Exemplars<2>,
    pub(crate) all: &'a Neighborhoods,
    pub(crate) falloff: &'a Falloff,
    /// How much differences count; 0 for not at all.
    pub(crate) mu: f64,
    /// Channels whose differences count.
    pub(crate) texture: usize,
}

impl Measure<'_> {
    /// For each neighborhood of `x` the nearest of the exemplars; with `alpha` the one of least distance divided by how
    /// near `x` comes to it anywhere, plus `alpha` of the mean of that (see [`Coverage`](selvedge_fft_ssd::Coverage)).
    /// The first of equal ones. `None` if no neighborhood of the exemplars is valid.
    ///
    /// Time `O(neighborhoods * places * size^2 * channels)`.
    pub(crate) fn search(&self, x: &Grid<f64, 2>, alpha: Option<f64>) -> Option<Found> {
        let of = |source: usize| {
            let at = places(&self.exemplars.sources()[source], self.all.size);
            at.map(move |at| Place { source: source as u32, at })
        };
        let offered: Vec<Place> = (0..self.exemplars.sources().len()).flat_map(of).collect();
        let distance = |number, place, limit| self.distance(x, (number, place), limit);
        let covered =
            |i: usize| (0..self.all.len()).fold(f64::INFINITY, |d, number| d.min(distance(number, offered[i], d)));
        let divisors = alpha.map_or_else(
            || vec![1.0; offered.len()],
            |alpha| {
                let least = par::map_indexed(offered.len(), covered);
                // At least a step of a sample of one channel, as there.
                let added = (alpha * robust::mean(&least)).max(1.0 / self.compared());
                least.into_iter().map(|least| least + added).collect()
            },
        );
        let nearest = |number: usize| {
            let mut best: Option<(f64, f64, Place)> = None;
            for (&place, divisor) in offered.iter().zip(&divisors) {
                let limit = best.map_or(f64::INFINITY, |b| b.0);
                let d = distance(number, place, limit * divisor);
                if d / divisor < limit {
                    best = Some((d / divisor, d, place));
                }
            }
            best.map(|(_, d, place)| (d, place))
        };
        let best: Option<Vec<_>> = par::map_indexed(self.all.len(), nearest).into_iter().collect();
        let (distances, places): (Vec<f64>, Vec<Place>) = best?.into_iter().unzip();
        Some(Found { searched: places.len(), places, distances })
    }

    /// What sums are divided by to be means.
    fn compared(&self) -> f64 {
        let heavy = |weights: &[u8]| weights.iter().map(|&w| f64::from(w)).sum::<f64>();
        let weights = self.exemplars.weights();
        self.falloff.sum() * (heavy(weights) + 2.0 * self.mu * heavy(&weights[..self.texture]))
    }

    /// The distance of a neighborhood to a place; anything from `limit` on where it is no less.
    pub(crate) fn distance(&self, x: &Grid<f64, 2>, (number, place): (usize, Place), limit: f64) -> f64 {
        let (whole, falloff, size) = (self.compared(), self.falloff.along(), self.all.size);
        let between = if self.mu == 0.0 { Vec::new() } else { self.falloff.between() };
        let (first, shape) = (self.all.first(number), self.all.domain.shape);
        let source = &self.exemplars.sources()[place.source as usize];
        let apart = |by: [u32; 2], c: usize| {
            let here = [0, 1].map(|a| (first[a] + by[a]) % shape[a]);
            let there = place.sample(self.exemplars, by);
            x.get(c, here) - f64::from(source.features.get(c, there))
        };
        let mut sum = 0.0;
        for dy in 0..size {
            if limit <= sum / whole {
                return sum / whole;
            }
            for dx in 0..size {
                let [gy, gx] = [dy, dx].map(|d| falloff[d as usize]);
                for (c, &w) in self.exemplars.weights().iter().enumerate().filter(|(_, w)| **w != 0) {
                    let by = apart([dy, dx], c);
                    sum += gy * gx * f64::from(w) * by * by;
                    if self.mu == 0.0 || self.texture <= c {
                        continue;
                    }
                    let mu = self.mu * f64::from(w);
                    if dy + 1 < size {
                        let by = apart([dy + 1, dx], c) - by;
                        sum += mu * between[dy as usize] * gx * by * by;
                    }
                    if dx + 1 < size {
                        let by = apart([dy, dx + 1], c) - by;
                        sum += mu * gy * between[dx as usize] * by * by;
                    }
                }
            }
        }
        sum / whole
    }
}
