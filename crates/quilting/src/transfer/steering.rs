//! What a block of a transfer follows: its neighbours, the last pass, and the target, each with its weight.

use selvedge_core::{Domain, Exemplars, Guide, SourceMap};

use crate::block_grid::Block;
use crate::search::{Space, Template, Term};

/// Fixed point: an error of 1 (one squared 8-bit step a sample and channel). With the greatest mean of 255^2, errors
/// stay under 2^60.
const ONE: u64 = 1 << 44;

/// What blocks follow besides their neighbours. `[Efros01 3]`
pub(crate) struct Steering<'a> {
    guide: &'a Guide<2>,
    /// What the last pass laid.
    last: Option<&'a SourceMap<2>>,
    /// The texture's share in thousandths.
    alpha: u32,
    /// Under the current block: what the last pass laid, and the target.
    under: Template,
    target: Template,
}

impl<'a> Steering<'a> {
    pub(crate) fn new(guide: &'a Guide<2>, last: Option<&'a SourceMap<2>>, alpha: u32) -> Self {
        Self { guide, last, alpha, under: Template::default(), target: Template::default() }
    }

    /// `alpha * texture error + (1 - alpha) * correspondence error`, both as means a sample and channel, so that alpha
    /// means the same for every block and every number of channels. The texture error is the mean over the overlap and,
    /// from the second pass on, over the whole of what the last pass laid there.
    pub(crate) fn terms<'t>(
        &'t mut self,
        exemplars: &Exemplars<2>,
        block: &Block,
        overlap: &'t Template,
    ) -> Vec<Term<'t>> {
        self.target.read_target(self.guide, block);
        let mut terms = Vec::with_capacity(3);
        let mut samples = overlap.samples();
        if let Some(last) = self.last {
            self.under.read(exemplars, last, block, |_| true);
            samples += self.under.samples();
        }
        let weight = mean_weight(self.alpha, samples, exemplars.weights());
        if 0 < overlap.samples() {
            terms.push(Term { space: Space::Texture, template: overlap, weight });
        }
        if self.last.is_some() {
            terms.push(Term { space: Space::Texture, template: &self.under, weight });
        }
        let weight = mean_weight(1000 - self.alpha, self.target.samples(), self.guide.weights());
        terms.push(Term { space: Space::Guide, template: &self.target, weight });
        terms
    }
}

impl Template {
    /// Takes the guide's target under a block.
    fn read_target(&mut self, guide: &Guide<2>, block: &Block) {
        let target = guide.target();
        self.shape = block.shape();
        self.mask.clear();
        self.features.clear();
        for c in 0..target.channels() {
            let under = |p| target.get(c, block.position(target.domain(), p));
            self.features.extend(Domain::open(self.shape).positions().map(under));
        }
        self.mask.resize((self.shape[0] * self.shape[1]) as usize, true);
    }
}

/// What a squared difference counts towards `share` thousandths of a mean over so many samples, in units of
/// [`ONE`], to the nearest.
fn mean_weight(share: u32, samples: u64, weights: &[u8]) -> u64 {
    let whole = 1000 * u128::from(samples) * weights.iter().map(|&w| u128::from(w)).sum::<u128>();
    (u128::from(share) * u128::from(ONE) + whole / 2).checked_div(whole).unwrap_or(0) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_means_whatever_the_size() {
        // 49 samples of 3 channels, all differing by 10: a mean of 100.
        let texture = mean_weight(300, 49, &[1, 1, 1]) * 49 * 3 * 100;
        let guide = mean_weight(700, 1600, &[2]) * 1600 * 2 * 100;
        let off = (texture + guide).abs_diff(100 * ONE);
        assert!(off < ONE >> 20, "{off}");
        assert_eq!(mean_weight(1000, 0, &[1]), 0);
        assert_eq!(mean_weight(0, 5, &[1]), 0);
    }
}
