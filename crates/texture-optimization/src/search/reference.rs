//! The definition: every place, unrounded samples, the fall-off of averages.

use selvedge_core::{Exemplars, Grid, par};

use super::Found;
use crate::assignment::Place;
use crate::falloff::Falloff;
use crate::neighborhoods::{Neighborhoods, places};
use crate::robust;

/// For each neighborhood of `x` the nearest of the exemplars, `sum of G W_c (x - z)^2` over the sums of both weights;
/// with `alpha` the one of least distance divided by how near `x` comes to it anywhere, plus `alpha` of the mean of
/// that (see [`Coverage`](selvedge_fft_ssd::Coverage)). The first of equal ones. `None` if no neighborhood of the
/// exemplars is valid.
///
/// Time `O(neighborhoods * places * size^2 * channels)`.
pub(crate) fn search(
    exemplars: &Exemplars<2>,
    all: &Neighborhoods,
    falloff: &Falloff,
    x: &Grid<f64, 2>,
    alpha: Option<f64>,
) -> Option<Found> {
    let of = |source: usize| {
        let at = places(&exemplars.sources()[source], all.size);
        at.map(move |at| Place { source: source as u32, at })
    };
    let offered: Vec<Place> = (0..exemplars.sources().len()).flat_map(of).collect();
    let distance = |number, place, limit| distance(exemplars, all, falloff, x, (number, place), limit);
    let covered = |i: usize| (0..all.len()).fold(f64::INFINITY, |d, number| d.min(distance(number, offered[i], d)));
    let divisors = alpha.map_or_else(
        || vec![1.0; offered.len()],
        |alpha| {
            let least = par::map_indexed(offered.len(), covered);
            // At least a step of a sample of one channel, as there.
            let added = (alpha * robust::mean(&least)).max(1.0 / compared(exemplars, falloff));
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
    let best: Option<Vec<_>> = par::map_indexed(all.len(), nearest).into_iter().collect();
    let (distances, places): (Vec<f64>, Vec<Place>) = best?.into_iter().unzip();
    Some(Found { searched: places.len(), places, distances })
}

/// What sums are divided by to be means.
fn compared(exemplars: &Exemplars<2>, falloff: &Falloff) -> f64 {
    let heavy: f64 = exemplars.weights().iter().map(|&w| f64::from(w)).sum();
    falloff.sum() * heavy
}

/// The distance of a neighborhood to a place; anything from `limit` on where it is no less.
pub(crate) fn distance(
    exemplars: &Exemplars<2>,
    all: &Neighborhoods,
    falloff: &Falloff,
    x: &Grid<f64, 2>,
    (number, place): (usize, Place),
    limit: f64,
) -> f64 {
    let whole = compared(exemplars, falloff);
    let (first, source) = (all.first(number), &exemplars.sources()[place.source as usize]);
    let shape = all.domain.shape;
    let mut sum = 0.0;
    for dy in 0..all.size {
        if limit <= sum / whole {
            return sum / whole;
        }
        for dx in 0..all.size {
            let here = all.domain.index([(first[0] + dy) % shape[0], (first[1] + dx) % shape[1]]);
            let there = source.domain().index(place.sample(exemplars, [dy, dx]));
            let g = falloff.along()[dy as usize] * falloff.along()[dx as usize];
            for (c, &w) in exemplars.weights().iter().enumerate() {
                let by = x.plane(c)[here] - f64::from(source.features.plane(c)[there]);
                sum += g * f64::from(w) * by * by;
            }
        }
    }
    sum / whole
}
