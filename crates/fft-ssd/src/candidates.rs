//! Choosing among the positions of a search: the best, all within a tolerance.

use crate::memory::{refill, reserve};
use crate::pick::{Pick, Run};
use crate::{Candidate, Costs, Error, PositionGrid};

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

/// All candidates within a tolerance of the best.
#[derive(Debug)]
pub struct Candidates<'c, const D: usize> {
    sources: &'c [PositionGrid<D>],
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

pub(crate) fn candidate<const D: usize>(sources: &[PositionGrid<D>], pick: Pick) -> Candidate<D> {
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
        self.best_pick(self.runs(), allow).map(|pick| candidate(&self.sources, pick))
    }

    /// All candidates within a tolerance of the best.
    ///
    /// Takes `O(positions)`, most of it for one look at each of them, and 16 bytes a candidate found.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn within(&mut self, tolerance: impl Into<Tolerance>) -> Result<Candidates<'_, D>, Error> {
        self.within_where(tolerance, |_, _| true)
    }

    /// Of the positions that `allow(source, position)` lets pass, all within a tolerance of the best of them.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn within_where(
        &mut self,
        tolerance: impl Into<Tolerance>,
        allow: impl FnMut(usize, [i32; D]) -> bool,
    ) -> Result<Candidates<'_, D>, Error> {
        let tolerance = tolerance.into();
        self.within_of_best(|_| tolerance, allow)
    }

    /// The same with a tolerance that depends on which is the best.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn within_of_best(
        &mut self,
        tolerance: impl FnOnce(&Candidate<D>) -> Tolerance,
        mut allow: impl FnMut(usize, [i32; D]) -> bool,
    ) -> Result<Candidates<'_, D>, Error> {
        let (mut picks, mut runs) = (std::mem::take(&mut self.picks), std::mem::take(&mut self.runs));
        picks.clear();
        let found = self.find(tolerance, &mut allow, &mut picks, &mut runs);
        (self.picks, self.runs) = (picks, runs);
        found.map(|()| Candidates { sources: &self.sources, picks: &mut self.picks })
    }

    /// Every candidate, in the order of (source, position).
    pub fn iter(&self) -> impl Iterator<Item = Candidate<D>> + '_ {
        (0..self.len()).filter_map(|flat| self.pick(flat)).map(|pick| candidate(&self.sources, pick))
    }

    pub(crate) fn pick(&self, flat: usize) -> Option<Pick> {
        self.error(flat).map(|error| Pick { error, count: self.count(flat), flat: flat as u32 })
    }

    /// Runs of positions of one source, each with its least error.
    pub(crate) fn runs(&self) -> impl Iterator<Item = Run> {
        let run = |source: usize, start: usize, end: usize| {
            let least = if self.is_wide {
                self.kernel.least(&self.wide[start..end])
            } else {
                self.kernel.least(&self.narrow[start..end]).into()
            };
            Run { source: source as u32, start: start as u32, end: end as u32, least }
        };
        self.sources.iter().enumerate().flat_map(move |(number, source)| {
            let end = source.start + source.len();
            (source.start..end).step_by(RUN).map(move |start| run(number, start, end.min(start + RUN)))
        })
    }

    /// Collects what [`within_of_best`](Self::within_of_best) answers with.
    fn find(
        &self,
        tolerance: impl FnOnce(&Candidate<D>) -> Tolerance,
        mut allow: impl FnMut(usize, [i32; D]) -> bool,
        picks: &mut Vec<Pick>,
        runs: &mut Vec<Run>,
    ) -> Result<(), Error> {
        refill(runs, self.runs())?;
        let Some(best) = self.best_pick(runs.iter().copied(), &mut allow) else { return Ok(()) };
        let tolerance = tolerance(&candidate(&self.sources, best));
        let floor = Pick { error: tolerance.floor, count: self.samples as u32, flat: 0 };
        let best = if best.by_mean(&floor).is_lt() { floor } else { best };

        let limit = u128::from(best.error) * (1000 + u128::from(tolerance.per_mille));
        let most = u64::try_from(limit / 1000).unwrap_or(u64::MAX);
        let near =
            |pick: &Pick| u128::from(pick.error) * u128::from(best.count) * 1000 <= limit * u128::from(pick.count);
        let differ = !self.counts.is_empty();
        for run in runs.iter().filter(|run| differ || run.least <= most) {
            let (number, source) = (run.source as usize, &self.sources[run.source as usize]);
            let mut allowed = |flat: usize| allow(number, source.position(flat - source.start));
            reserve(picks, run.places().len())?;
            if differ {
                let all = run.places().filter_map(|flat| self.pick(flat));
                picks.extend(all.filter(|pick| near(pick) && allowed(pick.flat as usize)));
                continue;
            }
            // With equal counts, an error that is near is one of at most `most`, and what is no candidate is none.
            let mut look = |flat: usize, error: u64| {
                if error <= most && allowed(flat) {
                    picks.extend(self.pick(flat));
                }
            };
            if self.is_wide {
                run.places().zip(&self.wide[run.places()]).for_each(|(flat, &e)| look(flat, e));
            } else {
                run.places().zip(&self.narrow[run.places()]).for_each(|(flat, &e)| look(flat, e.into()));
            }
        }
        Ok(())
    }

    /// The best that is allowed, passing over runs whose least error is no better; nothing is passed over where the
    /// number of compared samples differs.
    fn best_pick(
        &self,
        runs: impl Iterator<Item = Run>,
        mut allow: impl FnMut(usize, [i32; D]) -> bool,
    ) -> Option<Pick> {
        let differ = !self.counts.is_empty();
        let mut best: Option<Pick> = None;
        for run in runs {
            if !differ && best.is_some_and(|b| b.error <= run.least) {
                continue;
            }
            let (number, source) = (run.source as usize, &self.sources[run.source as usize]);
            for pick in run.places().filter_map(|flat| self.pick(flat)) {
                let better = best.is_none_or(|b| pick.by_mean(&b).is_lt());
                if better && allow(number, source.position(pick.flat as usize - source.start)) {
                    best = Some(pick);
                }
            }
        }
        best
    }
}

/// Positions that are looked at together: their least error mostly tells that none of them matters.
const RUN: usize = 64;
