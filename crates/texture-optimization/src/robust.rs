//! Weights of neighborhoods, so that those which fit badly pull less. `[Kwatra05 3.1]`

/// Squared grey levels that are added to a mean squared distance: one level. Without it a neighborhood that fits
/// perfectly would weigh infinitely much.
const LEVEL: f64 = 1.0;

/// `omega_p` by mean squared distances, with a mean of 1, so that what is added to it keeps its meaning at every level
/// and iteration.
pub(crate) fn weights(distances: &[f64], exponent: f64) -> Vec<f64> {
    let raw: Vec<f64> = distances.iter().map(|d| libm::pow(d + LEVEL, (exponent - 2.0) / 2.0)).collect();
    let mean = mean(&raw);
    raw.into_iter().map(|w| w / mean).collect()
}

/// The mean of what a neighborhood adds to the robust energy.
pub(crate) fn energy(distances: &[f64], exponent: f64) -> f64 {
    let all: Vec<f64> = distances.iter().map(|d| libm::pow(d + LEVEL, exponent / 2.0)).collect();
    mean(&all)
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_better_weighs_more_and_the_mean_is_1() {
        let w = weights(&[0.0, 3.0, 99.0], 0.8);
        assert!((mean(&w) - 1.0).abs() < 1e-12);
        // (1 / 4)^-0.6 and (1 / 100)^-0.6.
        assert!((w[0] / w[1] - 2.2974).abs() < 1e-4 && (w[0] / w[2] - 15.8489).abs() < 1e-4, "{w:?}");
        assert_eq!(weights(&[5.0, 80.0], 2.0), [1.0, 1.0]);
    }
}
