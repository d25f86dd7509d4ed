//! What the caller chooses.

use selvedge_core::{Error as CoreError, SeamMeasure};

use crate::error::Error;

/// Each of them has a graph of its own: a bound for memory, far above what pays (the best of two costs two cuts, that
/// of four four).
const MOST_TRIES: u32 = 64;
/// More refinements than this are a slip of the keyboard: each is noted.
const MOST_REFINEMENTS: u32 = 1_000_000;

/// At the last of so many levels nothing is left of an exemplar of 2K.
pub(crate) const MOST_LEVELS: u32 = 8;

/// How the next patch is found. `[Kwatra03 4]`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Placement {
    /// [`Entire`](Self::Entire) where the exemplar has a lattice, even a weak one, or lines of text
    /// ([`is_orderly`](selvedge_analysis::Texture::is_orderly)), and for pictures of at most six times the exemplar's
    /// samples, which show few copies, unless a region or a reach is given; else, and of clips, [`Sub`](Self::Sub).
    #[default]
    Auto,
    /// Anywhere over the error region: fast, for random textures.
    Random,
    /// Where the exemplar agrees with all that is there under it, as far as patches reach: for structured textures.
    Entire,
    /// Where the exemplar agrees with the output in the error region: for everything without a period.
    Sub,
}

/// Which patches may be laid where a neighbour shows the same, moved by less than [`Options::apart`]. The method has no
/// such rule: where a texture is alike along a line, the patch that agrees best is the one before, moved by as little
/// as covers something new, and the same piece stands in a row of stripes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stutter {
    /// [`Once`](Self::Once) for pictures of at most six times the exemplar's samples, which show few copies, unless
    /// [`apart`](Options::apart) is given; else [`Never`](Self::Never).
    #[default]
    Auto,
    /// None.
    Never,
    /// Those that are moved as none was before, in steps of four samples: one stutter goes unseen, and often mends what
    /// nothing else does; stripes are the same one made again.
    Once,
}

/// Options of [`graphcut`](crate::graphcut()). Lengths are given along each axis, slowest first: `Some([32; D])` for
/// the same along all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<const D: usize> {
    /// How the next patch is found. Default: [`Placement::Auto`].
    pub placement: Placement,
    /// Axes along which patches may be moved; along the others they lie where they are in their exemplar, all of them
    /// together cover all of the output, and error regions reach over all of it. Default: all. `[true, false, false]`
    /// moves clips in time alone, for what shows the same kind of change at each place, but not the same place
    /// everywhere.
    /// `[Kwatra03 7B]`
    pub free: [bool; D],
    /// How seams are priced: eq. 1 or eq. 5 of the paper. Default: eq. 5, by gradients.
    pub seam: SeamMeasure,
    /// Sides of the error region in samples: what a new patch must cover, and what sub-patch matching compares. From 1
    /// to the sides of an exemplar. Default: a fourth of the exemplar's shortest side along all axes, but no more than
    /// four times its largest structures.
    pub region: Option<[u32; D]>,
    /// How far a patch may reach beyond the error region on both sides of each axis, in samples; 0 lays the region
    /// alone. Large patches keep more of the exemplar's structure, small ones repeat less of it; from the exemplar's
    /// sides on, patches are whole exemplars, as in the paper. Default: half of a region that is given, else the
    /// region's sides, and as far as the exemplar goes for [`Placement::Entire`].
    pub reach: Option<[u32; D]>,
    /// The `k` of eq. 3: how freely patches are drawn among those that fit worse than the best. The paper
    /// uses 0.001 to 1; 0 always takes the best.
    pub randomness: f64,
    /// How much a patch is avoided that stands to its neighbours as others stand to theirs already, in units of
    /// `randomness`: what keeps copies from forming a lattice. From 0. Default: a fourth, and a half for
    /// [`Placement::Entire`].
    pub variety: Option<f64>,
    /// What is moved by less than so many samples along every axis from where a neighbour shows the same is a stutter,
    /// and not laid as long as there is any other, or as [`stutter`](Self::stutter) has it. Default: one and a half
    /// regions of pictures, where no region is given and there is no lattice; else 0.
    pub apart: Option<u32>,
    /// Which stutters may be laid. Default: [`Stutter::Auto`].
    pub stutter: Stutter,
    /// Patches laid over the worst seams after everything is covered. Default: until seams stop falling, but at most
    /// [`REFINEMENTS_A_PATCH`](Self::REFINEMENTS_A_PATCH) times as many as patches were needed to cover everything.
    pub refine: Option<u32>,
    /// Refinements in a row that bring nothing before seams count as settled, beside one for each 32 regions that the
    /// output holds. Up to eight are made at once, so that it may be seven more. At least 1.
    pub patience: u32,
    /// Candidates that are cut at each refinement, of which the best is taken. From 1 to 64.
    pub tries: u32,
    /// At how many sizes the map is solved, each half of the one before: 1 as the paper does, at most 8, and no more
    /// than leave an exemplar of 16 samples a side, and half of what a mask leaves of each at each of them. More apply
    /// to outputs that begin empty. Default: for pictures, as many as leave exemplars of 192 samples a side and
    /// structures of 4, so that smaller ones have 1; for clips, whose frames are halved and stay as many, as many as
    /// leave frames of 24 samples a side and regions of 7. Along axes that are not free an output is halved while its
    /// sides are even.
    pub levels: Option<u32>,
}

impl<const D: usize> Default for Options<D> {
    fn default() -> Self {
        Self {
            placement: Placement::Auto,
            free: [true; D],
            seam: SeamMeasure::Gradient,
            region: None,
            reach: None,
            randomness: 0.01,
            variety: None,
            apart: None,
            stutter: Stutter::Auto,
            refine: None,
            patience: 8,
            tries: 2,
            levels: None,
        }
    }
}

impl<const D: usize> Options<D> {
    /// Bounds refinement where no number is asked for: by then seams fall slowly.
    pub const REFINEMENTS_A_PATCH: u64 = 2;

    /// The paper to the letter, with `k` from the lower end of its range: every patch is the whole exemplar, the first
    /// that is drawn is taken.
    pub fn paper() -> Self {
        let (reach, variety) = (Some([u32::MAX; D]), Some(0.0));
        Self { reach, variety, apart: Some(0), tries: 1, levels: Some(1), ..Self::default() }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range).
    pub fn validate(&self) -> Result<(), Error> {
        if !self.free.contains(&true) {
            return Err(CoreError::range("free", 0.0, "at least one axis").into());
        }
        if self.region.is_some_and(|region| region.contains(&0)) {
            return Err(CoreError::range("region", 0.0, "at least 1").into());
        }
        CoreError::within("patience", self.patience, 1.0..=f64::from(MOST_REFINEMENTS), "1 to 1000000")?;
        CoreError::within("tries", self.tries, 1.0..=f64::from(MOST_TRIES), "1 to 64")?;
        CoreError::within("refine", self.refine.unwrap_or(0), 0.0..=f64::from(MOST_REFINEMENTS), "0 to 1000000")?;
        CoreError::within("levels", self.levels.unwrap_or(1), 1.0..=f64::from(MOST_LEVELS), "1 to 8")?;
        CoreError::within("randomness", self.randomness, 0.0..=1000.0, "0 to 1000")?;
        Ok(CoreError::within("variety", self.variety.unwrap_or(0.0), 0.0..=1000.0, "0 to 1000")?)
    }
}
