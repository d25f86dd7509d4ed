//! Which blocks agree with what lies under them. `[Efros01 2.2]`

use selvedge_core::{Exemplars, SimdLevel};
use selvedge_fft_ssd::{Costs, Placement, Scratch, SsdSearcher, Tolerance};

use crate::options::Error;

/// What a block has to agree with: features of the output under the block, where there are any.
#[derive(Clone, Debug, Default)]
pub(crate) struct Template {
    /// Height and width.
    pub(crate) shape: [u32; 2],
    /// Channel by channel, each row-major; meaningless where `mask` is false.
    pub(crate) features: Vec<u8>,
    /// Row-major: where the output is filled.
    pub(crate) mask: Vec<bool>,
}

/// One block of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    /// Sum of squared feature differences over the template, each channel by its weight.
    pub(crate) error: u64,
    /// The source.
    pub(crate) source: usize,
    /// The block's top left sample.
    pub(crate) at: [u32; 2],
}

/// Which candidates are passed over while there are others: by source and top left sample.
pub(crate) type Avoid<'a> = &'a dyn Fn(usize, [u32; 2]) -> bool;

/// Finds the blocks within a tolerance of the best and draws one.
pub(crate) trait Search {
    /// Of all candidates that `avoid` lets pass (of all, if it lets none pass), those whose error is at most
    /// `1 + per_mille / 1000` times the least, in order of error, source and position: candidate number
    /// `pick(how many)`, and how many. `None` if no valid block fits.
    fn draw(
        &mut self,
        template: &Template,
        per_mille: u32,
        avoid: Avoid<'_>,
        pick: &mut dyn FnMut(u32) -> u32,
    ) -> Result<Option<(Candidate, u32)>, Error>;
}

/// The exact search of `selvedge-fft-ssd`.
pub(crate) struct FastSearch<'e> {
    searcher: SsdSearcher<'e, 2>,
    scratch: Scratch,
    costs: Costs<2>,
}

impl<'e> FastSearch<'e> {
    pub(crate) fn new(exemplars: &'e Exemplars<2>, simd: SimdLevel) -> Result<Self, Error> {
        let options = selvedge_fft_ssd::Options { simd, ..selvedge_fft_ssd::Options::default() };
        let searcher = SsdSearcher::with_options(exemplars, options)?;
        Ok(Self { searcher, scratch: Scratch::new(), costs: Costs::new() })
    }
}

impl Search for FastSearch<'_> {
    fn draw(
        &mut self,
        template: &Template,
        per_mille: u32,
        avoid: Avoid<'_>,
        pick: &mut dyn FnMut(u32) -> u32,
    ) -> Result<Option<(Candidate, u32)>, Error> {
        let query = selvedge_fft_ssd::Template::new(template.shape, &template.features).masked(&template.mask);
        self.searcher.search(&query, Placement::INSIDE, &mut self.scratch, &mut self.costs)?;
        let tolerance = Tolerance::from(per_mille);
        let allowed = |source: usize, at: [i32; 2]| !avoid(source, at.map(|p| p as u32));
        let mut near = self.costs.within_where(tolerance, allowed);
        if near.is_empty() {
            near = self.costs.within(tolerance);
        }
        let len = near.len();
        if len == 0 {
            return Ok(None);
        }
        let found = near.nth(pick(len));
        let at = found.position.map(|p| p as u32);
        Ok(Some((Candidate { error: found.error, source: found.source, at }, len)))
    }
}

#[cfg(test)]
pub(crate) mod plain {
    //! The search as the paper has it, block by block and sample by sample: what the fast one is held against.

    use super::*;
    use selvedge_core::{Domain, Source};

    /// Looks at every sample of every block of every source.
    pub(crate) struct PlainSearch<'e>(pub(crate) &'e Exemplars<2>);

    impl Search for PlainSearch<'_> {
        fn draw(
            &mut self,
            template: &Template,
            per_mille: u32,
            avoid: Avoid<'_>,
            pick: &mut dyn FnMut(u32) -> u32,
        ) -> Result<Option<(Candidate, u32)>, Error> {
            let all = all(self.0, template);
            let mut near = within(&all, per_mille, |c| !avoid(c.source, c.at));
            if near.is_empty() {
                near = within(&all, per_mille, |_| true);
            }
            let len = near.len() as u32;
            Ok((len != 0).then(|| (near[pick(len) as usize], len)))
        }
    }

    fn within(all: &[Candidate], per_mille: u32, allow: impl Fn(&Candidate) -> bool) -> Vec<Candidate> {
        let mut near: Vec<Candidate> = all.iter().copied().filter(allow).collect();
        near.sort_unstable();
        let limit = near.first().map_or(0, |best| best.error * (1000 + u64::from(per_mille)));
        near.retain(|c| c.error * 1000 <= limit);
        near
    }

    fn all(exemplars: &Exemplars<2>, template: &Template) -> Vec<Candidate> {
        let mut found = Vec::new();
        for (number, source) in exemplars.sources().iter().enumerate() {
            for at in source.domain().positions() {
                if let Some(error) = error(source, exemplars.weights(), template, at) {
                    found.push(Candidate { error, source: number, at });
                }
            }
        }
        found
    }

    /// `None` if the block sticks out or holds masked samples.
    fn error(source: &Source<2>, weights: &[u8], template: &Template, at: [u32; 2]) -> Option<u64> {
        let block = Domain::open(template.shape);
        let mut error = 0;
        for (i, p) in block.positions().enumerate() {
            let from = source.domain().step(at, p.map(|p| p as i32))?;
            if source.valid.as_ref().is_some_and(|v| !v.get(0, from)) {
                return None;
            }
            for (c, &weight) in weights.iter().enumerate().filter(|_| template.mask[i]) {
                let d = source.features.get(c, from).abs_diff(template.features[c * block.len() + i]);
                error += u64::from(d).pow(2) * u64::from(weight);
            }
        }
        Some(error)
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

    /// The whole list, by drawing each of its members.
    fn list(search: &mut dyn Search, template: &Template, per_mille: u32, avoid: Avoid<'_>) -> Vec<Candidate> {
        let Some((_, len)) = search.draw(template, per_mille, avoid, &mut |_| 0).unwrap() else { return Vec::new() };
        (0..len).map(|k| search.draw(template, per_mille, avoid, &mut |_| k).unwrap().unwrap().0).collect()
    }

    #[test]
    fn a_piece_of_the_exemplar_is_found_where_it_was_cut() {
        let e = exemplars([9, 11], None);
        let t = template(&e, [2, 5], [4, 3]);
        let mut fast = FastSearch::new(&e, SimdLevel::Auto).unwrap();
        assert_eq!(list(&mut fast, &t, 0, &|_, _| false), [Candidate { error: 0, source: 0, at: [2, 5] }]);
        assert!(0 < list(&mut fast, &t, 0, &|_, at| at == [2, 5])[0].error);
        assert_eq!(list(&mut fast, &t, 0, &|_, _| true).len(), 1, "where all are avoided, none is");
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
                let mut fast = FastSearch::new(&e, SimdLevel::Auto).unwrap();
                assert_eq!(list(&mut fast, &t, per_mille, avoid), list(&mut PlainSearch(&e), &t, per_mille, avoid));
            }
        }
    }

    #[test]
    fn blocks_with_masked_samples_are_no_candidates() {
        let domain = Domain::open([6, 6]);
        let valid: Vec<bool> = domain.positions().map(|p| p != [2, 3]).collect();
        let e = exemplars([6, 6], Some(valid));
        let t = template(&e, [0, 0], [3, 3]);
        let found = list(&mut FastSearch::new(&e, SimdLevel::Auto).unwrap(), &t, u32::MAX, &|_, at| at == [0, 0]);
        assert!(found.iter().all(|c| !((c.at[0]..c.at[0] + 3).contains(&2) && (c.at[1]..c.at[1] + 3).contains(&3))));
        assert_eq!(found.len(), 16 - 9 - 1);
    }
}
