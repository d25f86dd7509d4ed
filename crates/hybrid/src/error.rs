//! What can be wrong.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A start block's side is no power of two.
    #[error("a block of {width}x{height} px cannot be halved down to single pixels")]
    Block {
        /// Its height.
        height: u32,
        /// Its width.
        width: u32,
    },
    /// No exemplar holds a start block, with an overlap where the output goes on.
    #[error("{width}x{height} px is smaller than the block of {block_width}x{block_height} px with its overlap")]
    BlockExceedsExemplar {
        /// The block's height.
        block_height: u32,
        /// The block's width.
        block_width: u32,
        /// The largest exemplar's height.
        height: u32,
        /// The largest exemplar's width.
        width: u32,
        /// The largest power of two that fits.
        limit: u32,
    },
    /// A field of sources allows none everywhere that something is missing.
    #[error("no source may be used at all places that are missing")]
    MixedSources,
    /// Less of a guide's maps is valid than of the exemplars.
    #[error("a guide is not known everywhere in the exemplars")]
    GuideMask,
    /// Blocks are searched and cut by quilting.
    #[error(transparent)]
    Quilting(#[from] selvedge_quilting::Error),
    /// An error of the core.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Block { .. } => ErrorKind::Option,
            Self::BlockExceedsExemplar { .. } | Self::MixedSources | Self::GuideMask => ErrorKind::Input,
            Self::Quilting(error) => error.kind(),
            Self::Core(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Block { .. } => "use powers of two up to 4096, such as 32 or 64x32".into(),
            Self::BlockExceedsExemplar { limit, .. } => format!("use a block of at most {limit} or a larger exemplar"),
            Self::MixedSources => "allow the same ones everywhere".into(),
            Self::GuideMask => "mask the exemplars where it is not known".into(),
            Self::Quilting(error) => error.remedy(),
            Self::Core(error) => error.remedy(),
        }
    }
}
