//! Candidates, and the draw among them. `[Kwatra03 eq. 3]`

use selvedge_core::{Exemplars, Patch, Rng};

/// An excess in units of the scale beyond which nothing is left of a probability in units of 2^-32: ln 2^32 = 22.2, and
/// some room for rounding.
pub(crate) const NOTHING: f64 = 22.5;

/// A patch and how well it agrees with the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate<const D: usize> {
    pub(crate) patch: Patch<D>,
    /// Mean squared difference a sample, plus whatever is held against it.
    pub(crate) cost: f64,
}

/// Candidates whose cost is within `slack` of the least: nothing else is ever drawn.
#[derive(Debug)]
pub(crate) struct Shortlist<const D: usize> {
    slack: f64,
    least: f64,
    kept: Vec<Candidate<D>>,
}

impl<const D: usize> Shortlist<D> {
    pub(crate) fn new(slack: f64) -> Self {
        Self { slack, least: f64::INFINITY, kept: Vec::new() }
    }

    /// Keeps a candidate that may be drawn; only one that is cheap enough is asked whether it is `admissible`.
    pub(crate) fn offer(&mut self, candidate: Candidate<D>, admissible: impl FnOnce() -> bool) {
        if candidate.cost - self.least <= self.slack && admissible() {
            self.least = self.least.min(candidate.cost);
            self.kept.push(candidate);
        }
    }

    pub(crate) fn finish(self) -> Vec<Candidate<D>> {
        let Self { slack, least, mut kept } = self;
        kept.retain(|c| c.cost - least <= slack);
        kept
    }
}

/// `sigma^2` of eq. 3: the sum of the channels' variances over all valid samples, in the units of squared differences.
pub(crate) fn variance<const D: usize>(exemplars: &Exemplars<D>) -> f64 {
    let mut variance = 0.0;
    for (c, &weight) in exemplars.weights().iter().enumerate() {
        let (mut n, mut sum, mut squares) = (0_u64, 0_u64, 0_u64);
        for source in exemplars.sources() {
            let valid = source.valid.as_deref().map(|v| v.samples());
            for (i, &v) in source.features.plane(c).iter().enumerate() {
                if valid.is_none_or(|valid| valid[i]) {
                    (n, sum, squares) = (n + 1, sum + u64::from(v), squares + u64::from(v) * u64::from(v));
                }
            }
        }
        let mean = sum as f64 / n.max(1) as f64;
        variance += (squares as f64 / n.max(1) as f64 - mean * mean) * f64::from(weight);
    }
    variance
}

/// Draws up to `count` different candidates, each with a probability proportional to `exp(-cost / scale)`; at scale 0
/// the cheapest. The first drawn comes first.
pub(crate) fn draw<const D: usize>(
    candidates: &[Candidate<D>],
    scale: f64,
    count: usize,
    rng: &mut Rng,
) -> Vec<Patch<D>> {
    let mut drawn = Vec::new();
    let least = candidates.iter().map(|c| c.cost).fold(f64::INFINITY, f64::min);
    let mut weights: Vec<u64> = candidates.iter().map(|c| weight(c.cost - least, scale)).collect();
    let mut sum: u64 = weights.iter().sum();
    while drawn.len() < count && 0 < sum {
        let mut left = rng.below_u64(sum);
        let chosen = weights.iter().position(|&w| {
            let here = left < w;
            left = left.wrapping_sub(if here { 0 } else { w });
            here
        });
        let Some(chosen) = chosen else { break };
        drawn.push(candidates[chosen].patch);
        sum -= weights[chosen];
        weights[chosen] = 0;
    }
    drawn
}

/// `exp(-excess / scale)` in units of 2^-32. Sums of 2^32 of them fit 64 bits.
fn weight(excess: f64, scale: f64) -> u64 {
    if excess <= 0.0 {
        return 1 << 32;
    }
    let x = excess / scale;
    if x < NOTHING { (libm::exp(-x) * (1_u64 << 32) as f64) as u64 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    fn of(costs: &[f64]) -> Vec<Candidate<1>> {
        let patch = |i: usize| Patch { source: 0, offset: [i as i32] };
        costs.iter().enumerate().map(|(i, &cost)| Candidate { patch: patch(i), cost }).collect()
    }

    #[test]
    fn sigma_squared_is_the_sum_of_the_channels_variances() {
        let domain = selvedge_core::Domain::open([2]);
        let features = selvedge_core::Grid::from_vec(domain, 3, vec![0, 2, 10, 10, 0, 20]).unwrap();
        let transform = selvedge_core::Transform::IDENTITY;
        let origin = selvedge_core::Origin { exemplar: 0, transform };
        let source = selvedge_core::Source { features, valid: None, origin };
        assert_eq!(variance(&Exemplars::from_sources(vec![source], vec![1, 1, 2]).unwrap()), 1.0 + 0.0 + 200.0);
    }

    #[test]
    fn only_what_may_be_drawn_is_listed() {
        let mut list = Shortlist::new(2.0);
        let costs = [9.0, 5.0, 8.0, 6.5, 4.0, 6.0];
        for c in of(&costs) {
            list.offer(c, || c.cost != 4.0);
        }
        let kept: Vec<f64> = list.finish().iter().map(|c| c.cost).collect();
        assert_eq!(kept, [5.0, 6.5, 6.0]);
    }

    #[test]
    fn draws_follow_equation_3() {
        let candidates = of(&[5.0, 7.0, 6.0, 1e9]);
        let mut counts = [0_u32; 4];
        let mut rng = Seed(1).rng();
        for _ in 0..40_000 {
            counts[draw(&candidates, 2.0, 1, &mut rng)[0].offset[0] as usize] += 1;
        }
        let weights = [1.0, libm::exp(-1.0), libm::exp(-0.5), 0.0];
        let sum: f64 = weights.iter().sum();
        for (count, weight) in counts.into_iter().zip(weights) {
            // Five standard deviations of a binomial are at most 500.
            assert!((f64::from(count) - 40_000.0 * weight / sum).abs() < 500.0, "{counts:?}");
        }
    }

    #[test]
    fn without_randomness_the_best_is_taken() {
        let drawn = draw(&of(&[3.0, 2.0, 2.0]), 0.0, 9, &mut Seed(2).rng());
        let mut offsets: Vec<i32> = drawn.iter().map(|p| p.offset[0]).collect();
        offsets.sort_unstable();
        assert_eq!(offsets, [1, 2]);
        assert!(draw::<1>(&[], 1.0, 1, &mut Seed(2).rng()).is_empty());
    }
}
