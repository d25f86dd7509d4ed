//! How jumps are cut.

use selvedge_core::SeamMeasure;

/// Options of [`looped`](super::looped).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopOptions {
    /// Frames around the jump in which pixels may jump. It shrinks to what there is on both sides, and to a period.
    /// Default: 60. `[Kwatra03 7A]`
    pub window: u32,
    /// How seams are priced. Default: eq. 5 of the paper, by gradients.
    pub seam: SeamMeasure,
    /// Jumps that are cut whatever comes of them; those after them are cut where none of these closes. Default: 8.
    pub jumps: usize,
    /// At how many sizes surfaces are looked for, each of frames half as wide and high as the one before: all but the
    /// smallest only near the surface of the next smaller one. From 1, the cheapest surface, to 5. Default: 1.
    pub levels: u32,
    /// All jumps are cut in frames of half the size first, if these have 32 px a side, and at full size only the best
    /// of them: two, and while none closes up to four, or all that close at half the size. Default: false.
    pub sifted: bool,
}

impl Default for LoopOptions {
    fn default() -> Self {
        Self { window: 60, seam: SeamMeasure::Gradient, jumps: 8, levels: 1, sifted: false }
    }
}
