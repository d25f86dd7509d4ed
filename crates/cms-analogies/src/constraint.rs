//! What an output has to look like: a guide at a resolution of its own.

use selvedge_core::{Error as CoreError, Exemplars, Guide};

use crate::error::Error;
use crate::options::{MOST_WEIGHT, Options};

/// The price of one grey level, that of [`SeamCosts`](selvedge_core::SeamCosts).
pub(crate) const LEVEL: f64 = 16.0;
/// Fractional bits of a factor: those of `K = 0.01` keep three digits.
pub(crate) const FRACTION: u32 = 20;
/// Channels of weight 1 whose sum is what `K` was made for: the paper's red, green and blue.
const CHANNELS: f64 = 3.0;
/// Below this bit of a packed sum stands the squared error, from it on the number of samples. The largest
/// neighborhood's error in 24 channels of weight 255 needs 41 bits, its number of samples 13.
const COUNT_AT: u32 = 44;

/// Agreement costs no sample more than this: half of what a hole costs, so that everything is better than a hole.
pub(crate) const MOST_AGREEMENT: i32 = 1 << 27;
/// What a hole costs: the dummy label of step 0. No price may be higher. `[CMS IV-C step 0]`
pub(crate) const DUMMY: i32 = 1 << 28;

/// One constraint: `Q` under the exemplars and `C` under the output. `[CMS III]`
#[derive(Clone, Debug)]
pub struct Constraint {
    /// Both at the output's resolution. What is not asked for agrees with everything; what of a source is not valid,
    /// and what lies beyond borders, is a missing tap.
    pub guide: Guide<2>,
    /// Distance of the taps of a neighborhood in samples: how many times coarser `C` was than the output. 1 for maps of
    /// the same resolution.
    pub ratio: u32,
    /// How much it counts beside other constraints. Weights of the guide's channels are scaled to sum 3, so that `K`
    /// means the same for any number of channels.
    pub weight: f64,
}

impl Constraint {
    /// A guide of the output's resolution that weighs 1.
    pub const fn new(guide: Guide<2>) -> Self {
        Self { guide, ratio: 1, weight: 1.0 }
    }

    /// A neighborhood's side in samples of the output.
    fn side(&self, options: &Options) -> u32 {
        options.neighborhood.saturating_mul(self.ratio).saturating_mul(2).saturating_add(1)
    }

    /// True where output and some exemplar hold two neighborhoods along each axis.
    pub(crate) fn fits_twice(&self, exemplars: &Exemplars<2>, options: &Options) -> bool {
        let least = self.side(options).saturating_mul(2);
        let holds = |shape: [u32; 2]| shape.iter().all(|&n| least <= n);
        holds(self.guide.target().domain().shape) && exemplars.table().sources().iter().any(|(_, s)| holds(s.shape))
    }

    /// Fits exemplars, options, and the output that the first constraint lies under.
    pub(crate) fn check(&self, exemplars: &Exemplars<2>, first: &Self, options: &Options) -> Result<(), Error> {
        let range = "0 to 10000, times K as well";
        if !(0.0..=MOST_WEIGHT).contains(&self.weight) || MOST_WEIGHT < self.weight * options.constraint_weight {
            return Err(CoreError::range("weight", self.weight, range).into());
        }
        if !(1..=256).contains(&self.ratio) {
            return Err(CoreError::range("ratio", self.ratio, "1 to 256").into());
        }
        self.guide.check(exemplars)?;
        let [expected, found] = [first, self].map(|c| c.guide.target().domain());
        if expected != found {
            return Err(Error::Target { expected: expected.shape.to_vec(), found: found.shape.to_vec() });
        }
        let side = self.side(options);
        let holds = |shape: [u32; 2]| shape.iter().all(|&n| side <= n);
        if !holds(found.shape) {
            return Err(Error::Neighborhood { side, what: "an output", shape: found.shape.to_vec() });
        }
        let sources = exemplars.table().sources();
        if !sources.iter().any(|(_, source)| holds(source.shape)) {
            let shape = sources.iter().map(|(_, s)| s.shape).max_by_key(|s| s[0].min(s[1])).unwrap_or_default();
            return Err(Error::Neighborhood { side, what: "an exemplar", shape: shape.to_vec() });
        }
        Ok(())
    }
}

/// What the paper's unit of an energy is here, beside that of exemplars whose channels' weights sum 3: a seam is priced
/// by the norm over all channels, so that it grows with the root of their weights. Agreement and tolerance grow with
/// it, and `K` means the same for grey exemplars, for colours, and for further planes that decide with them.
pub(crate) fn unit(exemplars: &Exemplars<2>) -> f64 {
    let sum: u32 = exemplars.weights().iter().map(|&w| u32::from(w)).sum();
    (f64::from(sum) / CHANNELS).sqrt()
}

/// Turns squared errors over a neighborhood into prices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    factor: u64,
    taps: u64,
}

impl Scale {
    /// `weight` for channels of weights whose sum counts as 3, over a whole neighborhood of so many taps, times the
    /// [`unit`] of prices.
    pub(crate) fn new(weight: f64, channels: &[u8], taps: u64) -> Self {
        let sum: u32 = channels.iter().map(|&w| u32::from(w)).sum();
        let each = if sum == 0 { 0.0 } else { CHANNELS / f64::from(sum) };
        let factor = weight * each * LEVEL / 255.0 * f64::from(1_u32 << FRACTION);
        Self { factor: factor.round() as u64, taps }
    }

    /// True where nothing costs anything.
    pub(crate) fn is_zero(self) -> bool {
        self.factor == 0
    }

    /// The same where a whole neighborhood has so many taps.
    pub(crate) fn over(self, taps: u64) -> Self {
        Self { taps, ..self }
    }

    /// The price, in units of `2^-20`, of an error over `samples` of the taps: of those that are missing the mean of
    /// the others is taken. 0 where all are.
    #[inline]
    pub(crate) fn of(self, error: u64, samples: u64) -> u64 {
        if samples == self.taps || error == 0 {
            return self.factor.saturating_mul(error);
        }
        if samples == 0 {
            return 0;
        }
        let missing = self.factor.checked_mul(error).and_then(|scaled| scaled.checked_mul(self.taps));
        if let Some(scaled) = missing {
            return scaled / samples;
        }
        let whole = u128::from(self.factor) * u128::from(error) * u128::from(self.taps) / u128::from(samples);
        u64::try_from(whole).unwrap_or(u64::MAX)
    }

    /// The same of a packed sum.
    #[inline]
    pub(crate) fn of_packed(self, sum: u64) -> u64 {
        self.of(sum & ((1 << COUNT_AT) - 1), sum >> COUNT_AT)
    }
}

/// One sample's error with the sample itself counted, such that a sum holds both sums.
#[inline]
pub(crate) fn packed(error: u32) -> u64 {
    1 << COUNT_AT | u64::from(error)
}

/// A sum of scaled errors as the price of a sample.
#[inline]
pub(crate) fn price(scaled: u64) -> i32 {
    (scaled >> FRACTION).min(MOST_AGREEMENT as u64) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agreement_is_scaled_like_seams_whatever_the_channels() {
        // K = 7, one of 225 taps differs in white against black: 7 squared differences of 1 in each of three channels.
        let of = |channels: &[u8], error: u64| price(Scale::new(7.0, channels, 225).of(error, 225));
        let expected = (7.0 * 3.0 * 255.0 * 16.0) as i32;
        assert!((of(&[1, 1, 1], 3 * 65_025) - expected).abs() <= 1);
        assert!((of(&[1], 65_025) - expected).abs() <= 1);
        assert!((of(&[5, 5, 5], 15 * 65_025) - expected).abs() <= 1);
        assert_eq!(of(&[0], 0), 0);
    }

    #[test]
    fn missing_taps_count_as_the_mean_of_the_others() {
        let scale = Scale::new(1.0, &[3], 9);
        assert_eq!(scale.of(700, 7), scale.of(900, 9));
        assert_eq!(scale.of(0, 0), 0);
        assert_eq!(scale.of_packed(packed(40) + packed(2)), scale.of(42, 2));
        let most = Scale::new(MOST_WEIGHT, &[1], 65 * 65);
        assert_eq!(price(most.of(65_025 * 65 * 65, 65 * 65)), MOST_AGREEMENT, "no overflow");
    }
}
