//! What a file's header claims, checked before anything is decoded.

use selvedge_core::{Bytes, Domain, Limits};

use crate::Depth;
use crate::error::Problem;

/// What a header claims. Sides are wide enough for any claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) width: u64,
    pub(crate) height: u64,
    /// Channels, alpha included.
    pub(crate) channels: usize,
    pub(crate) alpha: bool,
    pub(crate) depth: Depth,
}

impl Header {
    /// Refuses empty and oversized pictures, and those whose decoding would not fit the budget: the file, the
    /// decoder's samples and the planar ones are held at once.
    pub(crate) fn check(&self, limits: &Limits, file_bytes: u64) -> Result<(), Problem> {
        self.check_size(limits)?;
        let needed = self.bytes().saturating_mul(2).saturating_add(file_bytes);
        afford(limits, needed)
    }

    /// Refuses empty and oversized pictures.
    pub(crate) fn check_size(&self, limits: &Limits) -> Result<(), Problem> {
        let Self { width, height, .. } = *self;
        if width == 0 || height == 0 || self.channels == 0 {
            return Err(Problem::NoSamples { width, height });
        }
        let limit = limits.side;
        if u64::from(limit) < width.max(height) {
            return Err(Problem::Side { width, height, limit });
        }
        let samples = width.saturating_mul(height);
        if limits.samples < samples {
            return Err(Problem::Samples { width, height, samples, limit: limits.samples });
        }
        Ok(())
    }

    /// The domain of a picture whose size was checked.
    pub(crate) fn domain(&self) -> Domain<2> {
        Domain::open([self.height as u32, self.width as u32])
    }

    /// Bytes of the samples.
    pub(crate) fn bytes(&self) -> u64 {
        let pixels = self.width.saturating_mul(self.height);
        pixels.saturating_mul(self.channels as u64).saturating_mul(self.depth.bytes())
    }
}

/// Refuses what takes more bytes than the budget.
pub(crate) fn afford(limits: &Limits, needed: u64) -> Result<(), Problem> {
    let (needed, budget) = (Bytes(needed), Bytes(limits.memory));
    if needed <= budget { Ok(()) } else { Err(Problem::Memory { needed, budget }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claims_around_every_power_are_refused_without_overflow() {
        let limits = Limits::default();
        for power in [16, 31, 32, 62, 63] {
            for side in [(1_u64 << power) - 1, 1 << power, (1 << power) + 1] {
                let header = |width, height| Header { width, height, channels: 4, alpha: true, depth: Depth::F32 };
                let fits = side <= 65_535;
                assert_eq!(header(side, 1).check(&limits, 0).is_ok(), fits, "{side}x1");
                assert_eq!(header(1, side).check(&limits, 0).is_ok(), fits, "1x{side}");
                assert!(header(side, side).check(&limits, 0).is_err(), "{side}x{side}");
            }
        }
    }

    #[test]
    fn the_budget_counts_file_decoder_and_planes() {
        let header = Header { width: 10, height: 10, channels: 3, alpha: false, depth: Depth::U16 };
        let limits = |memory| Limits { memory, ..Limits::default() };
        assert!(header.check(&limits(1_250), 50).is_ok());
        let refused = header.check(&limits(1_249), 50);
        assert!(matches!(refused, Err(Problem::Memory { needed: Bytes(1_250), budget: Bytes(1_249) })));
    }
}
