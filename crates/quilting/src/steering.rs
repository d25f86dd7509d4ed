//! What a block of a transfer follows: its neighbours, the last pass, and the target, each with its weight.

use selvedge_core::{Exemplars, Guide, Look, SourceMap};

use crate::block_grid::Block;
use crate::options::Error;
use crate::search::{Space, Term, mean_weights};

/// What blocks follow besides their neighbours. `[Efros01 3]`
pub(crate) struct Steering<'a> {
    guide: &'a Guide<2>,
    /// What the last pass laid.
    last: Option<&'a SourceMap<2>>,
    /// The texture's share in thousandths.
    alpha: u32,
}

/// What lies under one block: what the last pass laid, and the target.
#[derive(Default)]
pub(crate) struct Followed {
    under: Look,
    target: Look,
}

impl<'a> Steering<'a> {
    pub(crate) fn new(guide: &'a Guide<2>, last: Option<&'a SourceMap<2>>, alpha: u32) -> Self {
        Self { guide, last, alpha }
    }

    /// `alpha * texture error + (1 - alpha) * correspondence error`, both as means a sample and channel, so that alpha
    /// means the same for every block and every number of channels. The texture error is the mean over the overlap and,
    /// from the second pass on, over the whole of what the last pass laid there.
    pub(crate) fn terms<'t>(
        &self,
        exemplars: &Exemplars<2>,
        block: &Block,
        overlap: &'t Look,
        followed: &'t mut Followed,
    ) -> Result<Vec<Term<'t>>, Error> {
        let Followed { under, target } = followed;
        target.at_grid(self.guide.target(), self.guide.asked(), &block.window())?;
        let mut samples = overlap.samples();
        if let Some(last) = self.last {
            under.at_map(exemplars, last, &block.window(), |_| true)?;
            samples += under.samples();
        }
        let texture = samples as u64 * whole(exemplars.weights());
        let guide = target.samples() as u64 * whole(self.guide.weights());
        let [texture, guide] = mean_weights([(self.alpha, texture), (1000 - self.alpha, guide)]);

        let mut terms = Vec::with_capacity(3);
        if 0 < overlap.samples() {
            terms.push(Term { weight: texture, ..Term::new(Space::Texture, block.shape(), overlap) });
        }
        if self.last.is_some() {
            terms.push(Term { weight: texture, ..Term::new(Space::Texture, block.shape(), under) });
        }
        terms.push(Term { weight: guide, ..Term::new(Space::Guide, block.shape(), target) });
        Ok(terms)
    }
}

/// All channels' weights together.
fn whole(weights: &[u8]) -> u64 {
    weights.iter().map(|&w| u64::from(w)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block_grid::BlockGrid;
    use crate::search::plain::PlainSearch;
    use crate::search::{Candidate, Search};
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    /// Noise without two alike blocks.
    fn noise(seed: u64, shape: [u32; 2]) -> Grid<u8, 2> {
        let (domain, mut rng) = (Domain::open(shape), Seed(seed).rng());
        Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap()
    }

    /// A block of a map.
    fn window(map: &Grid<u8, 2>, [y, x]: [u32; 2], shape: [u32; 2]) -> Grid<u8, 2> {
        let samples = Domain::open(shape).positions().map(|p| map.get(0, [y + p[0], x + p[1]])).collect();
        Grid::from_vec(Domain::open(shape), 1, samples).unwrap()
    }

    /// The places that a first block fits without fault, where the last pass laid [`LAID`] there and the target is what
    /// lies at [`ASKED`].
    fn perfect(alpha: u32, is_first_pass: bool) -> Vec<[u32; 2]> {
        let shape = [4, 5];
        let (features, under) = (noise(1, [12, 14]), noise(2, [12, 14]));
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![3]).unwrap();
        let target = window(&under, ASKED, shape);
        let guide = Guide::new(&exemplars, &[under], target).unwrap();
        let mut last = SourceMap::unassigned(&exemplars, Domain::open(shape)).unwrap();
        for (at, id) in Domain::open(shape).positions().zip(last.ids.plane_mut(0)) {
            *id = exemplars.table().id(0, [LAID[0] + at[0], LAID[1] + at[1]]);
        }
        let block = BlockGrid::new(Domain::open(shape), 5, 2).block(0);
        let mut overlap = Look::new();
        overlap.at_map(&exemplars, &last, &block.window(), |_| false).unwrap();
        let steering = Steering::new(&guide, (!is_first_pass).then_some(&last), alpha);
        let mut followed = Followed::default();
        let terms = steering.terms(&exemplars, &block, &overlap, &mut followed).unwrap();
        let (search, mut scratch) = (PlainSearch::new(&exemplars, Some(&guide)), Vec::new());
        let found = search.near(&terms, &|_| 0, &|_, _| false, &mut scratch).unwrap();
        found.iter().filter(|c| c.error == 0).map(|&Candidate { at, .. }| at).collect()
    }

    const LAID: [u32; 2] = [3, 7];
    const ASKED: [u32; 2] = [6, 2];

    #[test]
    fn alpha_goes_from_the_target_alone_to_the_texture_alone() {
        assert_eq!(perfect(0, false), [ASKED]);
        assert_eq!(perfect(0, true), [ASKED]);
        assert_eq!(perfect(500, false), [[0; 2]; 0], "nothing is both");
    }

    #[test]
    fn the_last_pass_counts_from_the_second_on() {
        assert_eq!(perfect(1000, false), [LAID]);
        assert_eq!(perfect(1000, true).len(), 9 * 10, "the first block of a first pass has nothing to agree with");
    }

    #[test]
    fn shares_are_those_of_means_whatever_the_sizes() {
        for (small, large) in [(1, 1), (3 * 49, 1600), (24, 3 * (1 << 30)), (1 << 40, 1 << 41)] {
            let [texture, guide] = mean_weights([(300, small), (700, large)]);
            assert!(texture <= u64::from(u32::MAX));
            // Both means 65,025, the greatest there is.
            let sums = [(texture, small), (guide, large)].map(|(w, n)| u128::from(w) * u128::from(n) * 65_025);
            assert!(sums.iter().sum::<u128>() < 1 << 61);
            // 3 : 7, as exactly as whole numbers allow.
            let off = (sums[0] * 7).abs_diff(sums[1] * 3) as f64 / (sums[0] * 7) as f64;
            assert!(off <= 1.0 / guide.min(texture) as f64, "{off} {texture} {guide}");
        }
        assert_eq!(mean_weights([(1000, 0), (0, 5)]), [0, 0]);
    }
}
