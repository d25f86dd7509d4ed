//! Errors as the paper has them, in exact fractions: a threshold on the mean weighted squared difference of samples.

use selvedge_core::{Error, Exemplars};

use crate::options::Threshold;

/// The largest error of a block, as a part of that of two random samples. The paper's 0.04 is 24 % on its first
/// exemplar (green scales), 43 % on olives, and 355 % on bricks, where nothing would split. At 24 % most blocks of all
/// exemplars split, and knots, bricks and olives come apart; the preference of twelve exemplars is best from 75 % on
/// (`DESIGN.md`), where only blocks split that fit hardly better than chance.
const MAX_ERROR: f64 = 0.75;
/// The largest error of a sample, as a part of that of two random ones: what the paper's absolute 0.02 is on its first
/// exemplar. No other was ranked.
const PIXEL_ERROR: f64 = 0.12;
/// Thresholds are rounded to so many parts: exact beside any that a person types.
const PARTS: u128 = 1_000_000;
/// Fractions of a squared 8-bit step in which the error of random samples is kept.
const FINE: u128 = 1 << 20;

/// Which of the two a threshold is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    Block,
    Pixel,
}

/// An error per sample, as a fraction of integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limit {
    numerator: u128,
    denominator: u128,
}

impl Limit {
    /// The threshold in the units of features: squared 8-bit steps times the channels' weights.
    pub(crate) fn of(threshold: Threshold, of: Of, exemplars: &Exemplars<2>) -> Self {
        let parts = |value: f64| (value * PARTS as f64).round() as u128;
        let fraction = match threshold {
            Threshold::Absolute(value) => {
                return Self { numerator: parts(value) * u128::from(largest(exemplars)), denominator: PARTS };
            }
            Threshold::OfRandom(value) => value,
            Threshold::Auto if of == Of::Block => MAX_ERROR,
            Threshold::Auto => PIXEL_ERROR,
        };
        Self { numerator: parts(fraction) * random_error(exemplars), denominator: PARTS * FINE }
    }

    /// This part of it, from 0 to 1.
    pub(crate) fn part(self, k: f64) -> Self {
        Self { numerator: self.numerator * (k * PARTS as f64).round() as u128, denominator: self.denominator * PARTS }
    }

    /// True if a sum of errors over so many samples is larger.
    pub(crate) fn is_passed(&self, error: u64, samples: u64) -> bool {
        u128::from(samples) * self.numerator < u128::from(error) * self.denominator
    }

    /// As a number in `[0, 1]`, the paper's unit.
    pub(crate) fn shown(&self, exemplars: &Exemplars<2>) -> f64 {
        self.numerator as f64 / self.denominator as f64 / largest(exemplars) as f64
    }

    /// In the units of features, rounded down.
    pub(crate) fn whole(&self) -> u64 {
        u64::try_from(self.numerator / self.denominator).unwrap_or(u64::MAX)
    }
}

/// Exemplars whose three channels are compared as the eye sees red, green and blue: by their shares of luminance, .299,
/// .587 and .114, in 256ths. Others stay as they are. `[Ding eq. 1]`
///
/// # Errors
/// None that these weights could have.
pub fn weighed(exemplars: &Exemplars<2>) -> Result<Exemplars<2>, Error> {
    let exemplars = exemplars.clone();
    if exemplars.channels() == 3 { exemplars.weighing(vec![77, 150, 29]) } else { Ok(exemplars) }
}

/// The error of black against white: what the paper's 1 stands for.
pub(crate) fn largest(exemplars: &Exemplars<2>) -> u64 {
    exemplars.weights().iter().map(|&w| u64::from(w)).sum::<u64>() * 255 * 255
}

/// The mean error of two random valid samples of one source, times [`FINE`]: twice its weighted variance. Sources count
/// by their valid samples.
pub(crate) fn random_error(exemplars: &Exemplars<2>) -> u128 {
    let (mut sum, mut samples) = (0_u128, 0_u128);
    for source in exemplars.sources() {
        let is_valid = |i: usize| source.valid.as_deref().is_none_or(|v| v.samples()[i]);
        let n = (0..source.domain().len()).filter(|&i| is_valid(i)).count() as u128;
        for (c, &weight) in exemplars.weights().iter().enumerate().filter(|_| 0 < n) {
            let values = source.features.plane(c).iter().enumerate().filter(|&(i, _)| is_valid(i));
            let (first, second) = values.fold((0_u128, 0_u128), |(first, second), (_, &v)| {
                (first + u128::from(v), second + u128::from(v) * u128::from(v))
            });
            // n times the variance, kept in fractions.
            sum += 2 * u128::from(weight) * ((n * second - first * first) * FINE / n);
        }
        samples += n;
    }
    sum / samples.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    fn exemplars(values: Vec<u8>, valid: Option<Vec<bool>>) -> Exemplars<2> {
        let domain = Domain::open([1, values.len() as u32 / 2]);
        let source = Source {
            features: Grid::from_vec(domain, 2, values).unwrap(),
            valid: valid.map(|v| Grid::from_vec(domain, 1, v).unwrap()).map(Into::into),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        Exemplars::from_sources(vec![source], vec![3, 2]).unwrap()
    }

    #[test]
    fn the_error_of_random_samples_is_the_mean_over_all_pairs_of_valid_ones() {
        let mut rng = Seed(1).rng();
        let values: Vec<u8> = (0..20).map(|_| rng.below(256) as u8).collect();
        let valid: Vec<bool> = (0..10).map(|i| i % 3 != 1).collect();
        let (mut sum, mut pairs) = (0, 0);
        for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))).filter(|&(i, j)| valid[i] && valid[j]) {
            let d = |c: usize| u64::from(values[10 * c + i].abs_diff(values[10 * c + j])).pow(2);
            (sum, pairs) = (sum + 3 * d(0) + 2 * d(1), pairs + 1);
        }
        let found = random_error(&exemplars(values, Some(valid))) as f64 / FINE as f64;
        assert!((found - sum as f64 / f64::from(pairs)).abs() < 1e-4, "{found}");
    }

    #[test]
    fn thresholds_are_fractions_of_random_or_of_the_largest_error() {
        let e = exemplars(vec![0, 100, 0, 100], None);
        // Two values 100 apart: half of all pairs differ.
        let random = (3 + 2) * 10_000 / 2;
        let limit = Limit::of(Threshold::Auto, Of::Block, &e);
        assert_eq!(limit.whole(), random * 75 / 100);
        assert!(limit.is_passed(random * 75 + 1, 100) && !limit.is_passed(random * 75, 100));
        assert_eq!(Limit::of(Threshold::OfRandom(2.0), Of::Pixel, &e).whole(), 2 * random);
        assert_eq!(Limit::of(Threshold::Auto, Of::Pixel, &e).whole(), random * 12 / 100);
        let absolute = Limit::of(Threshold::Absolute(0.04), Of::Block, &e);
        assert_eq!((absolute.whole(), absolute.part(0.5).whole()), (13_005, 6_502));
        assert!((absolute.shown(&e) - 0.04).abs() < 1e-12);
        assert!(!Limit::of(Threshold::Absolute(1.0), Of::Block, &e).is_passed(largest(&e), 1));
    }
}
