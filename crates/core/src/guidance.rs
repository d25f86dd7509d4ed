//! A guide with its weight.

use crate::{Error, Guide};

/// A guide that is followed, and how much.
#[derive(Clone, Debug)]
pub struct Guidance<const D: usize> {
    /// Maps under the exemplars and under the output.
    pub guide: Guide<D>,
    /// How much all of its channels count together where all of the exemplars' count 1; 0 for nothing.
    pub weight: f64,
}

impl<const D: usize> Guidance<D> {
    /// Refuses a weight that is less than nothing, or no number.
    ///
    /// # Errors
    /// [`Error::GuideWeight`].
    pub fn check_weight(&self) -> Result<(), Error> {
        let Self { weight, .. } = *self;
        if weight.is_finite() && 0.0 <= weight { Ok(()) } else { Err(Error::GuideWeight { weight }) }
    }
}
