//! Counts of one run.

/// What happened at one level of the split tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Blocks that were searched.
    pub blocks: u64,
    /// Those of them that were split.
    pub splits: u64,
    /// Mean error of those that were laid, a weighted squared difference in `[0, 1]`.
    pub error: f64,
}

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// Height and width of the start blocks that were used.
    pub block: [u32; 2],
    /// The largest mean error of an overlap that was not split, in `[0, 1]`.
    pub max_error: f64,
    /// The largest error of a sample that was not re-synthesised, in `[0, 1]`.
    pub pixel_error: f64,
    /// By level, the start blocks first.
    pub levels: Vec<Level>,
    /// Single samples that were laid although they fit badly.
    pub unsplittable: u64,
    /// Blocks whose overlap was cut.
    pub cuts: u64,
    /// Blocks whose overlap was re-synthesised.
    pub resyntheses: u64,
    /// Samples that were re-synthesised.
    pub pixels: u64,
    /// By output sample, row-major, the level of the block that shows there, 0 for start blocks; or [`Self::CHOSEN`],
    /// or [`Self::STOOD`].
    pub laid: Vec<u8>,
}

impl Stats {
    /// A sample that was re-synthesised by itself.
    pub const CHOSEN: u8 = 254;
    /// A sample that stood before, or where nothing stands.
    pub const STOOD: u8 = 255;
}
