//! Candidates from above: blocks are looked for in exemplars at a fraction of the size, and compared exactly around
//! what is best there.

use std::ops::Range;

use selvedge_core::{Exemplars, SimdLevel, reserve, try_vec};
use selvedge_fft_ssd::{Costs, Placement, Scratch, SsdSearcher, Template};

use super::block_search::near;
use super::{Avoid, BlockScratch, BlockSearch, Candidate, Search, Term, Within};
use crate::options::Error;

/// The sides that are left of exemplars at least: below, all places are compared in a millisecond.
const LEAST_SIDE: u32 = 192;
/// Samples that are left of overlaps at least. In fewer, too much of what has to fit is mean.
const LEAST_OVERLAP: u32 = 4;
/// Places that are followed from one size to the next.
const FOLLOWED: usize = 32;
/// Of these, at the smallest size, so many are the best; the others are spread over all that may be near the best at
/// full size, so that a draw has as much to choose from.
const BEST: usize = 16;
/// How far these are from each other where few places are near the best: around each all within a sample are compared.
const APART: u32 = 3;
/// How much worse than the best, in thousandths, a place may be at the smallest size beyond what may be drawn: a mean
/// hides what differs within, and the best is off by up to a sample.
const MARGIN: u32 = 500;

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
    let sources = exemplars.sources();
    if sources.iter().any(|s| s.valid.is_some() || s.domain().periodic != [false; 2]) {
        return 0;
    }
    let side = sources.iter().flat_map(|s| s.domain().shape).min().unwrap_or(0);
    (1..16).take_while(|n| LEAST_SIDE <= side >> n && LEAST_OVERLAP <= overlap >> n).last().unwrap_or(0)
}

/// Searches the smallest size everywhere, and the larger ones around what is best there.
#[derive(Debug)]
pub(crate) struct FromAbove<'e> {
    exemplars: &'e Exemplars<2>,
    halves: &'e [Exemplars<2>],
    smallest: SsdSearcher<'e, 2>,
    /// For blocks too thin to be halved.
    exact: BlockSearch<'e>,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct AboveScratch {
    search: Scratch,
    costs: Costs<2>,
    exact: BlockScratch,
    found: Vec<Candidate>,
}

impl<'e> FromAbove<'e> {
    /// `None` if there are no halves.
    ///
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub(crate) fn new(
        exemplars: &'e Exemplars<2>,
        Reduced(halves): &'e Reduced,
        simd: SimdLevel,
    ) -> Result<Option<Self>, Error> {
        let Some(last) = halves.last() else { return Ok(None) };
        let options = selvedge_fft_ssd::Options { simd, ..selvedge_fft_ssd::Options::default() };
        let smallest = SsdSearcher::with_options(last, options)?;
        Ok(Some(Self { exemplars, halves, smallest, exact: BlockSearch::new(exemplars, None, simd)? }))
    }

    /// The sources of a size: 0 for the full one, `n` for that halved `n` times.
    fn at(&self, level: usize) -> &Exemplars<2> {
        level.checked_sub(1).map_or(self.exemplars, |half| &self.halves[half])
    }

    /// Places at the smallest size: the best, and some of all that may be drawn.
    fn first(
        &self,
        template: &Piece,
        within: Within<'_>,
        avoid: Avoid<'_>,
        to: &mut AboveScratch,
    ) -> Result<Vec<Candidate>, Error> {
        let AboveScratch { search, costs, found: all, .. } = to;
        let level = self.halves.len();
        let of = Template::new(template.shape, &template.features).masked(&template.mask);
        self.smallest.search(&of, Placement::INSIDE, search, costs)?;
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

    /// All places around some of the next smaller size, with their errors at this one.
    fn around(
        &self,
        level: usize,
        coarse: &[Candidate],
        template: &Piece,
        to: &mut Vec<Candidate>,
    ) -> Result<(), Error> {
        to.clear();
        let mut places: Vec<(usize, [u32; 2])> = Vec::new();
        reserve(&mut places, 16 * coarse.len())?;
        let sources = self.at(level).sources();
        for c in coarse {
            let most = [0, 1].map(|a| sources[c.source].domain().shape[a].saturating_sub(template.shape[a]));
            // The block that a coarse sample stands for, and one sample around it.
            let range = |a: usize| (2 * c.at[a]).saturating_sub(1).min(most[a])..=(2 * c.at[a] + 2).min(most[a]);
            places.extend(range(0).flat_map(|y| range(1).map(move |x| (c.source, [y, x]))));
        }
        places.sort_unstable();
        places.dedup();
        reserve(to, places.len())?;
        let error = |(source, at)| template.error(self.at(level), source, at);
        to.extend(places.into_iter().map(|(source, at)| Candidate { error: error((source, at)), source, at }));
        Ok(())
    }
}

impl Search for FromAbove<'_> {
    type Scratch = AboveScratch;

    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut AboveScratch,
    ) -> Result<&'s [Candidate], Error> {
        if 1 < terms.len() {
            return self.exact.near(terms, within, avoid, &mut scratch.exact);
        }
        let mut pieces = vec![Piece::of(&terms[0], self.exemplars.channels())?];
        for _ in 0..self.halves.len() {
            let half = pieces[pieces.len() - 1].halved()?;
            pieces.push(half);
        }
        let smallest = &pieces[pieces.len() - 1];
        if smallest.rows.is_empty() {
            return self.exact.near(terms, within, avoid, &mut scratch.exact);
        }
        let mut coarse = self.first(smallest, within, avoid, scratch)?;
        for level in (0..self.halves.len()).rev() {
            self.around(level, &coarse, &pieces[level], &mut scratch.found)?;
            if level != 0 {
                let kept = FOLLOWED.min(scratch.found.len());
                if kept < scratch.found.len() {
                    scratch.found.select_nth_unstable(kept);
                }
                coarse.clear();
                coarse.extend_from_slice(&scratch.found[..kept]);
            }
        }
        let weight = terms[0].weight;
        scratch.found.iter_mut().for_each(|c| c.error = c.error.saturating_mul(weight));
        let allowed = |c: &Candidate| !avoid(c.source, c.at);
        if scratch.found.iter().any(allowed) {
            scratch.found.retain(allowed);
        }
        let best = scratch.found.iter().min().copied();
        let limit = best.map_or(0, |best| u128::from(best.error) * (1000 + u128::from(within(&best))));
        scratch.found.retain(|c| u128::from(c.error) * 1000 <= limit);
        Ok(&scratch.found)
    }
}

/// What is searched for at one size, and the stretches of its rows that are compared.
#[derive(Debug)]
struct Piece {
    shape: [u32; 2],
    features: Vec<u8>,
    mask: Vec<bool>,
    rows: Vec<Range<usize>>,
}

impl Piece {
    fn new(shape: [u32; 2], features: Vec<u8>, mask: Vec<bool>) -> Self {
        let width = shape[1] as usize;
        let mut rows: Vec<Range<usize>> = Vec::new();
        for i in (0..mask.len()).filter(|&i| mask[i]) {
            match rows.last_mut() {
                Some(row) if row.end == i && !i.is_multiple_of(width) => row.end += 1,
                _ => rows.push(i..i + 1),
            }
        }
        Self { shape, features, mask, rows }
    }

    fn of(term: &Term<'_>, channels: usize) -> Result<Self, Error> {
        let template = term.template;
        let len = template.shape().iter().map(|&n| n as usize).product::<usize>();
        let mut features = try_vec(len * channels, 0_u8)?;
        features.copy_from_slice(template.features());
        let mut mask = try_vec(len, true)?;
        if let Some(known) = template.mask() {
            mask.copy_from_slice(known);
        }
        Ok(Self::new(template.shape(), features, mask))
    }

    /// The same at half the size: means of what is known, where at least half of four samples are.
    fn halved(&self) -> Result<Self, Error> {
        let shape = self.shape.map(|n| n / 2);
        let (len, width, wide) = ((shape[0] * shape[1]) as usize, shape[1] as usize, self.shape[1] as usize);
        let channels = self.features.len() / self.mask.len().max(1);
        let (mut features, mut mask) = (try_vec(len * channels, 0_u8)?, try_vec(len, false)?);
        for i in 0..len {
            let first = i / width * 2 * wide + i % width * 2;
            let four = [first, first + 1, first + wide, first + wide + 1];
            let known = four.iter().filter(|&&f| self.mask[f]).count() as u32;
            mask[i] = 2 <= known;
            if !mask[i] {
                continue;
            }
            for c in 0..channels {
                let plane = &self.features[c * self.mask.len()..];
                let sum: u32 = four.iter().filter(|&&f| self.mask[f]).map(|&f| u32::from(plane[f])).sum();
                features[c * len + i] = ((2 * sum + known) / (2 * known)) as u8;
            }
        }
        Ok(Self::new(shape, features, mask))
    }

    /// The weighted squared differences at a place.
    fn error(&self, exemplars: &Exemplars<2>, source: usize, at: [u32; 2]) -> u64 {
        let features = &exemplars.sources()[source].features;
        let (stride, width, first) =
            (features.domain().shape[1] as usize, self.shape[1] as usize, features.domain().index(at));
        let mut error = 0;
        for (c, &weight) in exemplars.weights().iter().enumerate() {
            let (plane, own) = (&features.plane(c)[first..], &self.features[c * self.mask.len()..]);
            let of = |row: &Range<usize>| {
                let from = row.start / width * stride + row.start % width;
                squares(&own[row.clone()], &plane[from..from + row.len()])
            };
            error += u64::from(weight) * self.rows.iter().map(of).sum::<u64>();
        }
        error
    }
}

/// The sum of squared differences of a stretch of a row: no row of an exemplar passes 32 bits.
fn squares(a: &[u8], b: &[u8]) -> u64 {
    let sum: u32 = a.iter().zip(b).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum();
    u64::from(sum)
}

#[cfg(test)]
mod tests;
