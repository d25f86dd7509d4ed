//! What a run may choose.

use selvedge_core::Error as CoreError;

use crate::error::Error;

/// Most that a constraint may weigh (`K` times its own weight): five hundred times what the paper used, and far from
/// where squared differences of the largest neighborhood would pass 64 bits.
pub(crate) const MOST_WEIGHT: f64 = 10_000.0;

/// The largest half-width of a neighborhood: three times the paper's largest.
pub(crate) const MOST_NEIGHBORHOOD: u32 = 32;

/// Most labels that are drawn at random: a thousand times the paper's expansions, and hours of work.
const MOST_LABELS: u32 = 1_000_000;

/// Options of [`analogy`](crate::analogy). Default: [`Options::paper`] with `K` and `N` that suit most tasks.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// `K`: how much agreement with the constraints counts against seams; the paper used 0.2 to 20. 0 ignores them.
    pub constraint_weight: f64,
    /// `N`: half the width of a neighborhood, so that it has `(2 N + 1)^2` taps; the paper used 1 to 9. Large ones keep
    /// structures, small ones follow curves.
    pub neighborhood: u32,
    /// `c`: labels that are tried for a place.
    pub candidates: u32,
    /// `d`: least distance of those labels within one source, in samples.
    pub apart: u32,
    /// `h`: bad places in a row that are tried in vain before the run ends.
    pub history: u32,
    /// `t`: what an improvement has to gain, in the paper's units (differences from 0 to 1). `None`: `5 (K + 2)`.
    pub tolerance: Option<f64>,
    /// Levels, from coarse to fine, each twice as large as the one before; 1 is the paper's. `None`: up to three, where
    /// constraints and exemplars have them. Large structures are placed where they are small; then the rest is settled.
    pub levels: Option<u32>,
    /// How much an output spreads over all of the exemplars: what a sample costs that shows as often as all do in the
    /// mean, in the paper's units (differences from 0 to 1); twice as much where its part shows twice as often. 0 is
    /// the paper's: of parts that agree alike the flattest may show everywhere.
    pub spread: f64,
    /// Draws so many labels at random instead of searching for them: Schödl's baseline.
    pub random_labels: Option<u32>,
}

impl Options {
    /// The paper's: `c = 5`, `d = 20`, `h = 8`, `t = 5 (K + 2)`. `K` and `N` are the user's there; here 1 and 4
    /// stand in the middle of those of its figures. `[CMS IV-C]`
    pub const fn paper() -> Self {
        Self {
            constraint_weight: 1.0,
            neighborhood: 4,
            candidates: 5,
            apart: 20,
            history: 8,
            tolerance: None,
            levels: Some(1),
            spread: 0.0,
            random_labels: None,
        }
    }

    /// Refuses what is wrong by itself.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range).
    pub fn validate(&self) -> Result<(), Error> {
        CoreError::within("constraint_weight", self.constraint_weight, 0.0..=MOST_WEIGHT, "0 to 10000")?;
        CoreError::within("spread", self.spread, 0.0..=MOST_WEIGHT, "0 to 10000")?;
        CoreError::within("neighborhood", self.neighborhood, 0.0..=f64::from(MOST_NEIGHBORHOOD), "0 to 32")?;
        CoreError::within("candidates", self.candidates, 1.0..=1e3, "1 to 1000")?;
        CoreError::within("apart", self.apart, 0.0..=65_535.0, "0 to 65535")?;
        CoreError::within("history", self.history, 1.0..=1e3, "1 to 1000")?;
        let labels = self.random_labels.unwrap_or(1);
        CoreError::within("random_labels", labels, 1.0..=f64::from(MOST_LABELS), "1 to 1000000")?;
        CoreError::within("levels", self.levels.unwrap_or(1), 1.0..=8.0, "1 to 8")?;
        Ok(CoreError::within("tolerance", self.tolerance.unwrap_or(0.0), 0.0..=1e9, "0 to 1000000000")?)
    }

    /// `t` in the units of prices, of which the paper's is one. `[CMS IV-C step 4]`
    pub(crate) fn least_gain(&self, unit: f64) -> i64 {
        let units = self.tolerance.unwrap_or(5.0 * (self.constraint_weight + 2.0));
        (units * unit * 255.0 * 16.0).round() as i64
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::paper()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_out_of_range_is_refused_with_its_number() {
        for weight in [-1.0, f64::NAN, f64::INFINITY, 1e5] {
            let found = Options { constraint_weight: weight, ..Options::paper() }.validate();
            assert!(
                matches!(found, Err(Error::Core(CoreError::Range { option: "constraint_weight", .. }))),
                "{weight}"
            );
        }
        let none = Options { candidates: 0, ..Options::paper() };
        assert_eq!(none.validate(), Err(CoreError::range("candidates", 0.0, "1 to 1000").into()));
        let drawn = Options { random_labels: Some(0), ..Options::paper() };
        assert_eq!(drawn.validate(), Err(CoreError::range("random_labels", 0.0, "1 to 1000000").into()));
        assert_eq!(Options::paper().validate(), Ok(()));
        assert_eq!(Options::paper().least_gain(1.0), 15 * 255 * 16);
    }
}
