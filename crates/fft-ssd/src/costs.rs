//! The answer of a search: one exact integer a position of each source.

use crate::axes::{Shape, lift, lower};
use crate::kernel::Kernel;
use crate::memory::{fit, push, refill};
use crate::placement::Range;
use crate::{Candidate, Error};
use selvedge_core::par;

/// Positions that are summed together: few enough to stay near the processor.
const TOGETHER: usize = 1 << 12;

/// The positions of one source in a [`Costs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionGrid<const D: usize> {
    /// The first position, slowest axis first; negative where the template may stick out.
    pub first: [i32; D],
    /// Positions along each axis; 0 where the template does not fit.
    pub shape: [u32; D],
    /// Where this source begins in the list of all positions.
    pub(crate) start: usize,
    /// Axes on which the first position follows the last.
    pub(crate) wraps: [bool; D],
}

impl<const D: usize> PositionGrid<D> {
    fn new(range: &Range, start: usize) -> Self {
        let (first, shape) = (range.first.map(|p| p as i32), range.count.map(|n| n as u32));
        Self { first: lower(first), shape: lower(shape), start, wraps: lower(range.wraps) }
    }

    /// Positions in all.
    pub fn len(&self) -> usize {
        self.shape.iter().map(|&n| n as usize).product()
    }

    /// True if the template fits nowhere in this source.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn position(&self, index: usize) -> [i32; D] {
        let shape: Shape = lift(self.shape.map(|n| n as usize), 1);
        let at: [usize; D] = lower(crate::axes::position(shape, index));
        std::array::from_fn(|axis| self.first[axis] + at[axis] as i32)
    }

    fn index(&self, position: [i32; D]) -> Option<usize> {
        let mut index = 0;
        for ((&at, &first), &count) in position.iter().zip(&self.first).zip(&self.shape) {
            let at = i64::from(at) - i64::from(first);
            if at < 0 || i64::from(count) <= at {
                return None;
            }
            index = index * count as usize + at as usize;
        }
        Some(index)
    }
}

/// The errors of one source, row-major over its positions; the type's largest value marks what is no candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errors<'c> {
    /// Every possible error is below `u32::MAX`.
    Narrow(&'c [u32]),
    /// Some could pass 32 bits.
    Wide(&'c [u64]),
}

/// What a search answers: the error of every position of every source. One value serves many searches; its buffers
/// are kept.
///
/// # Units of the cost
/// The error at a position is the sum of `W_c * (template - source)^2` over all compared samples and channels, an exact
/// integer in squared 8-bit steps times the exemplars' weights. Only under [`Cover::AtLeast`](crate::Cover::AtLeast)
/// does the number of compared samples differ between positions; candidates are then ordered by their mean.
#[derive(Clone, Debug, Default)]
pub struct Costs<const D: usize> {
    pub(crate) sources: Vec<PositionGrid<D>>,
    pub(crate) narrow: Vec<u32>,
    pub(crate) wide: Vec<u64>,
    pub(crate) is_wide: bool,
    /// Compared samples at each position; empty if it is `samples` everywhere.
    pub(crate) counts: Vec<u32>,
    /// Unmasked samples of the template.
    pub(crate) samples: u64,
    /// No error is larger.
    pub(crate) bound: u64,
    /// What looks through them.
    pub(crate) kernel: Kernel,
    /// Candidates of the last question, kept for its memory.
    pub(crate) picks: Vec<crate::pick::Pick>,
    pub(crate) runs: Vec<crate::pick::Run>,
}

impl<const D: usize> Costs<D> {
    /// No costs yet; buffers grow with the first search.
    pub fn new() -> Self {
        Self::default()
    }

    /// Prepares for a search, which writes every position of every source.
    pub(crate) fn reset(&mut self, ranges: &[Range], samples: u64, bound: u128, counted: bool) -> Result<(), Error> {
        let bound = u64::try_from(bound).map_err(|_| Error::Overflow { bound: bound as f64 })?;
        let mut start = 0_usize;
        self.sources.clear();
        for range in ranges {
            push(&mut self.sources, PositionGrid::new(range, start))?;
            let total = range.checked_len().and_then(|n| n.checked_add(start));
            start = total.filter(|&n| n < u32::MAX as usize).ok_or(Error::TooLarge { positions: positions(ranges) })?;
        }
        (self.samples, self.bound, self.is_wide) = (samples, bound, u64::from(u32::MAX) <= bound);
        fit(&mut self.narrow, if self.is_wide { 0 } else { start })?;
        fit(&mut self.wide, if self.is_wide { start } else { 0 })?;
        fit(&mut self.counts, if counted { start } else { 0 })
    }

    /// Prepares for a sum of searches; its errors are taken as wide ones.
    pub(crate) fn reset_sum(
        &mut self,
        ranges: &[Range],
        samples: u64,
        bound: u128,
        kernel: Kernel,
    ) -> Result<(), Error> {
        if u128::from(u64::MAX) <= bound {
            return Err(Error::Overflow { bound: bound as f64 });
        }
        self.kernel = kernel;
        self.reset(ranges, samples, bound.max(u32::MAX.into()), false)
    }

    /// The sums of one source.
    pub(crate) fn sum_mut(&mut self, source: usize) -> &mut [u64] {
        let s = &self.sources[source];
        &mut self.wide[s.start..s.start + s.len()]
    }

    /// The positions of each source, in the order of the searcher's.
    pub fn sources(&self) -> &[PositionGrid<D>] {
        &self.sources
    }

    /// The errors of one source.
    ///
    /// # Panics
    /// If `source` is not less than the number of sources.
    pub fn errors(&self, source: usize) -> Errors<'_> {
        let s = &self.sources[source];
        let range = s.start..s.start + s.len();
        if self.is_wide { Errors::Wide(&self.wide[range]) } else { Errors::Narrow(&self.narrow[range]) }
    }

    /// Compared samples at each position of one source; `None` if it is the same everywhere.
    ///
    /// # Panics
    /// If `source` is not less than the number of sources.
    pub fn counts(&self, source: usize) -> Option<&[u32]> {
        let s = &self.sources[source];
        (!self.counts.is_empty()).then(|| &self.counts[s.start..s.start + s.len()])
    }

    /// The candidate at a position; `None` if it is none or was not asked for.
    pub fn get(&self, source: usize, position: [i32; D]) -> Option<Candidate<D>> {
        let s = self.sources.get(source)?;
        let flat = s.start + s.index(position)?;
        Some(Candidate { source, position, error: self.error(flat)?, samples: u64::from(self.count(flat)) })
    }

    /// Becomes the weighted sum of other costs: at each position the sum of `weight * error`. What is no candidate in
    /// one of them is none in the sum. All come from templates of the same shape and placement, such as an overlap and
    /// a guide.
    ///
    /// # Errors
    /// [`Error::Mismatch`] if positions or counts differ, [`Error::Overflow`] if a sum could pass 64 bits.
    pub fn sum_of(&mut self, terms: &[(u64, &Self)]) -> Result<(), Error> {
        let Some((_, first)) = terms.first() else { return self.reset(&[], 0, 0, false) };
        if terms.iter().any(|(_, t)| t.sources != first.sources || t.counts != first.counts) {
            return Err(Error::Mismatch);
        }
        let bound = terms.iter().map(|&(weight, t)| u128::from(weight) * u128::from(t.bound)).sum::<u128>();
        self.bound =
            u64::try_from(bound).ok().filter(|&b| b < u64::MAX).ok_or(Error::Overflow { bound: bound as f64 })?;
        refill(&mut self.sources, first.sources.iter().copied())?;
        fit(&mut self.counts, first.counts.len())?;
        self.counts.copy_from_slice(&first.counts);
        // Masks may differ: the sum is compared as if all had as many samples as the largest.
        self.samples = terms.iter().map(|(_, t)| t.samples).max().unwrap_or(0);
        self.kernel = first.kernel;
        self.is_wide = true;
        self.narrow.clear();
        fit(&mut self.wide, first.len())?;
        par::for_rows(&mut self.wide, TOGETHER, |number, to| {
            let range = number * TOGETHER..number * TOGETHER + to.len();
            to.fill(0);
            terms.iter().for_each(|(weight, term)| term.add_to(to, range.clone(), *weight));
            terms.iter().for_each(|(_, term)| term.exclude_from(to, range.clone()));
        });
        Ok(())
    }

    /// Adds some errors, whatever stands where there is no candidate.
    fn add_to(&self, to: &mut [u64], range: std::ops::Range<usize>, weight: u64) {
        if self.is_wide {
            to.iter_mut().zip(&self.wide[range]).for_each(|(to, &e)| *to = to.wrapping_add(weight.wrapping_mul(e)));
        } else if let Ok(weight) = u32::try_from(weight) {
            self.kernel.add(to, &self.narrow[range], weight);
        } else {
            let add = |(to, &e): (&mut u64, &u32)| *to = to.wrapping_add(weight.wrapping_mul(e.into()));
            to.iter_mut().zip(&self.narrow[range]).for_each(add);
        }
    }

    /// Marks what is no candidate.
    fn exclude_from(&self, to: &mut [u64], range: std::ops::Range<usize>) {
        let none = |flat: usize| self.error(flat).is_none();
        let any = if self.is_wide {
            self.wide[range.clone()].contains(&u64::MAX)
        } else {
            self.narrow[range.clone()].contains(&u32::MAX)
        };
        if any {
            to.iter_mut().zip(range).filter(|&(_, flat)| none(flat)).for_each(|(to, _)| *to = u64::MAX);
        }
    }

    /// Positions of all sources.
    pub fn len(&self) -> usize {
        if self.is_wide { self.wide.len() } else { self.narrow.len() }
    }

    /// True before the first search, and if the template fits into no source.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The error at a place in the list of all positions; `None` if it is no candidate.
    #[inline]
    pub(crate) fn error(&self, flat: usize) -> Option<u64> {
        if self.is_wide {
            Some(self.wide[flat]).filter(|&e| e != u64::MAX)
        } else {
            Some(self.narrow[flat]).filter(|&e| e != u32::MAX).map(u64::from)
        }
    }

    #[inline]
    pub(crate) fn count(&self, flat: usize) -> u32 {
        if self.counts.is_empty() { self.samples as u32 } else { self.counts[flat] }
    }
}

fn positions(ranges: &[Range]) -> u64 {
    let of = |r: &Range| r.count.iter().fold(1_u64, |n, &c| n.saturating_mul(c as u64));
    ranges.iter().map(of).fold(0, u64::saturating_add)
}
