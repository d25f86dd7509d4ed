//! Candidates from above: blocks are looked for in exemplars at a fraction of the size, and compared exactly around
//! what is best there.

mod compared;
mod piece;

use selvedge_core::{Exemplars, Guide, SimdLevel, Source, reserve};
use selvedge_fft_ssd::{Costs, Place, Placement, Scratch, SsdSearcher, SumScratch, search_sum};

use super::block_search::near;
use super::few::{compare, near_of};
use super::{Avoid, BlockScratch, BlockSearch, Candidate, Search, Space, Term, Within};
use crate::options::Error;
use compared::Compared;
use piece::Piece;
pub(crate) use piece::halved;

/// The sides that are left of exemplars at least: below, all places are compared in a millisecond.
const LEAST_SIDE: u32 = 192;
/// Samples that are left of overlaps at least. In fewer, too much of what has to fit is mean.
const LEAST_OVERLAP: u32 = 4;
/// The sides from which on thinner overlaps are halved as well, while anything is left of them: to compare narrow
/// blocks with all places of 2048^2 takes a gigabyte, and for an output of twice its sides hours.
const MOST_SIDE: u32 = 1024;
/// Places that are followed from one size to the next. With so many the error of what is drawn is within 5 % of the
/// least on 95 % of the blocks of fifty exemplars (a test holds it to that); time grows with them.
const FOLLOWED: usize = 32;
/// Of these, at the smallest size, so many are the best; the others are spread over all that may be near the best at
/// full size, so that a draw has as much to choose from.
const BEST: usize = 16;
/// How far these are from each other where few places are near the best: around each all within a sample are compared.
const APART: u32 = 3;
/// How much worse than the best, in thousandths, a place may be at the smallest size beyond what may be drawn: a mean
/// hides what differs within, and the best is off by up to a sample.
const MARGIN: u32 = 500;

/// Samples that are left of a side of blocks at least that are compared whole, as those of a transfer are. With them
/// the least error was met within a twentieth on 374 of 375 blocks of 7 to 36 samples in smooth noise; with fewer,
/// means over a block say little but its mean.
const LEAST_BLOCK: u32 = 4;

/// Exemplars at halves of their size, from one half on.
#[derive(Debug)]
pub(crate) struct Reduced(Vec<Exemplars<2>>);

impl Reduced {
    /// As many halves as blocks with such an overlap are searched at: none for exemplars that are small, that tile, or
    /// that have masks.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(exemplars: &Exemplars<2>, overlap: u32) -> Result<Self, Error> {
        Self::times(exemplars, halvings(exemplars, overlap))
    }

    /// So many halves.
    pub(crate) fn times(exemplars: &Exemplars<2>, n: u32) -> Result<Self, Error> {
        let mut halves: Vec<Exemplars<2>> = Vec::new();
        for _ in 0..n {
            let half = halves.last().unwrap_or(exemplars).coarser()?;
            halves.push(half);
        }
        Ok(Self(halves))
    }
}

/// How often exemplars are halved for blocks with such an overlap.
pub(crate) fn halvings(exemplars: &Exemplars<2>, overlap: u32) -> u32 {
    times(exemplars, |side, n| LEAST_OVERLAP <= overlap >> n || MOST_SIDE < side >> (n - 1) && 0 < overlap >> n)
}

/// The same for blocks of such a side, of which all is compared.
pub(crate) fn halvings_of_whole(exemplars: &Exemplars<2>, block: u32) -> u32 {
    times(exemplars, |_, n| is_seen_whole(block, n))
}

/// True if enough is left of such a block's side after so many halvings.
fn is_seen_whole(block: u32, n: u32) -> bool {
    LEAST_BLOCK <= halved([block; 2], n)[0]
}

/// As often as is seen of blocks, by the shortest side of exemplars and the number of halvings.
fn times(exemplars: &Exemplars<2>, is_seen: impl Fn(u32, u32) -> bool) -> u32 {
    let is_whole = |s: &Source<2>| s.valid.is_none() && s.domain().periodic == [false; 2];
    if !exemplars.sources().iter().all(|source| is_whole(source)) {
        return 0;
    }
    let side = exemplars.sources().iter().flat_map(|s| s.domain().shape).min().unwrap_or(0);
    (1..16).take_while(|&n| LEAST_SIDE <= side >> n && is_seen(side, n)).last().unwrap_or(0)
}

/// Searches the smallest size everywhere, and the larger ones around what is best there.
#[derive(Debug)]
pub(crate) struct FromAbove<'e> {
    /// The exemplars, and those halved once, twice and so on.
    sizes: Vec<&'e Exemplars<2>>,
    searchers: Vec<SsdSearcher<'e, 2>>,
    /// Of the maps of a guide, at the same sizes.
    guides: Vec<SsdSearcher<'e, 2>>,
    /// For blocks too thin to be halved.
    exact: BlockSearch<'e>,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct AboveScratch {
    search: Scratch,
    sum: SumScratch<2>,
    costs: Costs<2>,
    exact: BlockScratch,
    places: Vec<Place>,
    compared: Vec<Place>,
    all: Vec<Candidate>,
    found: Vec<Candidate>,
}

impl<'e> FromAbove<'e> {
    /// `None` if there are no halves.
    ///
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub(crate) fn new(
        exemplars: &'e Exemplars<2>,
        reduced: &'e Reduced,
        guide: Option<(&'e Guide<2>, &'e Reduced)>,
        simd: SimdLevel,
    ) -> Result<Option<Self>, Error> {
        if reduced.0.is_empty() {
            return Ok(None);
        }
        let options = selvedge_fft_ssd::Options { simd, ..selvedge_fft_ssd::Options::default() };
        let of = |all: &[&'e Exemplars<2>]| -> Result<Vec<_>, Error> {
            Ok(all.iter().map(|e| SsdSearcher::with_options(e, options)).collect::<Result<_, _>>()?)
        };
        let sizes: Vec<&Exemplars<2>> = std::iter::once(exemplars).chain(&reduced.0).collect();
        let guides: Vec<&Exemplars<2>> =
            guide.iter().flat_map(|(guide, reduced)| std::iter::once(guide.exemplars()).chain(&reduced.0)).collect();
        let exact = BlockSearch::new(exemplars, guide.map(|(guide, _)| guide), simd)?;
        Ok(Some(Self { searchers: of(&sizes)?, guides: of(&guides)?, sizes, exact }))
    }

    /// What a term is compared with at a size.
    fn searcher(&self, space: Space, level: usize) -> &SsdSearcher<'e, 2> {
        match space {
            Space::Texture => &self.searchers[level],
            Space::Guide => &self.guides[level],
        }
    }

    /// Places at the smallest size: the best, and some of all that may be drawn.
    fn first(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        to: &mut AboveScratch,
    ) -> Result<Vec<Candidate>, Error> {
        let AboveScratch { search, sum, costs, found: all, .. } = to;
        let level = self.sizes.len() - 1;
        if let [Term { space, template, .. }] = terms {
            self.searcher(*space, level).search(template, Placement::INSIDE, search, costs)?;
        } else {
            let mut weighed = Vec::with_capacity(terms.len());
            for &Term { space, template, weight } in terms {
                weighed.push(selvedge_fft_ssd::Term { searcher: self.searcher(space, level), template, weight });
            }
            search_sum(&weighed, Placement::INSIDE, sum, costs)?;
        }
        let up = |at: [u32; 2]| at.map(|p| p << level);
        let wider = |best: &Candidate| within(&Candidate { at: up(best.at), ..*best }).saturating_add(MARGIN);
        near(costs, &wider, &|source, at| avoid(source, up(at)), all)?;
        let is_few = all.len() <= FOLLOWED;
        let best = costs.best_k(if is_few { FOLLOWED } else { BEST }, APART)?;
        let mut chosen: Vec<Candidate> = best.iter().map(|&c| c.into()).collect();
        if !is_few {
            // Spread evenly in the order of places.
            chosen.extend((BEST..FOLLOWED).map(|i| all[(i - BEST) * all.len() / (FOLLOWED - BEST)]));
        }
        Ok(chosen)
    }

    /// All places around some of the next smaller size.
    fn around(
        &self,
        level: usize,
        coarse: &[Candidate],
        shape: [u32; 2],
        places: &mut Vec<Place>,
    ) -> Result<(), Error> {
        places.clear();
        reserve(places, 16 * coarse.len())?;
        let sources = self.sizes[level].sources();
        for c in coarse {
            // Halved, a source may hold a block that it does not hold whole.
            let most = [0, 1].map(|a| sources[c.source].domain().shape[a].checked_sub(shape[a]));
            let [Some(down), Some(across)] = most else { continue };
            let most = [down, across];
            // The block that a coarse sample stands for, and one sample around it.
            let range = |a: usize| (2 * c.at[a]).saturating_sub(1).min(most[a])..=(2 * c.at[a] + 2).min(most[a]);
            places.extend(range(0).flat_map(|y| range(1).map(move |x| Place::new(c.source, [y, x]))));
        }
        places.sort_unstable_by_key(|p| (p.source, p.at));
        places.dedup();
        Ok(())
    }
}

impl Search for FromAbove<'_> {
    type Scratch = AboveScratch;

    fn places(&self) -> u64 {
        self.sizes[self.sizes.len() - 1].table().len().into()
    }

    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut AboveScratch,
    ) -> Result<&'s [Candidate], Error> {
        let channels = |term: &Term<'_>| self.searcher(term.space, 0).channels();
        let mut sizes = vec![terms.iter().map(|term| Piece::of(term, channels(term))).collect::<Result<Vec<_>, _>>()?];
        for _ in 1..self.sizes.len() {
            let halved = sizes[sizes.len() - 1].iter().map(Piece::halved).collect::<Result<_, _>>()?;
            sizes.push(halved);
        }
        // What vanished says nothing.
        let left = |level: usize| -> Vec<Term<'_>> {
            let terms = terms.iter().zip(&sizes[level]).filter(|(_, piece)| !piece.is_empty());
            terms.map(|(term, piece)| Term { template: piece.template(), ..*term }).collect()
        };
        let smallest = left(self.sizes.len() - 1);
        if smallest.is_empty() {
            return self.exact.near(terms, within, avoid, &mut scratch.exact);
        }
        let mut coarse = self.first(&smallest, within, avoid, scratch)?;
        let AboveScratch { places, compared, all, found, .. } = scratch;
        for level in (0..self.sizes.len() - 1).rev() {
            let terms_here = left(level);
            self.around(level, &coarse, sizes[level][0].shape(), places)?;
            if places.is_empty() {
                return self.exact.near(terms, within, avoid, &mut scratch.exact);
            }
            let allowed = |place: &Place| !avoid(place.source, place.at);
            if level == 0 && places.iter().any(allowed) {
                places.retain(allowed);
            }
            if let [Term { space, template, weight }] = terms_here[..] {
                let mut compared = Compared::new(self.searcher(space, level), template, places)?;
                if level == 0 {
                    compared.near(within, found)?;
                    found.iter_mut().for_each(|c| c.error = c.error.saturating_mul(weight));
                } else {
                    compared.least(FOLLOWED, &mut coarse)?;
                }
                continue;
            }
            let searchers = terms_here.iter().map(|term| self.searcher(term.space, level));
            compare(places, searchers.zip(&terms_here), compared, all)?;
            if level == 0 {
                near_of(all, within, avoid, found)?;
            } else {
                all.sort_unstable();
                all.truncate(FOLLOWED);
                std::mem::swap(&mut coarse, all);
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests;
