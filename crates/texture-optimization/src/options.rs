//! What the caller chooses.

use crate::Error;
use crate::level::Level;
use crate::schedule::{check, paper_schedule};

/// How the nearest neighborhoods are found, the M-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// All positions, on samples rounded to 8 bits, each as heavy as the others: exact, and fast.
    #[default]
    Exact,
    /// The definition: all positions, on unrounded samples, with the fall-off that averages use. The robust energy never rises
    /// then. Slow: for tests and small pictures.
    Reference,
}

/// Options of [`optimize`](crate::optimize()).
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Resolutions and sizes of neighborhoods, in their order; those that do not fit are left out. Default: the six levels of
    /// the paper's figure 3.
    pub schedule: Vec<Level>,
    /// The exponent `r` of the robust energy, from above 0 to 2, where all neighborhoods weigh the same. Default: 0.8, as in the
    /// paper.
    pub robust: f64,
    /// Iterations at a level before it ends, if it does not end by itself. At least 1. Default: 10.
    pub iterations: u32,
    /// How neighborhoods are found. Default: [`Search::Exact`].
    pub search: Search,
}

impl Default for Options {
    fn default() -> Self {
        Self { schedule: paper_schedule(), robust: 0.8, iterations: 10, search: Search::Exact }
    }
}

impl Options {
    /// The paper, to the letter: iterations end when nothing changes. They are bounded by a number that is not met in practice.
    pub fn paper() -> Self {
        Self { iterations: 100, ..Self::default() }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::Size`], [`Error::Scale`], [`Error::Schedule`], [`Error::Robust`], [`Error::Iterations`].
    pub fn validate(&self) -> Result<(), Error> {
        self.schedule.iter().try_for_each(|&level| check(level))?;
        let is_finer = |pair: &[Level]| pair[1].scale <= pair[0].scale;
        if !self.schedule.windows(2).all(is_finer) || self.schedule.last().is_none_or(|level| level.scale != 1) {
            return Err(Error::Schedule);
        }
        if !(0.0 < self.robust && self.robust <= 2.0) {
            return Err(Error::Robust { robust: self.robust });
        }
        if self.iterations == 0 { Err(Error::Iterations) } else { Ok(()) }
    }
}
