//! The exact search of `selvedge-fft-ssd`, for blocks.

use selvedge_core::{Exemplars, Guide, Rng, SimdLevel, reserve};
use selvedge_fft_ssd::{Costs, Place, Placement, SsdSearcher, SumScratch, Tolerance, search_sum};

use super::few::{Few, compare, near_of};
use super::{Avoid, Candidate, Preference, Search, Space, Term, Within, draw, draw_some};
use crate::options::Error;

/// Searches every block of every source, exactly. Made once, asked many times.
#[derive(Debug)]
pub struct BlockSearch<'e> {
    texture: SsdSearcher<'e, 2>,
    guide: Option<SsdSearcher<'e, 2>>,
    places: u64,
    few: Few<'e>,
}

/// Working memory of a [`BlockSearch`]; it serves search after search.
#[derive(Debug, Default)]
pub struct BlockScratch {
    sum: SumScratch<2>,
    costs: Costs<2>,
    places: Vec<Place>,
    all: Vec<Candidate>,
    found: Vec<Candidate>,
}

impl<'e> BlockSearch<'e> {
    /// A search over all sources, and over the maps of a guide if there is one.
    ///
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub fn new(exemplars: &'e Exemplars<2>, guide: Option<&'e Guide<2>>, simd: SimdLevel) -> Result<Self, Error> {
        let options = selvedge_fft_ssd::Options { simd, ..selvedge_fft_ssd::Options::default() };
        let texture = SsdSearcher::with_options(exemplars, options)?;
        let guide = guide.map(|guide| SsdSearcher::of_guide(guide, options)).transpose()?;
        Ok(Self { texture, guide, places: exemplars.table().len().into(), few: Few::new(exemplars) })
    }

    /// Of all blocks whose error counts within the tolerance of the least, one by a uniform draw, and how many there
    /// were; `None` if no valid block fits. There is at least one term, and all templates have one shape.
    ///
    /// Time `O(positions * compared samples * channels)` or `O(positions * log(positions) * channels)`, whichever is
    /// less.
    ///
    /// # Errors
    /// [`Error::Search`]: templates of different shapes or wrong lengths, sums beyond 64 bits, or no memory.
    ///
    /// # Panics
    /// If a term is about a guide and there is none.
    pub fn draw(
        &self,
        terms: &[Term<'_>],
        preference: &Preference<'_>,
        rng: &mut Rng,
        scratch: &mut BlockScratch,
    ) -> Result<Option<(Candidate, u32)>, Error> {
        draw(self, terms, preference, rng, scratch)
    }

    /// The same for up to `most` different ones, in the order in which they are drawn; how many there were to draw
    /// from. The first is the one that [`draw`](Self::draw) answers with.
    ///
    /// # Errors
    /// Those of [`draw`](Self::draw).
    ///
    /// # Panics
    /// If a term is about a guide and there is none.
    pub fn draw_some(
        &self,
        terms: &[Term<'_>],
        preference: &Preference<'_>,
        (rng, most): (&mut Rng, usize),
        scratch: &mut BlockScratch,
        drawn: &mut Vec<Candidate>,
    ) -> Result<u32, Error> {
        draw_some(self, terms, preference, (rng, most), scratch, drawn)
    }

    /// What a term is compared with.
    fn searcher(&self, space: Space) -> &SsdSearcher<'e, 2> {
        match space {
            Space::Texture => &self.texture,
            Space::Guide => self.guide.as_ref().expect("guide terms come with a guide"),
        }
    }

    /// The weighted sum of all terms.
    fn sum(&self, terms: &[Term<'_>], to: &mut BlockScratch) -> Result<(), Error> {
        let mut sum = Vec::with_capacity(terms.len());
        for Term { space, template, weight } in terms {
            let searcher = self.searcher(*space);
            sum.push(selvedge_fft_ssd::Term { searcher, template: *template, weight: *weight });
        }
        Ok(search_sum(&sum, Placement::INSIDE, &mut to.sum, &mut to.costs)?)
    }
}

impl Search for BlockSearch<'_> {
    type Scratch = BlockScratch;

    fn places(&self) -> u64 {
        self.places
    }

    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut BlockScratch,
    ) -> Result<&'s [Candidate], Error> {
        let few = terms.first().map(|term| self.few.of(term.template.shape())).transpose()?.flatten();
        if let Some(few) = few {
            let BlockScratch { places, all, found, .. } = scratch;
            let searchers = terms.iter().map(|term| self.searcher(term.space));
            compare(&few, searchers.zip(terms), places, all)?;
            near_of(all, within, avoid, found)?;
            return Ok(found);
        }
        self.sum(terms, scratch)?;
        let BlockScratch { costs, found, .. } = scratch;
        near(costs, within, avoid, found)?;
        Ok(found)
    }
}

/// What [`Search::near`] finds, of errors that were worked out.
pub(super) fn near(
    costs: &mut Costs<2>,
    within: Within<'_>,
    avoid: Avoid<'_>,
    found: &mut Vec<Candidate>,
) -> Result<(), Error> {
    let tolerance = |best: &selvedge_fft_ssd::Candidate<2>| Tolerance::from(within(&(*best).into()));
    let mut near = costs.within_of_best(tolerance, |source, at| !avoid(source, at.map(|p| p as u32)))?;
    if near.is_empty() {
        near = costs.within_of_best(tolerance, |_, _| true)?;
    }
    found.clear();
    reserve(found, near.len() as usize)?;
    found.extend(near.iter().map(Candidate::from));
    Ok(())
}

impl From<selvedge_fft_ssd::Candidate<2>> for Candidate {
    fn from(c: selvedge_fft_ssd::Candidate<2>) -> Self {
        Self { error: c.error, source: c.source, at: c.position.map(|p| p as u32) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::plain::PlainSearch;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};
    use selvedge_fft_ssd::Template;

    fn exemplars(shape: [u32; 2], valid: Option<Vec<bool>>) -> Exemplars<2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(5).rng();
        let samples = (0..domain.len() * 2).map(|_| rng.below(256) as u8).collect();
        let source = Source {
            features: Grid::from_vec(domain, 2, samples).unwrap(),
            valid: valid.map(|v| Grid::from_vec(domain, 1, v).unwrap()).map(Into::into),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        Exemplars::from_sources(vec![source], vec![1, 3]).unwrap()
    }

    /// Features of a block, and what of them is compared.
    #[derive(Clone)]
    struct Under {
        shape: [u32; 2],
        features: Vec<u8>,
        mask: Vec<bool>,
    }

    impl Under {
        fn template(&self) -> Template<'_, 2> {
            Template::new(self.shape, &self.features).masked(&self.mask)
        }
    }

    #[test]
    fn of_a_mask_that_leaves_few_places_these_alone_are_compared() {
        let domain = Domain::open([40, 40]);
        // Two squares of 5 samples, and single samples.
        let valid = |[y, x]: [u32; 2]| {
            (3..8).contains(&y) && (30..35).contains(&x)
                || (20..25).contains(&y) && (9..14).contains(&x)
                || y * x % 7 == 3
        };
        let e = exemplars(domain.shape, Some(domain.positions().map(valid).collect()));
        let map = Grid::from_vec(domain, 1, (0..domain.len()).map(|i| (i * 37 % 251) as u8).collect()).unwrap();
        let guide = Guide::new(&e, std::slice::from_ref(&map), map.clone()).unwrap();
        let fast = BlockSearch::new(&e, Some(&guide), SimdLevel::Auto).unwrap();
        let plain = PlainSearch::new(&e, Some(&guide));
        let mut found = 0;
        for shape in [[5, 5], [4, 5], [3, 3], [6, 5], [1, 1]] {
            let t = template(&e, [1, 1], shape);
            let len = (shape[0] * shape[1]) as usize;
            let g = Under { shape, features: map.plane(0)[30..30 + len].to_vec(), mask: vec![true; len] };
            let terms = [
                Term { space: Space::Texture, template: t.template(), weight: 3 },
                Term { space: Space::Guide, template: g.template(), weight: 2 },
            ];
            for (per_mille, avoid) in [(0, 0), (500, 10), (100_000, 35)] {
                let avoid: Avoid<'_> = &move |_, at| at[0] + at[1] < avoid;
                for terms in [&terms[..1], &terms] {
                    let listed = list(&fast, terms, per_mille, avoid);
                    assert_eq!(listed, list(&plain, terms, per_mille, avoid), "{shape:?}");
                    found += listed.len();
                }
            }
            let is_few = fast.few.of(shape).unwrap().is_some();
            assert_eq!(is_few, ![[1, 1], [3, 3]].contains(&shape), "many places are searched: {shape:?}");
        }
        assert!(20 < found, "{found}");
        let whole = exemplars(domain.shape, None);
        assert!(BlockSearch::new(&whole, None, SimdLevel::Auto).unwrap().few.of([40, 40]).unwrap().is_none());
    }

    fn template(e: &Exemplars<2>, at: [u32; 2], shape: [u32; 2]) -> Under {
        let positions = (0..2).flat_map(|c| Domain::open(shape).positions().map(move |p| (c, p)));
        let features = positions.map(|(c, [y, x])| e.sources()[0].features.get(c, [at[0] + y, at[1] + x])).collect();
        let mask = (0..shape[0] * shape[1]).map(|i| i % 3 != 1).collect();
        Under { shape, features, mask }
    }

    /// The whole list, in order.
    fn list(search: &impl Search, terms: &[Term<'_>], per_mille: u32, avoid: Avoid<'_>) -> Vec<Candidate> {
        let mut scratch = Default::default();
        let mut found = search.near(terms, &|_| per_mille, avoid, &mut scratch).unwrap().to_vec();
        found.sort_unstable();
        found
    }

    fn texture(template: &Under) -> [Term<'_>; 1] {
        [Term { space: Space::Texture, template: template.template(), weight: 1 }]
    }

    #[test]
    fn a_piece_of_the_exemplar_is_found_where_it_was_cut() {
        let e = exemplars([9, 11], None);
        let t = template(&e, [2, 5], [4, 3]);
        let fast = BlockSearch::new(&e, None, SimdLevel::Auto).unwrap();
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
                let fast = BlockSearch::new(&e, None, SimdLevel::Auto).unwrap();
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
        let g = Under { shape: [4, 3], features, mask: vec![true; 12] };
        let whole = Under { mask: vec![true; 12], ..template(&e, [7, 5], [4, 3]) };
        let fast = BlockSearch::new(&e, Some(&guide), SimdLevel::Auto).unwrap();
        let plain = PlainSearch::new(&e, Some(&guide));
        for weights in [[1, 1, 1], [0, 3, 1], [1 << 40, 1 << 39, 0], [5, 0, (1 << 38) - 1]] {
            let [a, b, c] = weights;
            let terms = [
                Term { space: Space::Texture, template: t.template(), weight: a },
                Term { space: Space::Texture, template: whole.template(), weight: b },
                Term { space: Space::Guide, template: g.template(), weight: c },
            ];
            let found = list(&fast, &terms, 500, &|_, _| false);
            assert_eq!(found, list(&plain, &terms, 500, &|_, _| false));
            assert!(!found.is_empty());
        }
        let nothing = Under { mask: vec![false; 12], ..t.clone() };
        let terms =
            [&nothing, &whole].map(|under| Term { space: Space::Texture, template: under.template(), weight: 2 });
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
            list(&BlockSearch::new(&e, None, SimdLevel::Auto).unwrap(), &texture(&t), u32::MAX, &|_, at| at == [0, 0]);
        assert!(found.iter().all(|c| !((c.at[0]..c.at[0] + 3).contains(&2) && (c.at[1]..c.at[1] + 3).contains(&3))));
        assert_eq!(found.len(), 16 - 9 - 1);
    }
}
