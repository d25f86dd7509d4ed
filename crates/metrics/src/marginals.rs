//! Columns of single samples and small differences: contrast, sharpness, colour, blandness, shade.

use crate::error::Error;
use crate::scaled;
use selvedge_core::{Exemplars, Grid};

/// A picture and which of its samples count.
pub(crate) type Valid<'a> = (&'a Grid<u8, 2>, Option<&'a Grid<bool, 2>>);

/// First sources with their validity.
pub(crate) fn pictures(exemplars: &Exemplars<2>) -> Vec<Valid<'_>> {
    exemplars.firsts().map(|s| (&s.features, s.valid.as_deref())).collect()
}

fn counts(valid: Option<&Grid<bool, 2>>, i: usize) -> bool {
    valid.is_none_or(|v| v.plane(0)[i])
}

/// Histogram of one channel.
fn histogram(pictures: &[Valid<'_>], channel: usize) -> [u64; 256] {
    let mut bins = [0; 256];
    for (grid, valid) in pictures {
        for (i, &v) in grid.plane(channel).iter().enumerate().filter(|&(i, _)| counts(*valid, i)) {
            let _ = i;
            bins[usize::from(v)] += 1;
        }
    }
    bins
}

/// Weighted root mean square of the channels' standard deviations; at least half a step, so that flat exemplars divide
/// nothing by 0.
pub(crate) fn contrast(exemplars: &Exemplars<2>) -> f64 {
    let pictures = pictures(exemplars);
    let mut sum = 0.0;
    let weights: f64 = exemplars.weights().iter().map(|&w| f64::from(w)).sum();
    for (c, &w) in exemplars.weights().iter().enumerate() {
        let bins = histogram(&pictures, c);
        let n = bins.iter().sum::<u64>().max(1) as f64;
        let moment = |power: i32| {
            let of = |(v, &n): (usize, &u64)| if power == 1 { v as f64 } else { (v * v) as f64 } * n as f64;
            bins.iter().enumerate().map(of).sum::<f64>() / n
        };
        sum += f64::from(w) * (moment(2) - moment(1) * moment(1)).max(0.0);
    }
    (sum / weights.max(1.0)).sqrt().max(0.5)
}

/// Wasserstein-1 distance of the samples' distributions, mean of the channels, in 8-bit steps.
pub(crate) fn colour(a: &[Valid<'_>], b: &[Valid<'_>]) -> f64 {
    let channels = b[0].0.channels();
    let one = |c: usize| {
        let (a, b) = (histogram(a, c), histogram(b, c));
        let (n, m) = (a.iter().sum::<u64>().max(1) as f64, b.iter().sum::<u64>().max(1) as f64);
        let (mut below_a, mut below_b, mut distance) = (0, 0, 0.0);
        for v in 0..256 {
            (below_a, below_b) = (below_a + a[v], below_b + b[v]);
            distance += (below_a as f64 / n - below_b as f64 / m).abs();
        }
        distance
    };
    (0..channels).map(one).sum::<f64>() / channels.max(1) as f64
}

/// Mean absolute second difference along both axes: four times a sample less its neighbours.
pub(crate) fn sharpness(pictures: &[Valid<'_>]) -> f64 {
    let (mut sum, mut n) = (0_u64, 0_u64);
    for (grid, valid) in pictures {
        let [h, w] = grid.domain().shape.map(|n| n as usize);
        for c in 0..grid.channels() {
            let plane = grid.plane(c);
            for y in 1..h.saturating_sub(1) {
                for i in y * w + 1..(y * w + w).saturating_sub(1) {
                    let around = [i - w, i - 1, i + 1, i + w];
                    if counts(*valid, i) && around.iter().all(|&j| counts(*valid, j)) {
                        let near: i32 = around.iter().map(|&j| i32::from(plane[j])).sum();
                        sum += u64::from((4 * i32::from(plane[i]) - near).unsigned_abs());
                        n += 1;
                    }
                }
            }
        }
    }
    sum as f64 / n.max(1) as f64
}

/// Variances of windows of `side` samples, half of it apart, all channels; in no order.
pub(crate) fn variances(pictures: &[Valid<'_>], side: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for (grid, valid) in pictures {
        let [h, w] = grid.domain().shape.map(|n| n as usize);
        let starts = |n: usize| (0..(n + 1).saturating_sub(side)).step_by(side / 2);
        for (y, x) in starts(h).flat_map(|y| starts(w).map(move |x| (y, x))) {
            let inside = || (y..y + side).flat_map(|y| (x..x + side).map(move |x| y * w + x));
            if !inside().all(|i| counts(*valid, i)) {
                continue;
            }
            let of = |c: usize| {
                let plane = grid.plane(c);
                let (mut sum, mut squares) = (0_u64, 0_u64);
                for i in inside() {
                    let v = u64::from(plane[i]);
                    (sum, squares) = (sum + v, squares + v * v);
                }
                let n = (side * side) as u64;
                (n * squares - sum * sum) as f64
            };
            all.push((0..grid.channels()).map(of).sum());
        }
    }
    all
}

/// Share of `values` below the tenth part of `among`, less that tenth; 0 without either.
pub(crate) fn below_tenth(values: &[f64], among: &[f64]) -> f64 {
    if values.is_empty() || among.is_empty() {
        return 0.0;
    }
    let mut sorted = among.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let tenth = sorted[sorted.len() / 10];
    let share = |of: &[f64]| of.iter().filter(|&&v| v < tenth).count() as f64 / of.len() as f64;
    share(values) - share(among)
}

/// Variance of a picture that was halved `times` more, all channels; `None` where nothing is left.
pub(crate) fn shade(picture: &Grid<u8, 2>, times: usize) -> Result<Option<f64>, Error> {
    let mut small = scaled::halved(picture)?;
    for _ in 1..times {
        small = scaled::halved(&small)?;
    }
    let n = small.domain().len();
    if n < 4 {
        return Ok(None);
    }
    let of = |c: usize| {
        let (mut sum, mut squares) = (0_u64, 0_u64);
        for &v in small.plane(c) {
            (sum, squares) = (sum + u64::from(v), squares + u64::from(v).pow(2));
        }
        (n as u64 * squares - sum * sum) as f64 / (n * n) as f64
    };
    Ok(Some((0..small.channels()).map(of).sum()))
}
