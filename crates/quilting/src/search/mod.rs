//! Which blocks agree with what lies under them. `[Efros01 2.2]`

#[cfg(test)]
pub(crate) mod plain;

use selvedge_core::{Exemplars, Guide, SimdLevel, reserve};
use selvedge_fft_ssd::{Costs, Placement, SsdSearcher, SumScratch, Tolerance, search_sum};

use crate::options::Error;

/// A window of features, where there are any.
#[derive(Clone, Debug, Default)]
pub(crate) struct Template {
    /// Height and width.
    pub(crate) shape: [u32; 2],
    /// Channel by channel, each row-major; meaningless where `mask` is false.
    pub(crate) features: Vec<u8>,
    /// Row-major: what is compared.
    pub(crate) mask: Vec<bool>,
}

/// Which features are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// Those of the exemplars.
    Texture,
    /// Those of the guide under the exemplars.
    Guide,
}

/// One thing that a block has to agree with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term<'a> {
    pub(crate) space: Space,
    pub(crate) template: &'a Template,
    /// How often its squared differences count.
    pub(crate) weight: u64,
}

/// One block of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    /// Sum over the terms of weight times squared feature differences, each channel by its own weight.
    pub(crate) error: u64,
    /// The source.
    pub(crate) source: usize,
    /// The block's top left sample.
    pub(crate) at: [u32; 2],
}

/// Which candidates are passed over while there are others: by source and top left sample.
pub(crate) type Avoid<'a> = &'a dyn Fn(usize, [u32; 2]) -> bool;

/// How much worse than the best a candidate may be, in thousandths, if that is the best.
pub(crate) type Within<'a> = &'a dyn Fn(&Candidate) -> u32;

/// Finds the blocks within a tolerance of the best.
pub(crate) trait Search: Sync {
    /// Working memory of one search after the other.
    type Scratch: Default + Send + Sync;

    /// Of all candidates that `avoid` lets pass (of all, if it lets none pass), those `within` a tolerance of the first by
    /// error, source and position, in the order of source and position. None if no valid block fits.
    ///
    /// There is at least one term, and all templates have one shape.
    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut Self::Scratch,
    ) -> Result<&'s [Candidate], Error>;
}

/// The exact search of `selvedge-fft-ssd`.
pub(crate) struct FastSearch<'e> {
    texture: SsdSearcher<'e, 2>,
    guide: Option<SsdSearcher<'e, 2>>,
}

/// Working memory of [`FastSearch`].
#[derive(Default)]
pub(crate) struct FastScratch {
    sum: SumScratch<2>,
    costs: Costs<2>,
    found: Vec<Candidate>,
}

impl<'e> FastSearch<'e> {
    pub(crate) fn new(
        exemplars: &'e Exemplars<2>,
        guide: Option<&'e Guide<2>>,
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        let options = selvedge_fft_ssd::Options { simd, ..selvedge_fft_ssd::Options::default() };
        let texture = SsdSearcher::with_options(exemplars, options)?;
        let guide = guide.map(|guide| SsdSearcher::of_guide(guide, options)).transpose()?;
        Ok(Self { texture, guide })
    }

    /// The weighted sum of all terms.
    fn sum(&self, terms: &[Term<'_>], to: &mut FastScratch) -> Result<(), Error> {
        let mut sum = Vec::with_capacity(terms.len());
        for Term { space, template, weight } in terms {
            let searcher = match space {
                Space::Texture => &self.texture,
                Space::Guide => self.guide.as_ref().expect("guide terms come with a guide"),
            };
            let template = selvedge_fft_ssd::Template::new(template.shape, &template.features).masked(&template.mask);
            sum.push(selvedge_fft_ssd::Term { searcher, template, weight: *weight });
        }
        Ok(search_sum(&sum, Placement::INSIDE, &mut to.sum, &mut to.costs)?)
    }
}

impl Search for FastSearch<'_> {
    type Scratch = FastScratch;

    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut FastScratch,
    ) -> Result<&'s [Candidate], Error> {
        self.sum(terms, scratch)?;
        let FastScratch { costs, found, .. } = scratch;
        let allowed = |source: usize, at: [i32; 2]| !avoid(source, at.map(|p| p as u32));
        let of = |c: selvedge_fft_ssd::Candidate<2>| Candidate {
            error: c.error,
            source: c.source,
            at: c.position.map(|p| p as u32),
        };
        let tolerance = |best: &selvedge_fft_ssd::Candidate<2>| Tolerance::from(within(&of(*best)));
        let mut near = costs.within_of_best(tolerance, allowed)?;
        if near.is_empty() {
            near = costs.within_of_best(tolerance, |_, _| true)?;
        }
        found.clear();
        reserve(found, near.len() as usize)?;
        found.extend(near.iter().map(of));
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plain::PlainSearch;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    fn exemplars(shape: [u32; 2], valid: Option<Vec<bool>>) -> Exemplars<2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(5).rng();
        let samples = (0..domain.len() * 2).map(|_| rng.below(256) as u8).collect();
        let source = Source {
            features: Grid::from_vec(domain, 2, samples).unwrap(),
            valid: valid.map(|v| Grid::from_vec(domain, 1, v).unwrap()),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        Exemplars::from_sources(vec![source], vec![1, 3]).unwrap()
    }

    fn template(e: &Exemplars<2>, at: [u32; 2], shape: [u32; 2]) -> Template {
        let positions = (0..2).flat_map(|c| Domain::open(shape).positions().map(move |p| (c, p)));
        let features = positions.map(|(c, [y, x])| e.sources()[0].features.get(c, [at[0] + y, at[1] + x])).collect();
        let mask = (0..shape[0] * shape[1]).map(|i| i % 3 != 1).collect();
        Template { shape, features, mask }
    }

    /// The whole list, in order.
    fn list(search: &impl Search, terms: &[Term<'_>], per_mille: u32, avoid: Avoid<'_>) -> Vec<Candidate> {
        let mut scratch = Default::default();
        let mut found = search.near(terms, &|_| per_mille, avoid, &mut scratch).unwrap().to_vec();
        found.sort_unstable();
        found
    }

    fn texture(template: &Template) -> [Term<'_>; 1] {
        [Term { space: Space::Texture, template, weight: 1 }]
    }

    #[test]
    fn a_piece_of_the_exemplar_is_found_where_it_was_cut() {
        let e = exemplars([9, 11], None);
        let t = template(&e, [2, 5], [4, 3]);
        let fast = FastSearch::new(&e, None, SimdLevel::Auto).unwrap();
        assert_eq!(list(&fast, &texture(&t), 0, &|_, _| false), [Candidate { error: 0, source: 0, at: [2, 5] }]);
        assert!(0 < list(&fast, &texture(&t), 0, &|_, at| at == [2, 5])[0].error);
        assert_eq!(list(&fast, &texture(&t), 0, &|_, _| true).len(), 1, "where all are avoided, none is");
    }

    #[test]
    fn the_fast_search_draws_what_the_plain_one_draws() {
        let domain = Domain::open([12, 9]);
        let holes: Vec<bool> = domain.positions().map(|[y, x]| (y, x) != (7, 3)).collect();
        for valid in [None, Some(holes)] {
            let e = exemplars(domain.shape, valid);
            for (shape, per_mille) in [([3, 4], 0), ([3, 4], 210), ([5, 2], 100_000), ([1, 1], 5_000_000)] {
                let t = template(&e, [1, 1], shape);
                let avoid: Avoid<'_> = &|_, at| at[0] + at[1] < 4;
                let fast = FastSearch::new(&e, None, SimdLevel::Auto).unwrap();
                assert_eq!(
                    list(&fast, &texture(&t), per_mille, avoid),
                    list(&PlainSearch::new(&e, None), &texture(&t), per_mille, avoid)
                );
            }
        }
    }

    #[test]
    fn terms_are_summed_by_their_weights() {
        let domain = Domain::open([13, 10]);
        let valid: Vec<bool> = domain.positions().map(|[y, x]| (y, x) != (2, 6)).collect();
        let e = exemplars(domain.shape, Some(valid));
        let map = Grid::from_vec(domain, 3, (0..domain.len() * 3).map(|i| (i * 37 % 251) as u8).collect()).unwrap();
        let guide = Guide::new(&e, std::slice::from_ref(&map), map.clone()).unwrap();
        let t = template(&e, [1, 1], [4, 3]);
        let features = (0..3).flat_map(|c| map.plane(c)[30..42].to_vec()).collect();
        let g = Template { shape: [4, 3], features, mask: vec![true; 12] };
        let whole = Template { mask: vec![true; 12], ..template(&e, [7, 5], [4, 3]) };
        let fast = FastSearch::new(&e, Some(&guide), SimdLevel::Auto).unwrap();
        let plain = PlainSearch::new(&e, Some(&guide));
        for weights in [[1, 1, 1], [0, 3, 1], [1 << 40, 1 << 39, 0], [5, 0, (1 << 38) - 1]] {
            let [a, b, c] = weights;
            let terms = [
                Term { space: Space::Texture, template: &t, weight: a },
                Term { space: Space::Texture, template: &whole, weight: b },
                Term { space: Space::Guide, template: &g, weight: c },
            ];
            let found = list(&fast, &terms, 500, &|_, _| false);
            assert_eq!(found, list(&plain, &terms, 500, &|_, _| false));
            assert!(!found.is_empty());
        }
        let nothing = Template { mask: vec![false; 12], ..t.clone() };
        let terms = [&nothing, &whole].map(|template| Term { space: Space::Texture, template, weight: 2 });
        let found = list(&fast, &terms, 500, &|_, _| false);
        assert_eq!(found, list(&plain, &terms, 500, &|_, _| false));
    }

    #[test]
    fn blocks_with_masked_samples_are_no_candidates() {
        let domain = Domain::open([6, 6]);
        let valid: Vec<bool> = domain.positions().map(|p| p != [2, 3]).collect();
        let e = exemplars([6, 6], Some(valid));
        let t = template(&e, [0, 0], [3, 3]);
        let found =
            list(&FastSearch::new(&e, None, SimdLevel::Auto).unwrap(), &texture(&t), u32::MAX, &|_, at| at == [0, 0]);
        assert!(found.iter().all(|c| !((c.at[0]..c.at[0] + 3).contains(&2) && (c.at[1]..c.at[1] + 3).contains(&3))));
        assert_eq!(found.len(), 16 - 9 - 1);
    }
}
