//! What is optimised at once.

/// One level: neighborhoods of one size at one resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Samples of the output along an axis for one here: 1, 2, 4, ...
    pub scale: u32,
    /// Side of the neighborhoods in samples of this resolution: a multiple of 4.
    pub size: u32,
}

impl Level {
    /// How often the full resolution is halved.
    pub(crate) fn halvings(self) -> usize {
        self.scale.trailing_zeros() as usize
    }
}
