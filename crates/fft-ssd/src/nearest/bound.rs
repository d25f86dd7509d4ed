//! Whether windows can be compared by displacement.

use super::{Field, Windows};

/// What the sums of a comparison need.
pub(super) struct Bound {
    /// Errors stay below the mark of "none" in 32 bits, cells tile the windows, and displacements can be numbered.
    pub(super) by_displacement: bool,
}

impl Bound {
    pub(super) fn of(windows: Windows, weights: &[u8], picture: Field<'_>, source: Field<'_>) -> Self {
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
        Self { by_displacement: whole && narrow }
    }
}
