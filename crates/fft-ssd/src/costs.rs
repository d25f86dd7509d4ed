//! The answer of a search: one exact integer a position of each source.

use crate::axes::{Shape, lift, lower};
use crate::placement::Range;
use crate::{Candidate, Error};
use selvedge_core::try_vec;

/// The positions of one source in a [`Costs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Positioned<const D: usize> {
    /// The first position, slowest axis first; negative where the template may stick out.
    pub first: [i32; D],
    /// Positions along each axis; 0 where the template does not fit.
    pub shape: [u32; D],
    /// Where this source begins in the list of all positions.
    pub(crate) start: usize,
}

impl<const D: usize> Positioned<D> {
    fn new(range: &Range, start: usize) -> Self {
        Self { first: lower(range.first.map(|p| p as i32)), shape: lower(range.count.map(|n| n as u32)), start }
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
    pub(crate) sources: Vec<Positioned<D>>,
    pub(crate) narrow: Vec<u32>,
    pub(crate) wide: Vec<u64>,
    pub(crate) is_wide: bool,
    /// Compared samples at each position; empty if it is `samples` everywhere.
    pub(crate) counts: Vec<u32>,
    /// Unmasked samples of the template.
    pub(crate) samples: u64,
    /// No error is larger.
    pub(crate) bound: u64,
    /// Candidates of the last question, kept for its memory.
    pub(crate) picks: Vec<crate::candidates::Pick>,
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
            self.sources.push(Positioned::new(range, start));
            let total = range.checked_len().and_then(|n| n.checked_add(start));
            start = total.filter(|&n| n < u32::MAX as usize).ok_or(Error::TooLarge { positions: positions(ranges) })?;
        }
        (self.samples, self.bound, self.is_wide) = (samples, bound, u64::from(u32::MAX) <= bound);
        fit(&mut self.narrow, if self.is_wide { 0 } else { start })?;
        fit(&mut self.wide, if self.is_wide { start } else { 0 })?;
        fit(&mut self.counts, if counted { start } else { 0 })
    }

    /// The positions of each source, in the order of the searcher's.
    pub fn sources(&self) -> &[Positioned<D>] {
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

    /// Replaces each error by `weight * error + other_weight * other`'s at the same position; what is no candidate
    /// in either is none in the sum. Both come from templates of the same shape and placement, such as an overlap
    /// and a guide.
    ///
    /// # Errors
    /// [`Error::Mismatch`] if positions or counts differ, [`Error::Overflow`] if a sum could pass 64 bits.
    pub fn blend(&mut self, weight: u64, other: &Self, other_weight: u64) -> Result<(), Error> {
        if self.sources != other.sources || self.counts != other.counts {
            return Err(Error::Mismatch);
        }
        let bound = u128::from(weight) * u128::from(self.bound) + u128::from(other_weight) * u128::from(other.bound);
        self.bound =
            u64::try_from(bound).ok().filter(|&b| b < u64::MAX).ok_or(Error::Overflow { bound: bound as f64 })?;
        // Candidates of a sum are compared by the sum, as if all had that many samples: any number but 0.
        self.samples = self.samples.max(other.samples);
        self.widen()?;
        for (flat, error) in self.wide.iter_mut().enumerate() {
            *error = match other.error(flat) {
                Some(more) if *error != u64::MAX => weight * *error + other_weight * more,
                _ => u64::MAX,
            };
        }
        Ok(())
    }

    /// From 32-bit to 64-bit errors.
    fn widen(&mut self) -> Result<(), Error> {
        if !self.is_wide {
            fit(&mut self.wide, self.narrow.len())?;
            for (wide, &narrow) in self.wide.iter_mut().zip(&self.narrow) {
                *wide = if narrow == u32::MAX { u64::MAX } else { u64::from(narrow) };
            }
            self.narrow.clear();
            self.is_wide = true;
        }
        Ok(())
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

/// Makes a buffer `len` values long; what they are does not matter.
pub(crate) fn fit<T: Clone + Default>(buffer: &mut Vec<T>, len: usize) -> Result<(), Error> {
    if buffer.capacity() < len {
        *buffer = try_vec(len, T::default())?;
    } else {
        buffer.resize(len, T::default());
    }
    Ok(())
}
