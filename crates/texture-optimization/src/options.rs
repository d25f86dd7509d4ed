//! What the caller chooses.

use selvedge_core::Error as CoreError;

use crate::Error;
use crate::level::Level;
use crate::schedule::{check, paper_schedule};

/// How the nearest neighborhoods are found, the M-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// All positions, on samples rounded to 8 bits, each as heavy as the others, and channels by weights in as many
    /// steps as 32 bits hold at a size: exact, and fast.
    Exact,
    /// That in the first iteration of each level; then each neighborhood keeps what it has or continues one of those
    /// around it, whichever fits best, where anything changed. Four times as fast, and no worse: what continues fits at
    /// its edges as well.
    #[default]
    Coherent,
    /// The paper's: a tree of clusters, of which a neighborhood asks the nearest leaf. It finds something near, on few
    /// pictures what is nearest, and is slower than [`Search::Exact`]; with neither [`Options::complete`] nor
    /// [`Options::spread`]. For comparison.
    Tree,
    /// The definition: all positions, on unrounded samples, with the fall-off that averages use. Without
    /// [`Options::complete`] the robust energy never rises then. Slow: for tests and small pictures.
    Reference,
}

/// What the result is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Finish {
    /// Averages of samples, the paper's: [`Optimized::Votes`](crate::Optimized::Votes).
    Average,
    /// Samples of the exemplars, which continue each other as far as they fit: sharp, and an exact
    /// [`Optimized::Map`](crate::Optimized::Map).
    #[default]
    Coherent,
}

/// Options of [`optimize`](crate::optimize()).
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Resolutions and sizes of neighborhoods, in their order; those that do not fit are left out. Default: the six
    /// levels of the paper's figure 3.
    pub schedule: Vec<Level>,
    /// The exponent `r` of the robust energy, from above 0 to 2, where all neighborhoods weigh the same. Default: 0.8,
    /// as in the paper.
    pub robust: f64,
    /// `mu`: how much differences between samples beside each other count, where colours count 1; 0 for not at all, up
    /// to 100. Default: 0; the paper's is 10, for which each step solves a system of equations. Whether it is worth
    /// that from what is a texture already was not ranked. Searches have it in whole numbers of 32 bits together: with
    /// neighborhoods of 32 samples and three channels no more than 10, but for [`Search::Reference`].
    pub gradient: f64,
    /// Iterations at a level before it ends, if it does not end by itself. At least 1. Default: 5, as the paper
    /// found to be enough.
    pub iterations: u32,
    /// How neighborhoods are found. Default: [`Search::Coherent`].
    pub search: Search,
    /// How much parts of the exemplars that the output lacks are preferred: the error of a neighborhood is divided by
    /// how near the output comes to it, plus this part of the mean; the less, the more complete. `None` takes whatever
    /// is nearest, as in the paper. From 0 to 100. Default: 0.2.
    pub complete: Option<f64>,
    /// How evenly the exemplars' parts are used: this fraction is added to a neighborhood's error where its place was
    /// found twice as often as places are in the mean, twice as much where three times as often, up to the whole error.
    /// From 0 (whatever fits best, as in the paper) to 10. Each level looks among all places once more for it. Not with
    /// [`Search::Reference`]. Default: 0: [`complete`](Self::complete) keeps an output from a few places already.
    pub spread: f64,
    /// What the result is made of. Default: [`Finish::Coherent`].
    pub finish: Finish,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            schedule: paper_schedule(),
            robust: 0.8,
            gradient: 0.0,
            iterations: 5,
            search: Search::Coherent,
            complete: Some(0.2),
            spread: 0.0,
            finish: Finish::Coherent,
        }
    }
}

impl Options {
    /// The paper, but for its search: all places, on 8 bits, without fall-off, instead of a tree. Iterations end when
    /// nothing changes; they are bounded by a number that is not met in practice.
    pub fn paper() -> Self {
        Self {
            iterations: 100,
            gradient: 10.0,
            search: Search::Exact,
            complete: None,
            finish: Finish::Average,
            ..Self::default()
        }
    }

    /// What mends the seams of a map that has placed everything already, such as a graph cut's: 16 and 8 samples at
    /// full resolution, without completeness. Two readers prefer what comes of it to the graph cut on 10 and 11 of 14
    /// exemplars. Larger neighborhoods and coarse levels, where lines of text or joints of bricks are less than a
    /// sample wide, would move what is placed, and what is to be complete brings in what fits worse than the seams did:
    /// with both energies end above the graph cut's, and without at half of it.
    pub fn mending() -> Self {
        const SEAM: u32 = 16;
        let mut usual = Self::default();
        usual.schedule.retain(|level| level.scale == 1 && level.size <= SEAM);
        Self { complete: None, ..usual }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::Size`], [`Error::Scale`], [`Error::Schedule`], [`Error::Iterations`],
    /// [`Error::Tree`], [`Error::Spread`], and of the core [`Amount`](CoreError::Amount).
    pub fn validate(&self) -> Result<(), Error> {
        self.schedule.iter().try_for_each(|&level| check(level))?;
        let is_finer = |pair: &[Level]| pair[1].scale <= pair[0].scale;
        if !self.schedule.windows(2).all(is_finer) || self.schedule.last().is_none_or(|level| level.scale != 1) {
            return Err(Error::Schedule);
        }
        if !(0.0 < self.robust && self.robust <= 2.0) {
            let range = "more than 0 and at most 2 (all weigh the same)";
            return Err(CoreError::amount("an exponent", self.robust, range).into());
        }
        if !(0.0..=100.0).contains(&self.gradient) {
            let range = "0 (colours alone) to 100";
            return Err(CoreError::amount("a weight of gradients", self.gradient, range).into());
        }
        if let Some(alpha) = self.complete.filter(|alpha| !(0.0..=100.0).contains(alpha)) {
            let range = "0 (as complete as can be) to 100 (hardly)";
            return Err(CoreError::amount("a completeness", alpha, range).into());
        }
        CoreError::within("spread", self.spread, 0.0..=10.0, "0 (whatever fits best) to 10")?;
        if self.search == Search::Tree && (self.complete.is_some() || self.spread != 0.0) {
            return Err(Error::Tree);
        }
        if self.search == Search::Reference && self.spread != 0.0 {
            return Err(Error::Spread);
        }
        if self.iterations == 0 { Err(Error::Iterations) } else { Ok(()) }
    }
}
