//! The texture that is nearest to all neighborhoods that were found: the E-step. `[Kwatra05 3]`

use selvedge_core::{Exemplars, Grid, par};

use crate::Error;
use crate::assignment::Place;
use crate::falloff::Falloff;
use crate::neighborhoods::Neighborhoods;

/// `x`: each sample the average of the samples that neighborhoods have there, by their weights and the fall-off. That
/// minimises `sum of omega_p G(k - p) (x(k) - z_p(k))^2`.
///
/// Answers with `x` and the sums of weights.
///
/// Time `O(samples * channels * 16)`, in the caller's pool. Each sample is summed in the order of neighborhoods.
pub(crate) fn average(
    exemplars: &Exemplars<2>,
    all: &Neighborhoods,
    found: &[Place],
    weights: &[f64],
    falloff: &Falloff,
) -> Result<(Grid<f64, 2>, Grid<f64, 2>), Error> {
    let sums = sums(&Fields::of(exemplars), all, found, weights, [falloff.along(); 2])?;
    let channels = exemplars.channels();
    let mut x = Grid::try_filled(all.domain, channels, 0.0)?;
    for c in 0..channels {
        let each = x.plane_mut(c).iter_mut().zip(sums.plane(c)).zip(sums.plane(channels));
        each.for_each(|((v, sum), weight)| *v = sum / weight);
    }
    let mut votes = Grid::try_filled(all.domain, 1, 0.0)?;
    votes.plane_mut(0).copy_from_slice(sums.plane(channels));
    Ok((x, votes))
}

/// What neighborhoods have at their samples: a grid a source, of as many channels.
pub(crate) struct Fields<'a, T>(pub(crate) Vec<&'a Grid<T, 2>>);

impl<'a> Fields<'a, u8> {
    /// The features themselves.
    pub(crate) fn of(exemplars: &'a Exemplars<2>) -> Self {
        Self(exemplars.sources().iter().map(|source| &source.features).collect())
    }
}

/// Of each sample the sum of what neighborhoods have there, by their weights and by weights down and across them, in a
/// channel for each of the fields', and in the last one the sum of these weights.
pub(crate) fn sums<T: Copy + Into<f64> + Sync>(
    fields: &Fields<'_, T>,
    all: &Neighborhoods,
    found: &[Place],
    weights: &[f64],
    [down, across]: [&[f64]; 2],
) -> Result<Grid<f64, 2>, Error> {
    let (domain, channels) = (all.domain, fields.0[0].channels());
    let width = domain.shape[1] as usize;
    let mut rows = Grid::try_filled(domain, channels + 1, 0.0)?.into_vec();
    // Row by row, channels within, sums of weights last: each row is one thread's.
    par::for_rows(&mut rows, width * (channels + 1), |y, row| {
        let (row, sums) = row.split_at_mut(width * channels);
        for (j, by) in all.holding(0, y as u32) {
            for i in 0..all.firsts[1].len() {
                let number = j * all.firsts[1].len() + i;
                let weight = weights[number] * down[by as usize];
                let place = found[number];
                add(fields.0[place.source as usize], all, place, (i, by), (weight, across), (row, sums));
            }
        }
    });
    let mut planar = Grid::try_filled(domain, channels + 1, 0.0)?;
    for c in 0..=channels {
        let rows = rows.chunks_exact(width * (channels + 1));
        for (to, row) in planar.plane_mut(c).chunks_exact_mut(width).zip(rows) {
            to.copy_from_slice(&row[c * width..][..width]);
        }
    }
    Ok(planar)
}

/// One row of a neighborhood, added to a row of the output and to the sums of weights.
fn add<T: Copy + Into<f64>>(
    source: &Grid<T, 2>,
    all: &Neighborhoods,
    place: Place,
    (column, by): (usize, u32),
    (weight, across): (f64, &[f64]),
    (row, sums): (&mut [f64], &mut [f64]),
) {
    let shape = source.domain().shape;
    let from = [(place.at[0] + by) % shape[0], place.at[1]];
    let (first, n) = (all.firsts[1][column] as usize, sums.len());
    let (line, length) = (source.domain().index([from[0], 0]), shape[1] as usize);
    let mut done = 0;
    let size = all.size as usize;
    // Both may wrap: pieces that neither of them breaks.
    while done < size {
        let (to, at) = ((first + done) % n, (from[1] as usize + done) % length);
        let piece = (size - done).min(n - to).min(length - at);
        let across = &across[done..done + piece];
        for (sum, g) in sums[to..to + piece].iter_mut().zip(across) {
            *sum += weight * g;
        }
        for (c, values) in row.chunks_exact_mut(n).enumerate() {
            let from = &source.plane(c)[line + at..][..piece];
            for ((v, &z), g) in values[to..to + piece].iter_mut().zip(from).zip(across) {
                let z: f64 = z.into();
                *v += weight * g * z;
            }
        }
        done += piece;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{exemplars, output};
    use selvedge_core::{Domain, Seed};

    #[test]
    fn the_average_is_the_least_squares_texture() {
        for case in 0..40 {
            let mut rng = Seed(case).rng();
            let exemplars = exemplars(&mut rng, [12, 15], false);
            let all = Neighborhoods::new(output(&mut rng, 8), 8);
            let found = crate::assignment::random(&exemplars, &all, Seed(case)).unwrap();
            let weights: Vec<f64> = (0..all.len()).map(|_| 0.25 + f64::from(rng.below(100))).collect();
            let falloff = Falloff::new(8);
            let (x, weighed) = average(&exemplars, &all, &found, &weights, &falloff).unwrap();
            let n = all.domain.shape;
            // By their definition: numerator and denominator of each sample, neighborhood by neighborhood.
            let mut sums = vec![[0.0; 3]; all.domain.len()];
            for (number, place) in found.iter().enumerate() {
                let source = &exemplars.sources()[place.source as usize];
                for by in Domain::open([8, 8]).positions() {
                    let to = [0, 1].map(|a| (all.first(number)[a] + by[a]) % n[a]);
                    let from = [0, 1].map(|a| (place.at[a] + by[a]) % source.domain().shape[a]);
                    let g = weights[number] * falloff.along()[by[0] as usize] * falloff.along()[by[1] as usize];
                    let sums = &mut sums[all.domain.index(to)];
                    (0..2).for_each(|c| sums[c] += g * f64::from(source.features.get(c, from)));
                    sums[2] += g;
                }
            }
            for (i, [a, b, all]) in sums.into_iter().enumerate() {
                assert!((weighed.plane(0)[i] - all).abs() < 1e-9);
                for (c, sum) in [a, b].into_iter().enumerate() {
                    assert!((x.plane(c)[i] - sum / all).abs() < 1e-9, "{case} {c} {i}");
                }
            }
        }
    }
}
