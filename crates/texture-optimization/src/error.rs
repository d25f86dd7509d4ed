//! What can be wrong.

use crate::level::Level;
use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A size that is not made of four by four cells, or is too large.
    #[error("neighborhoods of {size} px are not possible")]
    Size {
        /// The size asked for.
        size: u32,
    },
    /// A resolution that no pyramid has.
    #[error("a resolution of 1/{scale} is not possible")]
    Scale {
        /// The scale asked for.
        scale: u32,
    },
    /// Levels that do not lead to the full resolution.
    #[error("the schedule does not go from coarse to fine and end at full resolution")]
    Schedule,
    /// A constraint of another shape than the output.
    #[error("the {what} is {found:?}, and {expected:?} is needed")]
    Control {
        /// What it is.
        what: &'static str,
        /// Height, width and channels needed.
        expected: Vec<u32>,
        /// Those found.
        found: Vec<u32>,
    },
    /// Samples are fixed, but nothing stands there.
    #[error("samples are fixed, and nothing is there to stay")]
    NothingFixed,
    /// No iteration at all.
    #[error("0 iterations make nothing")]
    Iterations,
    /// No level at full resolution fits.
    #[error("no neighborhood of {least} px fits into {width}x{height} px at full resolution")]
    NothingFits {
        /// The smallest of the schedule at full resolution.
        least: u32,
        /// Width of what is too small, or too much masked.
        width: u32,
        /// Its height.
        height: u32,
        /// Whether that is the output.
        output: bool,
    },
    /// Masks leave no place for a neighborhood where one fitted before.
    #[error("no neighborhood of {} px at a resolution of 1/{} is free of masked samples", level.size, level.scale)]
    Masked {
        /// The level.
        level: Level,
    },
    /// The map to start from has other sources than the exemplars.
    #[error("the map to start from was made from other exemplars")]
    ForeignMap,
    /// The map to start from is of another size than the output.
    #[error("the map to start from is {found:?}, and the output {expected:?}")]
    MapShape {
        /// The output's shape, slowest axis first.
        expected: Vec<u32>,
        /// The map's.
        found: Vec<u32>,
    },
    /// The map to start from has holes.
    #[error("the map to start from has {holes} holes")]
    Holes {
        /// Samples with nothing.
        holes: usize,
    },
    /// A flow that does not lie over the output.
    #[error("the flow is {}x{} vectors, and the output {}x{} px", found[1], found[0], expected[1], expected[0])]
    FlowShape {
        /// Height and width of the output.
        expected: [u32; 2],
        /// Those of the flow.
        found: [u32; 2],
    },
    /// A vector that is no number.
    #[error("the flow at x={x} y={y} is no number")]
    FlowValue {
        /// Its column.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// A checkpoint of another animation, or none at all.
    #[error("the checkpoint is of another animation: its {what}")]
    Checkpoint {
        /// What differs.
        what: &'static str,
    },
    /// A tree that is to find anything but what is near.
    #[error("a tree finds what is near, neither what the output lacks nor what it uses evenly")]
    Tree,
    /// A search that takes whatever is nearest, or came.
    #[error("this search does not use the exemplars evenly")]
    Spread,
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
            Self::Size { .. }
            | Self::Scale { .. }
            | Self::Schedule
            | Self::NothingFixed
            | Self::Tree
            | Self::Spread
            | Self::Iterations => ErrorKind::Option,
            Self::NothingFits { .. }
            | Self::Masked { .. }
            | Self::Control { .. }
            | Self::ForeignMap
            | Self::MapShape { .. }
            | Self::FlowShape { .. }
            | Self::FlowValue { .. }
            | Self::Checkpoint { .. }
            | Self::Holes { .. } => ErrorKind::Input,
            Self::Core(error) => error.kind(),
            Self::Search(error) => error.kind(),
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Size { .. } => "use a multiple of 4 from 4 to 256".into(),
            Self::Scale { .. } => "use 1, 2, 4, 8, 16, 32 or 64".into(),
            Self::Schedule => "let no level be coarser than the one before, and the last have a scale of 1".into(),
            Self::Control { .. } => "give one of the output's size".into(),
            Self::NothingFixed => "start from a map".into(),
            Self::Iterations => "use at least 1".into(),
            Self::NothingFits { output: true, least, .. } => format!("make an output of at least {least}x{least}"),
            Self::NothingFits { .. } => "use a larger exemplar, mask less, or add a smaller size".into(),
            Self::Masked { .. } => "leave the level out or mask less".into(),
            Self::ForeignMap => "give the exemplars that it was made from".into(),
            Self::MapShape { .. } => "give a map of the output's size".into(),
            Self::FlowShape { .. } => "give a flow of the output's size".into(),
            Self::FlowValue { .. } => "mark it as unknown".into(),
            Self::Tree => "leave completeness and evenness out".into(),
            Self::Spread => "leave evenness out".into(),
            Self::Checkpoint { .. } => "begin again without it".into(),
            Self::Holes { .. } => "fill them first".into(),
            Self::Core(error) => error.remedy(),
            Self::Search(error) => error.remedy(),
        }
    }
}
