//! What the caller chooses.

use selvedge_core::Error as CoreError;
use selvedge_quilting::Continuation;

use crate::error::Error;

/// How large an error may be, per sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Threshold {
    /// A fraction of the error of two random samples of the exemplar that suits most exemplars.
    #[default]
    Auto,
    /// This fraction of the error of two random samples. From 0.
    OfRandom(f64),
    /// The paper's: a weighted squared difference of samples in `[0, 1]`. `[Ding eq. 1]`
    Absolute(f64),
}

impl Threshold {
    /// Refuses what no error is.
    pub(crate) fn check(self, option: &'static str) -> Result<(), CoreError> {
        match self {
            Self::Auto => Ok(()),
            Self::Absolute(error) => CoreError::within(option, error, 0.0..=1.0, "0 to 1"),
            Self::OfRandom(part) => {
                CoreError::within(option, part, 0.0..=1000.0, "0 to 1000 times the error of random samples")
            }
        }
    }
}

/// How start blocks lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Layout {
    /// In rows and columns.
    #[default]
    Grid,
    /// Every other row is moved by half a block.
    Brick,
}

/// Which samples a pixel that is re-synthesised is chosen from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PixelSearch {
    /// Those that continue what is around it.
    #[default]
    Coherent,
    /// All of the exemplar.
    Exact,
}

/// What of a block is re-synthesised where its overlap fits badly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Resynthesize {
    /// What lies near the boundary cut where that shows.
    #[default]
    Seam,
    /// All of the overlap whose samples differ by more than the pixel error: the paper's.
    Overlap,
}

/// Which blocks that fit badly are split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Split {
    /// Those whose parts' seams are cheaper in sum than the block's own
    /// ([`SeamMeasure::Gradient`](selvedge_core::SeamMeasure)): parts always fit better, for less of them is compared.
    #[default]
    Cheaper,
    /// All of them: the paper's.
    Always,
}

/// Options of [`hybrid`](crate::hybrid()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Height and width of the start blocks in samples, powers of two. Default: the largest power of two that is at
    /// most four thirds of the [block that quilting suggests](selvedge_quilting::suggest_block), so that blocks split
    /// where they do not fit instead of being small everywhere.
    pub block: Option<[u32; 2]>,
    /// Overlap of a start block, outside of it, as a part of its side: from 0.05 to 1; at least three samples. A block
    /// that is split has half of it. `[Ding 3]`
    pub overlap: f64,
    /// A block is split while its overlap's mean error is larger. `[Ding 3.2]`
    pub max_error: Threshold,
    /// Which of these are split.
    pub split: Split,
    /// A sample whose error is larger is re-synthesised. `[Ding 3.3]`
    pub pixel_error: Threshold,
    /// Below this part of `max_error` an overlap is cut, from it on re-synthesised: 1, the default, never
    /// re-synthesises ([`repair`](crate::repair()) at the end sees all seams, and undoes what made none better), 0
    /// always. `[Ding 3.3]`
    pub k: f64,
    /// How start blocks lie.
    pub layout: Layout,
    /// Which samples pixels are chosen from.
    pub search: PixelSearch,
    /// What is re-synthesised.
    pub resynthesize: Resynthesize,
    /// Blocks are drawn among those whose error (as an L2 norm) is up to this fraction above the least. From 0 (the
    /// best, as in the paper) to 100.
    pub tolerance: f64,
    /// How many of these are tried at most: the one whose seams are cheapest
    /// ([`SeamMeasure::Gradient`](selvedge_core::SeamMeasure)) is laid. At least 1, the paper's.
    pub tries: u32,
    /// How evenly the exemplar is used; see [`selvedge_quilting::Options::spread`]. From 0 to 10.
    pub spread: f64,
    /// Whether start blocks may continue what is around them verbatim; what they split into always may.
    pub continuation: Continuation,
    /// Blocks may reach around the borders of the exemplars: the paper's, for exemplars that tile.
    pub circular: bool,
}

impl Default for Options {
    fn default() -> Self {
        let quilting = selvedge_quilting::Options::default();
        Self {
            block: None,
            overlap: 0.33,
            max_error: Threshold::Auto,
            split: Split::Cheaper,
            pixel_error: Threshold::Auto,
            k: 1.0,
            layout: Layout::Grid,
            search: PixelSearch::Coherent,
            resynthesize: Resynthesize::Seam,
            tolerance: quilting.tolerance,
            tries: 32,
            spread: quilting.spread,
            continuation: quilting.continuation,
            circular: false,
        }
    }
}

/// No block has a longer side: what splits at every level of it still has a number.
const LARGEST: u32 = 1 << 12;

impl Options {
    /// The paper to the letter, with the thresholds of its first case: blocks of 32, the best one, circular shifts,
    /// overlaps re-synthesised from all of the exemplar. `[Ding Table 1, 2, 3]`
    ///
    /// But for one thing of which it says nothing: around its borders an exemplar always continues perfectly, so that
    /// the best block of all would show the exemplar again and again, and no block would ever be cut. So blocks
    /// continue nothing.
    pub fn paper() -> Self {
        Self {
            block: Some([32, 32]),
            overlap: 0.2,
            max_error: Threshold::Absolute(0.04),
            split: Split::Always,
            pixel_error: Threshold::Absolute(0.02),
            k: 0.5,
            layout: Layout::Grid,
            search: PixelSearch::Exact,
            resynthesize: Resynthesize::Overlap,
            tolerance: 0.0,
            tries: 1,
            spread: 0.0,
            continuation: Continuation::Avoid,
            circular: true,
        }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::Block`] and [`Range`](selvedge_core::Error::Range).
    pub fn validate(&self) -> Result<(), Error> {
        if let Some([height, width]) = self.block
            && [height, width].iter().any(|side| !side.is_power_of_two() || LARGEST < *side)
        {
            return Err(Error::Block { height, width });
        }
        self.max_error.check("max_error")?;
        self.pixel_error.check("pixel_error")?;
        CoreError::within("overlap", self.overlap, 0.05..=1.0, "0.05 to 1 times the block's side")?;
        CoreError::within("tries", self.tries, 1.0..=1000.0, "1 to 1000")?;
        CoreError::within("k", self.k, 0.0..=1.0, "0 (always re-synthesise) to 1 (never)")?;
        CoreError::within("tolerance", self.tolerance, 0.0..=100.0, "0 to 100")?;
        Ok(CoreError::within("spread", self.spread, 0.0..=10.0, "0 (whatever fits best) to 10")?)
    }

    /// The tolerance on squared errors, in thousandths, as quilting has it.
    pub(crate) fn per_mille(&self) -> u32 {
        let factor = 1.0 + self.tolerance;
        ((factor * factor - 1.0) * 1000.0).round() as u32
    }
}
