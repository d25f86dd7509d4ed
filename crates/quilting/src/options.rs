//! What the caller chooses, and what can be wrong with it.

use selvedge_core::{Error as CoreError, ErrorKind};

/// How far the algorithm of figure 2 goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Random blocks, tiled without overlap (figure 2a).
    Random,
    /// Overlapping blocks that agree with their neighbours, laid over them whole (figure 2b).
    Overlap,
    /// The same with a minimum error boundary cut (figure 2c): the method.
    #[default]
    Cut,
}

/// Whether a block may be the exemplar's own continuation of its neighbour.
///
/// On real exemplars a quarter to two fifths of all blocks fit best where their neighbour came from, one step
/// further: the output then repeats the exemplar verbatim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuation {
    /// No block within two samples of a neighbour's continuation, as long as there is any other.
    Avoid,
    /// Whatever fits best, as the paper has it.
    #[default]
    Allow,
}

/// Where blocks are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchBy {
    /// In large exemplars at a fraction of the size, and then around the best of what is found there; in small ones
    /// everywhere.
    #[default]
    Auto,
    /// At every place of every exemplar.
    Exact,
}

/// Options of [`quilt`](crate::quilt).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Side of the square blocks in samples. It should hold the largest structure of the texture; larger blocks copy
    /// more, smaller ones mix more. From 1 to the exemplar's shorter side. Default: chosen by
    /// [`suggest_block`](crate::suggest_block) from the exemplar.
    pub block: Option<u32>,
    /// Width of the overlap of neighbouring blocks in samples, at most half a block; none for [`Stage::Random`].
    /// Default: the block divided by `overlap_part`, at least 1.
    pub overlap: Option<u32>,
    /// Which part of the block the overlap is where no width is given. Default: 4, a fourth, so that lines find each
    /// other; the paper's is 6. 0 counts as 1.
    pub overlap_part: u32,
    /// A block is drawn from those whose overlap error (L2 norm) is at most `1 + tolerance` times the least. From 0
    /// (always the best) to 100. With a `spread`, errors count as that makes them, both the least and the others: what
    /// is drawn may then have up to `sqrt(2)` times that error. Default: 0.1, as in the paper.
    pub tolerance: f64,
    /// How far the algorithm of the paper's figure 2 goes. Default: [`Stage::Cut`].
    pub stage: Stage,
    /// Whether blocks may continue their neighbours verbatim. Default: [`Continuation::Allow`]: where the neighbour's
    /// continuation fits best, what else is laid there breaks lines.
    pub continuation: Continuation,
    /// How evenly each exemplar's parts are used: this fraction is added to a block's error where it was used twice as
    /// often as parts are in the mean, twice as much where three times as often, up to the whole error. From 0
    /// (whatever fits best, as in the paper) to 10. Default: 0.25, which shows more of an exemplar at seams as good.
    pub spread: f64,
    /// Where blocks are looked for. Errors are exact either way. Default: [`SearchBy::Auto`].
    pub search: SearchBy,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            block: None,
            overlap: None,
            overlap_part: 4,
            tolerance: 0.1,
            stage: Stage::Cut,
            continuation: Continuation::Allow,
            spread: 0.25,
            search: SearchBy::Auto,
        }
    }
}

impl Options {
    /// The paper, to the letter; the block is left to the user there, and to [`suggest_block`](crate::suggest_block)
    /// here.
    pub fn paper() -> Self {
        let (continuation, search) = (Continuation::Allow, SearchBy::Exact);
        Self { overlap_part: 6, continuation, spread: 0.0, search, ..Self::default() }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::Block`], [`Error::Overlap`], [`Error::RandomOverlap`], and of the core [`Amount`](CoreError::Amount).
    pub fn validate(&self) -> Result<(), Error> {
        if self.block == Some(0) {
            return Err(Error::Block);
        }
        if let (Some(block), Some(overlap)) = (self.block, self.overlap)
            && block / 2 < overlap
        {
            return Err(Error::Overlap { overlap, block, limit: block / 2 });
        }
        if let (Stage::Random, Some(overlap @ 1..)) = (self.stage, self.overlap) {
            return Err(Error::RandomOverlap { overlap });
        }
        check_spread(self.spread)?;
        check_tolerance(self.tolerance)
    }

    /// The overlap for a block: the given one, or its part. `[Efros01 2.2]`
    pub(crate) fn overlap_of(&self, block: u32) -> Result<u32, Error> {
        match self.overlap {
            Some(overlap) if block / 2 < overlap => Err(Error::Overlap { overlap, block, limit: block / 2 }),
            Some(overlap) => Ok(overlap),
            None => Ok((block / self.overlap_part.max(1)).max(1).min(block / 2)),
        }
    }
}

/// A tolerance on squared errors, in thousandths: `error * 1000 <= least * (1000 + per_mille)`.
///
/// The paper's 0.1 is on the L2 norm, so squared errors may be 1.21 times the least. `[Efros01 2.2]`
pub(crate) fn per_mille(tolerance: f64) -> u32 {
    let factor = 1.0 + tolerance;
    ((factor * factor - 1.0) * 1000.0).round() as u32
}

/// Checks a tolerance.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), Error> {
    let fits = (0.0..=100.0).contains(&tolerance);
    if fits { Ok(()) } else { Err(CoreError::amount("a tolerance", tolerance, "0 to 100").into()) }
}

/// Checks a spread.
pub(crate) fn check_spread(spread: f64) -> Result<(), Error> {
    let (fits, range) = ((0.0..=10.0).contains(&spread), "0 (whatever fits best) to 10");
    if fits { Ok(()) } else { Err(CoreError::amount("a spread", spread, range).into()) }
}

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A block of no samples.
    #[error("a block of 0 px holds nothing")]
    Block,
    /// A transfer's block has no room for an overlap.
    #[error("a transfer in blocks of {block} px has no overlap to match")]
    TransferBlock {
        /// The block asked for.
        block: u32,
        /// The smallest allowed.
        least: u32,
    },
    /// The overlap exceeds half a block.
    #[error("an overlap of {overlap} px is more than half of the {block} px block")]
    Overlap {
        /// The overlap asked for.
        overlap: u32,
        /// The block.
        block: u32,
        /// The largest overlap allowed.
        limit: u32,
    },
    /// Blocks that agree with nothing have nothing to overlap for.
    #[error("random blocks do not overlap, and an overlap of {overlap} px was given")]
    RandomOverlap {
        /// The overlap asked for.
        overlap: u32,
    },
    /// No pass, or too many.
    #[error("{passes} passes are out of range")]
    Passes {
        /// The passes asked for.
        passes: u32,
        /// The most allowed.
        limit: u32,
    },
    /// No exemplar holds a block.
    #[error("{width}x{height} px is smaller than the {block} px block")]
    BlockExceedsExemplar {
        /// The block.
        block: u32,
        /// The largest exemplar's width.
        width: u32,
        /// The largest exemplar's height.
        height: u32,
        /// The largest block that fits.
        limit: u32,
    },
    /// Masks leave no place for a block.
    #[error("no {height}x{width} px block of the exemplar is free of masked samples")]
    Masked {
        /// Height of the block.
        height: u32,
        /// Width of the block.
        width: u32,
    },
    /// An error of the core.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
    /// An error of the search.
    #[error(transparent)]
    Search(#[from] selvedge_fft_ssd::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Block
            | Self::TransferBlock { .. }
            | Self::Overlap { .. }
            | Self::RandomOverlap { .. }
            | Self::Passes { .. } => ErrorKind::Option,
            Self::BlockExceedsExemplar { .. } | Self::Masked { .. } => ErrorKind::Input,
            Self::Core(error) => error.kind(),
            Self::Search(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Block => "use a block of at least 1".into(),
            Self::TransferBlock { least, .. } => format!("use a block of at least {least}"),
            Self::Overlap { limit, .. } => format!("use at most {limit}"),
            Self::RandomOverlap { .. } => "leave it out or choose another stage".into(),
            Self::Passes { limit, .. } => format!("use 1 to {limit}"),
            Self::BlockExceedsExemplar { limit, .. } => format!("use a block of at most {limit} or a larger exemplar"),
            Self::Masked { .. } => "use a smaller block or mask less".into(),
            Self::Core(error) => error.remedy(),
            Self::Search(error) => error.remedy(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_overlap_is_a_sixth_and_the_default_a_fourth() {
        let options = Options::paper();
        assert_eq!(per_mille(options.tolerance), 210);
        assert_eq!([1, 2, 5, 36].map(|b| Options::default().overlap_of(b).unwrap()), [0, 1, 1, 9]);
        assert_eq!([1, 2, 5, 6, 36, 48].map(|b| options.overlap_of(b).unwrap()), [0, 1, 1, 1, 6, 8]);
    }

    #[test]
    fn wrong_options_are_named_with_their_numbers() {
        let with = |options: Options| options.validate().unwrap_err();
        let block = Options { block: Some(0), ..Options::default() };
        assert!(with(block).to_string().contains("0 px"));
        let overlap = with(Options { block: Some(10), overlap: Some(6), ..Options::default() });
        assert_eq!(overlap.to_string(), "an overlap of 6 px is more than half of the 10 px block");
        assert_eq!((overlap.remedy().as_str(), overlap.kind()), ("use at most 5", ErrorKind::Option));
        for wrong in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(Options { tolerance: wrong, ..Options::default() }.validate().is_err());
            assert!(Options { spread: wrong, ..Options::default() }.validate().is_err());
        }
    }
}
