//! Which jumps promise most. `[Schodl00]`

use std::cell::RefCell;
use std::cmp::Reverse;
use std::ops::RangeInclusive;

use selvedge_core::{Error as CoreError, Run, par, try_vec};

use super::bounds::Ordered;
use super::distances::FrameDistances;
use crate::error::Error;

/// After one frame comes an earlier one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The last frame before the jump.
    pub from: u32,
    /// The first frame after it, no later than `from`.
    pub to: u32,
    /// How much the frames around it differ: mean squared difference a pixel, channels weighed and summed.
    pub error: f64,
}

impl Jump {
    /// Frames of the loop that it makes.
    ///
    /// # Panics
    /// If it leads forward.
    pub fn period(&self) -> u32 {
        assert!(self.to <= self.from, "a jump from frame {} to the later {}", self.from, self.to);
        self.from - self.to + 1
    }

    /// Refuses one that is not in a clip of so many frames.
    ///
    /// # Errors
    /// [`Error::Jump`].
    pub fn check(&self, frames: u32) -> Result<(), Error> {
        let Self { from, to, .. } = *self;
        if from < to || frames <= from { Err(Error::Jump { from, to, frames }) } else { Ok(()) }
    }
}

/// Options of [`FrameDistances::best`].
#[derive(Clone, Debug, PartialEq)]
pub struct JumpOptions {
    /// Jumps that are answered, at most. At least 1. Default: 24, three times those that are cut in any case.
    pub count: usize,
    /// Pairs of frames around a jump that have to agree, so that movements go on: 2 or 4, binomially weighed, or 1 for
    /// the jump itself. Default: 4.
    pub taps: u32,
    /// Frames that the loop may have, from 2. Default: from a third of the clip's on: shorter ones are cheaper, and are
    /// seen to come again.
    pub period: Option<RangeInclusive<u32>>,
    /// No two jumps leave, and arrive, less than so many frames from each other. At least 1. Default: 4.
    pub spread: u32,
}

impl Default for JumpOptions {
    fn default() -> Self {
        Self { count: 24, taps: 4, period: None, spread: 4 }
    }
}

impl JumpOptions {
    /// Frames that a loop may have in a clip of so many.
    ///
    /// # Errors
    /// Those of [`FrameDistances::best`].
    pub fn periods(&self, frames: u32) -> Result<RangeInclusive<u32>, Error> {
        for (option, value) in [("count", self.count as u64), ("spread", self.spread.into())] {
            if value == 0 {
                return Err(CoreError::range(option, 0.0, "at least 1").into());
            }
        }
        if ![1, 2, 4].contains(&self.taps) {
            return Err(CoreError::range("taps", self.taps, "1, 2 or 4").into());
        }
        let Some(asked) = &self.period else { return Ok(frames.div_ceil(3).max(2)..=frames) };
        let (least, most) = (*asked.start(), *asked.end());
        if least < 2 || most < least {
            let value = if least < 2 { least } else { most };
            return Err(CoreError::range("period", value, "at least 2, the least first").into());
        }
        if frames < least {
            return Err(Error::Period { period: least, frames });
        }
        Ok(least..=most.min(frames))
    }
}

impl FrameDistances<'_> {
    /// The jumps whose surroundings agree best, the best first.
    ///
    /// A jump from `i` to `j` is good if what would have come, `i + 1`, is like what comes, `j`, and the frames beside
    /// them alike in the same order: so what moves goes on moving as it did. At the clip's ends the pairs that there
    /// are decide. The jump over the whole clip has none; it is answered where the clip [closes](Self::closes), and
    /// where no other is possible. A clip that [repeats](Self::repeats) itself is answered with its period, and no
    /// other jump.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range); [`Error::Period`] if the clip is shorter than the least period;
    /// [`Error::Cancelled`], and too little memory.
    ///
    /// # Complexity
    /// `O(frames^2)`, and `O(log(frames))` for each jump that is as good as those that are answered; where frames are
    /// compared when that is asked for, the pairs around each of these, each once, on the caller's pool.
    pub fn best(&self, options: &JumpOptions, run: &Run<'_, 3>) -> Result<Vec<Jump>, Error> {
        let periods = options.periods(self.frames())?;
        let whole = Jump { from: self.frames() - 1, to: 0, error: self.mean(self.between(self.frames() - 1, 0), 1) };
        if let Some(period) = periods.clone().find(|&period| self.repeats(period)) {
            return Ok(vec![Jump { from: period - 1, to: 0, error: 0.0 }]);
        }
        if self.closes() && periods.contains(&self.frames()) {
            return Ok(vec![whole]);
        }
        let count = periods.clone().map(|period| (self.frames() - period + 1) as usize).sum();
        let jumps = periods.flat_map(|period| (0..=self.frames() - period).map(move |to| (to + period - 1, to)));
        // Of equal ones the longest loop, and of these the first.
        let least = |from, to| self.score([from, to], options.taps, &|a, b| self.least(a, b));
        let bounds = jumps.filter_map(|(from, to)| Some((least(from, to)?, (Reverse(from - to + 1), to))));
        let (mut ordered, mut known) = (Ordered::new(count, bounds)?, Known::of(self));
        let mut error = |&(Reverse(period), to): &(Reverse<u32>, u32)| {
            if run.observer.cancelled() {
                return Err(Error::Cancelled);
            }
            known.score([to + period - 1, to], options.taps)
        };
        let mut best: Vec<Jump> = Vec::new();
        while best.len() < options.count {
            let apart = |&(Reverse(period), to): &(Reverse<u32>, u32)| {
                let near = |a: u32, b: u32| a.abs_diff(b) < options.spread;
                !best.iter().any(|other| near(other.from, to + period - 1) && near(other.to, to))
            };
            let Some((error, (Reverse(period), to))) = ordered.next(apart, &mut error)? else { break };
            best.push(Jump { from: to + period - 1, to, error });
        }
        Ok(if best.is_empty() { vec![whole] } else { best })
    }

    /// The mean error of the pairs around a jump, of distances or of what is less; `None` without any.
    fn score(&self, [from, to]: [u32; 2], taps: u32, between: &dyn Fn(u32, u32) -> u64) -> Option<f64> {
        let weights: &[u64] = match taps {
            1 => &[1],
            2 => &[1, 1],
            _ => &[1, 3, 3, 1],
        };
        // The pair of the jump itself is the first of the later half.
        let before = (weights.len() / 2) as i64;
        let (mut sum, mut weight) = (0, 0);
        for (&w, k) in weights.iter().zip(-before..) {
            let [a, b] = [from + 1, to].map(|frame| i64::from(frame) + k);
            if 0 <= b && a < i64::from(self.frames()) {
                (sum, weight) = (sum + w * between(a as u32, b as u32), weight + w);
            }
        }
        if weight == 0 && taps == 1 && 0 < to {
            return Some(self.mean(between(from, to - 1), 1));
        }
        (0 < weight).then(|| self.mean(sum, weight))
    }

    fn mean(&self, sum: u64, weight: u64) -> f64 {
        sum as f64 / (weight * self.pixels()) as f64
    }
}

/// Distances that are exact, of which each is computed once: beside a jump most are those of its neighbours.
struct Known<'d, 'c> {
    distances: &'d FrameDistances<'c>,
    /// For each frame its distances to all later ones, once one of them was asked for.
    later: Vec<Vec<u64>>,
}

impl<'d, 'c> Known<'d, 'c> {
    /// More than two frames differ by.
    const UNKNOWN: u64 = u64::MAX;

    fn of(distances: &'d FrameDistances<'c>) -> Self {
        let rows = if distances.is_bounded() { distances.frames() } else { 0 };
        Self { distances, later: vec![Vec::new(); rows as usize] }
    }

    /// The error of a jump that has a bound.
    fn score(&mut self, jump: [u32; 2], taps: u32) -> Result<f64, Error> {
        self.compare(jump, taps)?;
        let score = self.distances.score(jump, taps, &|a, b| self.between(a, b));
        Ok(score.expect("what has a bound has a value"))
    }

    /// Compares the frames around a jump that were not compared.
    fn compare(&mut self, jump: [u32; 2], taps: u32) -> Result<(), Error> {
        if self.later.is_empty() {
            return Ok(());
        }
        let pairs = RefCell::new(Vec::new());
        self.distances.score(jump, taps, &|a, b| {
            pairs.borrow_mut().push((a.min(b), a.max(b)));
            0
        });
        let mut pairs = pairs.into_inner();
        pairs.retain(|&(a, b)| a != b && self.exact(a, b).is_none());
        let found = par::map_indexed(pairs.len(), |i| self.distances.between(pairs[i].0, pairs[i].1));
        for ((a, b), found) in pairs.into_iter().zip(found) {
            let row = &mut self.later[a as usize];
            if row.is_empty() {
                *row = try_vec((self.distances.frames() - 1 - a) as usize, Self::UNKNOWN)?;
            }
            row[(b - a - 1) as usize] = found;
        }
        Ok(())
    }

    /// What was compared of an earlier and a later frame.
    fn exact(&self, a: u32, b: u32) -> Option<u64> {
        let row = self.later.get(a as usize)?;
        row.get((b - a) as usize - 1).copied().filter(|&known| known != Self::UNKNOWN)
    }

    fn between(&self, a: u32, b: u32) -> u64 {
        let known = if a == b { None } else { self.exact(a.min(b), a.max(b)) };
        known.unwrap_or_else(|| self.distances.least(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::video::DistanceOptions;
    use selvedge_core::{Domain, Exemplars, Grid, Observer, Origin, Run, Seed, Source, Transform};

    /// A clip of one pixel, and what it shows.
    fn clip(seed: u64) -> (Vec<f64>, Exemplars<3>) {
        let mut rng = Seed(seed).rng();
        let values: Vec<u8> = (0..14).map(|_| rng.below(256) as u8).collect();
        let shown = values.iter().map(|&v| f64::from(v)).collect();
        let features = Grid::from_vec(Domain::open([14, 1, 1]), 1, values).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        (shown, exemplars)
    }

    #[test]
    fn nobody_compares_once_it_is_cancelled() {
        struct Cancelled;
        impl Observer<3> for Cancelled {
            fn cancelled(&self) -> bool {
                true
            }
        }
        let (_, exemplars) = clip(1);
        let distances = FrameDistances::new(&exemplars, &DistanceOptions::default(), &Run::seeded(0)).unwrap();
        let options = JumpOptions { period: Some(4..=9), ..JumpOptions::default() };
        assert!(!distances.best(&options, &Run::seeded(0)).unwrap().is_empty());
        let run = Run { observer: &Cancelled, ..Run::seeded(0) };
        assert!(matches!(distances.best(&options, &run), Err(Error::Cancelled)));
    }

    #[test]
    fn jumps_are_ranked_by_the_frames_around_them_and_lie_apart() {
        for seed in 0..30 {
            let (shown, exemplars) = clip(seed);
            let distances = FrameDistances::new(&exemplars, &DistanceOptions::default(), &Run::seeded(0)).unwrap();
            // The frame that would follow is compared with the one that does, and so on before and after.
            let score = |from: u32, to: u32| {
                let (mut sum, mut weight) = (0.0, 0.0);
                for (k, w) in [(-2, 1.0), (-1, 3.0), (0, 3.0), (1, 1.0)] {
                    let [a, b] = [from + 1, to].map(|frame| shown.get((frame as i32 + k) as usize));
                    if let (Some(a), Some(b)) = (a, b) {
                        (sum, weight) = (sum + w * (a - b) * (a - b), weight + w);
                    }
                }
                sum / weight
            };
            let options = JumpOptions { count: 5, spread: 3, period: Some(4..=9), ..JumpOptions::default() };
            let mut all: Vec<Jump> = (4..=9)
                .flat_map(|period| (0..=14 - period).map(move |to| (to + period - 1, to)))
                .map(|(from, to)| Jump { from, to, error: score(from, to) })
                .collect();
            // Of jumps as good as each other the longer loop, then the earlier.
            all.sort_by_key(|jump| (Reverse(jump.period()), jump.to));
            all.sort_by(|a, b| a.error.total_cmp(&b.error));
            let mut expected: Vec<Jump> = Vec::new();
            for jump in all {
                let apart = |o: &Jump| 3 <= o.from.abs_diff(jump.from) || 3 <= o.to.abs_diff(jump.to);
                if expected.len() < 5 && expected.iter().all(apart) {
                    expected.push(jump);
                }
            }
            let found = distances.best(&options, &Run::seeded(0)).unwrap();
            let places = |jumps: &[Jump]| jumps.iter().map(|j| (j.from, j.to)).collect::<Vec<_>>();
            assert_eq!(places(&found), places(&expected), "seed {seed}");
            assert!(found.iter().zip(&expected).all(|(f, e)| (f.error - e.error).abs() < 1e-9));
        }
    }
}
