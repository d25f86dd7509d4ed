//! What the caller of a transfer chooses, and what follows for each pass.

use selvedge_core::{Domain, Error as CoreError, Exemplars};

use crate::options::{Error, SearchBy, check_spread, check_tolerance};

/// Most passes. Blocks of 65,535 samples, the longest side of a picture, are at their smallest in the 25th; more passes
/// only repeat the last.
const MOST_PASSES: u32 = 32;

/// Blocks under this have no room for an overlap of two samples, and no seam to choose.
const LEAST_BLOCK: u32 = 4;

/// Options of [`transfer`](crate::transfer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferOptions {
    /// Side of the first pass's blocks in samples; each pass takes blocks smaller by a third, down to 4. Large ones
    /// keep more of the texture, small ones follow the target closer. From 4, so that overlaps have two samples, to the
    /// exemplar's shorter side. Default: chosen by [`suggest_transfer_block`] from target and exemplar.
    pub block: Option<u32>,
    /// Passes over the output, 1 to 32. From the second on blocks also agree with what the last pass put under them.
    /// Default: 5, the most that the paper used.
    pub passes: u32,
    /// Share of the texture in the error, 0 (only the target counts) to 1 (only the texture). Default: from 0.1 in the
    /// first pass to 0.9 in the last, as in the paper; 0.1 if there is one pass.
    pub alpha: Option<f64>,
    /// A block is drawn from those whose error (its root) is at most `1 + tolerance` times the least. From 0 (always
    /// the best) to 100. Default: 0.1, as in the paper.
    pub tolerance: f64,
    /// How evenly the exemplar's parts are used, as in [`Options::spread`](crate::Options::spread), within each pass.
    /// From 0 (whatever fits best, as in the paper) to 10. Default: 0.1, which shows more than one piece of an exemplar
    /// whose darkest or lightest place is small.
    pub spread: f64,
    /// How blocks are looked for in large exemplars; [`SearchBy::Exact`] for all places, as in the paper.
    pub search: SearchBy,
}

impl Default for TransferOptions {
    fn default() -> Self {
        Self { block: None, passes: 5, alpha: None, tolerance: 0.1, spread: 0.1, search: SearchBy::Auto }
    }
}

impl TransferOptions {
    /// The paper, to the letter; the block is left to the user there, and to [`suggest_transfer_block`] here.
    pub fn paper() -> Self {
        Self { spread: 0.0, search: SearchBy::Exact, ..Self::default() }
    }

    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// [`Error::TransferBlock`], [`Error::Passes`], and of the core [`Amount`](CoreError::Amount).
    pub fn validate(&self) -> Result<(), Error> {
        if let Some(block) = self.block.filter(|&b| b < LEAST_BLOCK) {
            return Err(Error::TransferBlock { block, least: LEAST_BLOCK });
        }
        if !(1..=MOST_PASSES).contains(&self.passes) {
            return Err(Error::Passes { passes: self.passes, limit: MOST_PASSES });
        }
        if let Some(alpha) = self.alpha.filter(|a| !(0.0..=1.0).contains(a)) {
            let range = "0 (only the target counts) to 1 (only the texture)";
            return Err(CoreError::amount("an alpha", alpha, range).into());
        }
        check_spread(self.spread)?;
        check_tolerance(self.tolerance)
    }

    /// The passes from the first block on. `[Efros01 3]`
    pub(crate) fn plan(&self, block: u32) -> Vec<PassPlan> {
        let mut side = block;
        let mut plan = Vec::new();
        for number in 0..self.passes.min(MOST_PASSES) {
            plan.push(PassPlan { block: side, overlap: overlap(side), alpha: self.alpha_of(number) });
            // Smaller by a third, to the nearest; blocks under 4 have no room for an overlap of 2.
            side = ((2 * u64::from(side) + 1) / 3).max(side.min(LEAST_BLOCK).into()) as u32;
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

/// A first block for a target: a ninth of its shorter side, from 12 to 36, but no more than two fifths of the smallest
/// exemplar's shorter side, for few large ones fit; and never under 4, unless the exemplar is.
///
/// Larger blocks than that blur what the target shows, however well they suit the texture, which keeps the more of
/// itself the larger they are. The rule knows sizes only, not what they show: a face of 256 samples a side gets first
/// blocks of 28, which is too large where it fills part of the picture or the texture has few levels (eyes and mouth
/// are lost); there blocks of 16 read. `[Efros01 3]` gives no size.
pub fn suggest_transfer_block(exemplars: &Exemplars<2>, target: Domain<2>) -> u32 {
    let exemplar = exemplars.sources().iter().flat_map(|s| s.domain().shape).min().unwrap_or(1);
    let [height, width] = target.shape;
    let block = (height.min(width) / 9).clamp(12, 36);
    block.min((exemplar * 2 / 5).max(exemplar.min(LEAST_BLOCK)))
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
        assert!(d.validate().is_ok() && TransferOptions::paper().validate().is_ok());
        assert!(TransferOptions { block: Some(4), ..d }.validate().is_ok());
        let wrong = [
            TransferOptions { block: Some(0), ..d },
            TransferOptions { block: Some(3), ..d },
            TransferOptions { spread: -0.1, ..d },
            TransferOptions { spread: f64::NAN, ..d },
            TransferOptions { passes: 0, ..d },
            TransferOptions { passes: 33, ..d },
            TransferOptions { alpha: Some(f64::NAN), ..d },
            TransferOptions { alpha: Some(1.1), ..d },
            TransferOptions { tolerance: -1.0, ..d },
        ];
        assert!(wrong.iter().all(|o| o.validate().is_err()));
    }
}
