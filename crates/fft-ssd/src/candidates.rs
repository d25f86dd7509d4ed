//! Choosing among the positions of a search: the best, the best apart from each other, all within a tolerance.

use crate::{Costs, Positioned};
use std::cmp::Ordering;

/// A place where the template may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate<const D: usize> {
    /// The source, in the order of the searcher's.
    pub source: usize,
    /// Source position of the template's first sample, slowest axis first; negative where the template sticks out.
    pub position: [i32; D],
    /// Sum of the weighted squared differences.
    pub error: u64,
    /// Samples compared.
    pub samples: u64,
}

/// How much worse than the best a candidate may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tolerance {
    /// Thousandths of the best error: `error * 1000 <= best * (1000 + per_mille)`. A tolerance of 0.1 on the norm, as
    /// in `[Efros01 2.2]`, is 210 on the squared error.
    pub per_mille: u32,
    /// The best error counts as no smaller than this (for a template compared in all its unmasked samples), so that
    /// one perfect match does not exclude all else.
    pub floor: u64,
}

impl From<u32> for Tolerance {
    fn from(per_mille: u32) -> Self {
        Self { per_mille, floor: 0 }
    }
}

/// A candidate as questions sort it: mean error, then place in the list of all positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pick {
    error: u64,
    count: u32,
    flat: u32,
}

impl Pick {
    /// By mean error, then source, then position. A mean over no samples is 0.
    fn order(&self, other: &Self) -> Ordering {
        self.by_mean(other).then(self.flat.cmp(&other.flat))
    }

    fn by_mean(&self, other: &Self) -> Ordering {
        if self.count == other.count {
            return self.error.cmp(&other.error);
        }
        let scaled = |a: &Self, b: &Self| u128::from(a.error) * u128::from(b.count);
        scaled(self, other).cmp(&scaled(other, self))
    }
}

/// All candidates within a tolerance of the best.
#[derive(Debug)]
pub struct Candidates<'c, const D: usize> {
    sources: &'c [Positioned<D>],
    picks: &'c mut [Pick],
}

impl<const D: usize> Candidates<'_, D> {
    /// How many; 0 only if there is no candidate at all.
    pub fn len(&self) -> u32 {
        self.picks.len() as u32
    }

    /// True if there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.picks.is_empty()
    }

    /// All of them, in the order of (source, position).
    pub fn iter(&self) -> impl Iterator<Item = Candidate<D>> + '_ {
        self.picks.iter().map(|&pick| candidate(self.sources, pick))
    }

    /// Number `k`, from 0, in the order of (error, source, position). Takes `O(len)` without sorting the rest.
    ///
    /// # Panics
    /// If `len <= k`.
    pub fn nth(&mut self, k: u32) -> Candidate<D> {
        let (_, &mut pick, _) = self.picks.select_nth_unstable_by(k as usize, Pick::order);
        candidate(self.sources, pick)
    }
}

fn candidate<const D: usize>(sources: &[Positioned<D>], pick: Pick) -> Candidate<D> {
    let flat = pick.flat as usize;
    let source = sources.partition_point(|s| s.start + s.len() <= flat);
    let position = sources[source].position(flat - sources[source].start);
    Candidate { source, position, error: pick.error, samples: u64::from(pick.count) }
}

impl<const D: usize> Costs<D> {
    /// The first in the order of (error, source, position); `None` if there is no candidate.
    pub fn best(&self) -> Option<Candidate<D>> {
        self.best_where(|_, _| true)
    }

    /// The best of those that `allow(source, position)` lets pass. It is asked only about positions better than all
    /// before them.
    pub fn best_where(&self, allow: impl FnMut(usize, [i32; D]) -> bool) -> Option<Candidate<D>> {
        self.best_pick(allow).map(|pick| candidate(&self.sources, pick))
    }

    /// The best, then the best of those at least `distance` samples away from it in the same source, and so on: up to
    /// `k`, best first.
    pub fn best_k(&self, k: usize, distance: u32) -> Vec<Candidate<D>> {
        let mut chosen: Vec<Candidate<D>> = Vec::new();
        while chosen.len() < k {
            let Some(next) = self.best_where(|source, position| {
                chosen.iter().all(|c| {
                    let same = c.source == source && c.position == position;
                    !same && (c.source != source || apart(c.position, position, distance))
                })
            }) else {
                break;
            };
            chosen.push(next);
        }
        chosen
    }

    /// All candidates within a tolerance of the best.
    pub fn within(&mut self, tolerance: impl Into<Tolerance>) -> Candidates<'_, D> {
        self.within_where(tolerance, |_, _| true)
    }

    /// Of the positions that `allow(source, position)` lets pass, all within a tolerance of the best of them.
    pub fn within_where(
        &mut self,
        tolerance: impl Into<Tolerance>,
        mut allow: impl FnMut(usize, [i32; D]) -> bool,
    ) -> Candidates<'_, D> {
        let mut picks = std::mem::take(&mut self.picks);
        picks.clear();
        if let Some(best) = self.best_pick(&mut allow) {
            let tolerance = tolerance.into();
            let floor = Pick { error: tolerance.floor, count: self.samples as u32, flat: 0 };
            let best = if best.by_mean(&floor).is_lt() { floor } else { best };
            self.collect(best, tolerance.per_mille, allow, &mut picks);
        }
        self.picks = picks;
        Candidates { sources: &self.sources, picks: &mut self.picks }
    }

    /// Every candidate, in the order of (source, position).
    pub fn iter(&self) -> impl Iterator<Item = Candidate<D>> + '_ {
        (0..self.len()).filter_map(|flat| self.pick(flat)).map(|pick| candidate(&self.sources, pick))
    }

    fn pick(&self, flat: usize) -> Option<Pick> {
        self.error(flat).map(|error| Pick { error, count: self.count(flat), flat: flat as u32 })
    }

    fn best_pick(&self, mut allow: impl FnMut(usize, [i32; D]) -> bool) -> Option<Pick> {
        let mut best: Option<Pick> = None;
        self.promising(
            |best: &Option<Pick>, least| best.is_none_or(|b| least < b.error),
            &mut best,
            |best, number, source, pick| {
                let better = best.is_none_or(|b| pick.by_mean(&b).is_lt());
                if better && allow(number, source.position(pick.flat as usize - source.start)) {
                    *best = Some(pick);
                }
            },
        );
        best
    }

    fn collect(
        &self,
        best: Pick,
        per_mille: u32,
        mut allow: impl FnMut(usize, [i32; D]) -> bool,
        picks: &mut Vec<Pick>,
    ) {
        let limit = u128::from(best.error) * (1000 + u128::from(per_mille));
        let most = u64::try_from(limit / 1000).unwrap_or(u64::MAX);
        let near =
            |pick: &Pick| u128::from(pick.error) * u128::from(best.count) * 1000 <= limit * u128::from(pick.count);
        self.promising(
            |_, error| error <= most,
            picks,
            |picks, number, source, pick| {
                if near(&pick) && allow(number, source.position(pick.flat as usize - source.start)) {
                    picks.push(pick);
                }
            },
        );
    }

    /// Calls `each(state, number of the source, source, pick)` for the candidates whose error `may` be of interest, passing
    /// over runs of positions whose least is not; for all candidates where the number of compared samples differs.
    fn promising<S>(
        &self,
        may: impl Fn(&S, u64) -> bool,
        state: &mut S,
        mut each: impl FnMut(&mut S, usize, &Positioned<D>, Pick),
    ) {
        for (number, source) in self.sources.iter().enumerate() {
            let end = source.start + source.len();
            for start in (source.start..end).step_by(RUN) {
                let run = start..end.min(start + RUN);
                let least = if self.is_wide {
                    self.kernel.least(&self.wide[run.clone()])
                } else {
                    self.kernel.least(&self.narrow[run.clone()]).into()
                };
                let differ = !self.counts.is_empty();
                if differ || may(state, least) {
                    for pick in run.filter_map(|flat| self.pick(flat)) {
                        if differ || may(state, pick.error) {
                            each(state, number, source, pick);
                        }
                    }
                }
            }
        }
    }
}

/// Positions that are looked at together: their least error mostly tells that none of them matters.
const RUN: usize = 128;

/// True if two positions are at least `distance` samples apart, as the crow flies.
fn apart<const D: usize>(a: [i32; D], b: [i32; D], distance: u32) -> bool {
    let squared: u64 = (0..D).map(|axis| u64::from(a[axis].abs_diff(b[axis])).pow(2)).sum();
    u64::from(distance).pow(2) <= squared
}
