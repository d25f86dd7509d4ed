//! How often each part of the exemplars was used, so that blocks spread over all of them.
//!
//! The best block is often the same one again: an output then shows a few places of its exemplar over and over, while
//! others are never seen. So the error of a block counts more where its place was used more often than the mean. That
//! is the mean of its own source: of several exemplars that are unlike each other, none is forced upon the output.

use selvedge_core::{Exemplars, Rng, try_vec};

use crate::options::Error;
use crate::search::Candidate;

/// Most that is added to an error, in thousandths of it: no block is drawn for its rareness that is twice as bad as
/// the best, but for the tolerance.
const MOST: u64 = 1000;

/// Places along a block: uses are counted by quarters of it.
const PLACES: u32 = 4;

/// Numbers of uses of all places.
pub(crate) struct Usage {
    /// Thousandths that are added to an error where the uses are twice as many as in the mean.
    spread: u64,
    /// Side of a place in samples.
    side: u32,
    sources: Vec<Uses>,
}

/// Uses of blocks by the place of their top left sample in one source.
struct Uses {
    shape: [u32; 2],
    uses: Vec<u32>,
    total: u64,
}

impl Usage {
    /// No uses of blocks of that side.
    pub(crate) fn new(exemplars: &Exemplars<2>, block: u32, spread: f64) -> Result<Self, Error> {
        let side = block.div_ceil(PLACES).max(1);
        let uses = |shape: [u32; 2]| {
            let shape = shape.map(|len| (len.saturating_sub(block) + 1).div_ceil(side));
            let uses = try_vec(shape[0] as usize * shape[1] as usize, 0)?;
            Ok(Uses { shape, uses, total: 0 })
        };
        let sources = exemplars.sources().iter().map(|s| uses(s.domain().shape)).collect::<Result<_, Error>>()?;
        Ok(Self { spread: (spread * 1000.0).round() as u64, side, sources })
    }

    /// True if no place is rarer than another.
    pub(crate) fn is_even(&self) -> bool {
        self.spread == 0 || self.sources.iter().all(|s| s.total == 0)
    }

    /// The tolerance within which candidates are looked at, for one of `per_mille` on what they count, where this is the
    /// one of least error: none counts less than its error, and the least counts no more than this one. So nothing that
    /// could be drawn is left out, but for a least error of 0: no tolerance widens that, and perfect candidates are
    /// drawn among themselves alone.
    pub(crate) fn widened(&self, per_mille: u32, best: &Candidate) -> u32 {
        let added = if self.spread == 0 { 0 } else { self.added(best) };
        ((1000 + u64::from(per_mille)) * (1000 + added)).div_ceil(1000) as u32 - 1000
    }

    /// Of the candidates that count at most `1 + per_mille / 1000` times the least, one by a uniform draw; and how many there
    /// were. `None` if there are no candidates. They come in the order of source and position.
    pub(crate) fn draw(&self, candidates: &[Candidate], per_mille: u32, rng: &mut Rng) -> Option<(Candidate, u32)> {
        let least = candidates.iter().map(|c| self.counted(c)).min()?;
        let limit = least * (1000 + u128::from(per_mille));
        let near = || candidates.iter().filter(|c| self.counted(c) * 1000 <= limit);
        let n = near().count() as u32;
        near().nth(rng.below(n) as usize).map(|&chosen| (chosen, n))
    }

    /// What a candidate's error counts, in thousandths.
    fn counted(&self, candidate: &Candidate) -> u128 {
        if self.spread == 0 {
            return u128::from(candidate.error) * 1000;
        }
        // Among perfect candidates, too, the rarer ones are better.
        u128::from(candidate.error.max(1)) * u128::from(1000 + self.added(candidate))
    }

    /// Thousandths that are added to the error: the uses of its place beyond the mean, against the mean. Every place
    /// counts one use more in the mean, so that it is never 0.
    fn added(&self, candidate: &Candidate) -> u64 {
        let [y, x] = self.place(candidate);
        let Uses { shape, uses, total } = &self.sources[candidate.source];
        let (places, uses) = (uses.len() as u64, u64::from(uses[y as usize * shape[1] as usize + x as usize]));
        (self.spread * (uses * places).saturating_sub(*total) / (places + total)).min(MOST)
    }

    /// Blocks about half a block away from the chosen one share much of it: they count as used, too.
    pub(crate) fn note(&mut self, chosen: &Candidate) {
        if self.spread == 0 {
            return;
        }
        let [y, x] = self.place(chosen);
        let Uses { shape, uses, total } = &mut self.sources[chosen.source];
        let around = |p: u32, n: u32| p.saturating_sub(PLACES / 2)..(p + PLACES / 2 + 1).min(n);
        for y in around(y, shape[0]) {
            for x in around(x, shape[1]) {
                uses[y as usize * shape[1] as usize + x as usize] += 1;
                *total += 1;
            }
        }
    }

    fn place(&self, candidate: &Candidate) -> [u32; 2] {
        let shape = self.sources[candidate.source].shape;
        // Blocks that are cropped at the output's border may begin beyond the last whole one.
        [0, 1].map(|axis| (candidate.at[axis] / self.side).min(shape[axis] - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    fn usage(spread: f64) -> Usage {
        let source = |exemplar, shape| Source {
            features: Grid::try_filled(Domain::open(shape), 1, 0).unwrap(),
            valid: None,
            origin: Origin { exemplar, transform: Transform::IDENTITY },
        };
        let sources = vec![source(0, [40, 30]), source(1, [20, 5])];
        Usage::new(&Exemplars::from_sources(sources, vec![1]).unwrap(), 8, spread).unwrap()
    }

    fn candidate(error: u64, at: [u32; 2]) -> Candidate {
        Candidate { error, source: 0, at }
    }

    /// Which of two candidates is drawn, over many draws.
    fn shares(usage: &mut Usage, errors: [u64; 2]) -> [u32; 2] {
        let mut rng = Seed(1).rng();
        let mut drawn = [0; 2];
        for _ in 0..1000 {
            let both = [candidate(errors[0], [0, 0]), candidate(errors[1], [30, 20])];
            let (chosen, _) = usage.draw(&both, 0, &mut rng).unwrap();
            usage.note(&chosen);
            drawn[usize::from(chosen.at == [30, 20])] += 1;
        }
        drawn
    }

    #[test]
    fn alike_places_take_turns_and_bad_ones_are_never_drawn() {
        for errors in [[0, 0], [100, 100], [100, 105]] {
            let [a, b] = shares(&mut usage(0.1), errors);
            assert!(a.abs_diff(b) < 100, "{errors:?} {a} {b}");
        }
        assert_eq!(shares(&mut usage(10.0), [100, 201])[1], 0, "twice as bad");
        assert_eq!(shares(&mut usage(0.0), [100, 101])[1], 0, "without spread, the best");
    }

    #[test]
    fn above_an_error_of_0_the_widened_tolerance_holds_all_that_may_be_drawn() {
        let mut rng = Seed(3).rng();
        let mut usage = usage(0.3);
        assert_eq!(usage.widened(210, &candidate(9, [0, 0])), 210, "nothing was used yet");
        let mut widened = 0;
        for _ in 0..300 {
            let candidates: Vec<_> =
                (0..20).map(|i| candidate(50 + u64::from(rng.below(100)), [i, rng.below(22)])).collect();
            let best = candidates.iter().min().unwrap();
            let limit = best.error * (1000 + u64::from(usage.widened(210, best)));
            widened += u32::from(1210 * best.error < limit);
            let (chosen, _) = usage.draw(&candidates, 210, &mut rng).unwrap();
            usage.note(&chosen);
            assert!(chosen.error * 1000 <= limit);
        }
        assert!(50 < widened, "{widened}");
    }

    #[test]
    fn uses_are_counted_about_the_block_in_its_own_source() {
        let mut usage = usage(1.0);
        usage.note(&candidate(0, [20, 9]));
        assert_eq!(usage.sources[0].total, 25);
        let added = |source, at| usage.added(&Candidate { error: 0, source, at });
        assert!(0 < added(0, [20, 9]) && 0 < added(0, [16, 13]));
        assert_eq!([added(0, [20, 15]), added(0, [27, 9]), added(1, [12, 0])], [0; 3]);
        assert_eq!(added(1, [19, 4]), 0, "a cropped block");
    }
}
