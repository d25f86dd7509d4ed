//! The windows of one picture against one source.

use super::{Field, Windows};
use selvedge_core::Domain;

/// The windows of one picture against one source.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comparison<'a> {
    pub(super) picture: Field<'a>,
    pub(super) source: Field<'a>,
    pub(super) weights: &'a [u8],
    pub(super) windows: Windows,
}

impl Comparison<'_> {
    /// The picture's windows.
    pub(super) fn asked(self) -> Domain<2> {
        self.windows.over(self.picture.features.domain())
    }

    /// Where windows can stand in the source.
    pub(super) fn offered(self) -> Domain<2> {
        Windows { step: 1, ..self.windows }.over(self.source.features.domain())
    }

    /// True if it can be made by displacement: errors stay below the mark of "none" in 32 bits, cells tile the windows,
    /// and displacements can be numbered.
    pub(super) fn is_by_displacement(self) -> bool {
        let Self { picture, source, weights, windows } = self;
        let weight: u64 = weights.iter().map(|&w| u64::from(w)).sum();
        let samples = u64::from(windows.side).saturating_pow(2);
        let error = samples.saturating_mul(weight).saturating_mul(255 * 255);
        let sides = |axis: usize| {
            let sides = [picture, source].map(|f| u64::from(f.features.domain().shape[axis]));
            sides[0] + sides[1] + 2 * u64::from(windows.side)
        };
        let displacements = sides(0).saturating_mul(sides(1));
        let whole = windows.side.is_multiple_of(windows.step);
        let narrow = error < u64::from(u32::MAX) && displacements < u64::from(u32::MAX);
        whole && narrow
    }
}
