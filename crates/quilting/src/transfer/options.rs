//! What the caller of a transfer chooses, and what follows for each pass.

use crate::options::{Error, check_tolerance};

/// Most passes: blocks are at their smallest long before.
const MOST_PASSES: u32 = 32;

/// Options of [`transfer`](crate::transfer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferOptions {
    /// Side of the first pass's blocks in samples; each pass takes blocks smaller by a third, down to 4. Large ones keep
    /// more of the texture, small ones follow the target closer. From 1 to the exemplar's shorter side. Default: chosen
    /// by [`suggest_block`](crate::suggest_block) from the exemplar.
    pub block: Option<u32>,
    /// Passes over the output, 1 to 32. From the second on blocks also agree with what the last pass put under them.
    /// Default: 5, the most that the paper used.
    pub passes: u32,
    /// Share of the texture in the error, 0 (only the target counts) to 1 (only the texture). Default: from 0.1 in the
    /// first pass to 0.9 in the last, as in the paper; 0.1 if there is one pass.
    pub alpha: Option<f64>,
    /// A block is drawn from those whose error (its root) is at most `1 + tolerance` times the least. From 0 (always the
    /// best) to 100. Default: 0.1, as in the paper.
    pub tolerance: f64,
}

impl Default for TransferOptions {
    fn default() -> Self {
        Self { block: None, passes: 5, alpha: None, tolerance: 0.1 }
    }
}

impl TransferOptions {
    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::Block`], [`Error::Passes`], [`Error::Alpha`], [`Error::Tolerance`].
    pub fn validate(&self) -> Result<(), Error> {
        if self.block == Some(0) {
            return Err(Error::Block);
        }
        if !(1..=MOST_PASSES).contains(&self.passes) {
            return Err(Error::Passes { passes: self.passes, limit: MOST_PASSES });
        }
        if let Some(alpha) = self.alpha.filter(|a| !(0.0..=1.0).contains(a)) {
            return Err(Error::Alpha { alpha });
        }
        check_tolerance(self.tolerance)
    }

    /// The passes from the first block on. `[Efros01 3]`
    pub(crate) fn plan(&self, block: u32) -> Vec<PassPlan> {
        let mut side = block;
        let mut plan = Vec::new();
        for number in 0..self.passes {
            plan.push(PassPlan { block: side, overlap: overlap(side), alpha: self.alpha_of(number) });
            // Smaller by a third, to the nearest; blocks under 4 have no room for an overlap of 2.
            side = ((2 * side + 1) / 3).max(side.min(4));
        }
        plan
    }

    /// `0.8 * (i - 1) / (N - 1) + 0.1` in thousandths, where passes count from 0. The paper's formula has no value for
    /// one pass, which is a first one.
    fn alpha_of(&self, number: u32) -> u32 {
        let share = if number == 0 { 0.0 } else { f64::from(number) / f64::from(self.passes - 1) };
        (self.alpha.unwrap_or(0.8 * share + 0.1) * 1000.0).round() as u32
    }
}

/// A sixth of the block, at least 2 samples where the block has room for them.
fn overlap(block: u32) -> u32 {
    (block / 6).max(2).min(block / 2)
}

/// What one pass works with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PassPlan {
    pub(crate) block: u32,
    pub(crate) overlap: u32,
    /// The texture's share in thousandths.
    pub(crate) alpha: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(block: u32, passes: u32) -> Vec<[u32; 3]> {
        let options = TransferOptions { passes, ..TransferOptions::default() };
        options.plan(block).iter().map(|p| [p.block, p.overlap, p.alpha]).collect()
    }

    #[test]
    fn passes_follow_the_paper() {
        let five = [[36, 6, 100], [24, 4, 300], [16, 2, 500], [11, 2, 700], [7, 2, 900]];
        assert_eq!(plan(36, 5), five);
        assert_eq!(plan(36, 1), [[36, 6, 100]]);
        assert_eq!(plan(30, 4).iter().map(|p| p[2]).collect::<Vec<_>>(), [100, 367, 633, 900]);
    }

    #[test]
    fn overlaps_keep_two_samples_wherever_blocks_have_four() {
        for block in 1..200 {
            for [side, overlap, _] in plan(block, 20) {
                assert!(block.min(4) <= side && overlap <= side / 2);
                assert!(overlap == (side / 2).min(2) || 2 < overlap);
            }
        }
    }

    #[test]
    fn wrong_options_are_refused() {
        let d = TransferOptions::default();
        assert!(d.validate().is_ok());
        let wrong = [
            TransferOptions { block: Some(0), ..d },
            TransferOptions { passes: 0, ..d },
            TransferOptions { passes: 33, ..d },
            TransferOptions { alpha: Some(f64::NAN), ..d },
            TransferOptions { alpha: Some(1.1), ..d },
            TransferOptions { tolerance: -1.0, ..d },
        ];
        assert!(wrong.iter().all(|o| o.validate().is_err()));
    }
}
