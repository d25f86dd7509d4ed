//! How regularly exemplars repeat themselves.

use selvedge_core::{Domain, Exemplars, Grid, try_vec};
use selvedge_fft_ssd::{Costs, Error};

use crate::feature_size::firsts;
use crate::memory::collected;
use crate::periods::{Reach, differences};

/// Samples of the copy at most that is looked at: what is fine need not come again to the sample.
const COARSE: usize = 3000;

/// How regularly the most regular of some exemplars repeats itself, in thousandths, up to 2000: the most by which its
/// likeness to itself at any translation of at most half its sides is above the lowest on the straight way there.
///
/// Likeness, from -1000 to 1000, is a correlation over the samples that overlap, from which the exemplar's mean is subtracted:
/// `1 - sum of (a - b)^2 / sum of (a^2 + b^2)`, so that of gradients and uneven light only what comes again counts.
/// Measured on a coarse copy of at most 3000 samples. Of an exemplar in several orientations the first counts. Takes some
/// milliseconds an exemplar, and what a pass over its samples takes.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn periodicity<const D: usize>(exemplars: &Exemplars<D>) -> Result<u32, Error> {
    firsts(exemplars).try_fold(0, |most, source| {
        let (features, valid) = coarse(&source.features, source.valid.as_ref())?;
        let likeness = Likeness::of(&features, &valid, exemplars.weights())?;
        Ok(most.max(likeness.highest_above_lowest()))
    })
}

/// How alike an exemplar is to itself at each translation, in proportion to what overlaps there.
struct Likeness<const D: usize> {
    /// The sums of squared differences, at one of each pair of opposites.
    differences: Costs<D>,
    /// The sums of squared distances from the mean: of what a translation puts under the exemplar.
    energies: Costs<D>,
}

impl<const D: usize> Likeness<D> {
    fn of(features: &Grid<u8, D>, valid: &Grid<bool, D>, weights: &[u8]) -> Result<Self, Error> {
        let mut flat = Grid::try_filled(features.domain(), features.channels(), 0)?;
        for c in 0..features.channels() {
            let known = || features.plane(c).iter().zip(valid.samples()).filter(|&(_, &known)| known).map(|(&v, _)| v);
            let (sum, n) = known().fold((0, 0), |(sum, n), v| (sum + u64::from(v), n + 1));
            flat.plane_mut(c).fill(rounded(sum, n));
        }
        let between = |template: &Grid<u8, D>, half| {
            differences(template, features, Some(valid), weights, (Reach::half(features.domain()), half))
        };
        Ok(Self { differences: between(features, true)?, energies: between(&flat, false)? })
    }

    /// In thousandths; `None` beyond the translations looked at.
    fn at(&self, vector: [i32; D]) -> Option<i64> {
        let opposite = vector.map(|v| -v);
        let energy = |v: [i32; D]| self.energies.get(0, v).map(|c| u128::from(c.error));
        let both = energy(vector)? + energy(opposite)?;
        let differs = self.differences.get(0, if vector[0] < 0 { opposite } else { vector })?;
        // Where all is the mean, nothing is alike.
        let ratio = (u128::from(differs.error) * 1000).checked_div(both);
        Some(ratio.map_or(0, |ratio| 1000 - ratio as i64))
    }

    /// How far the likeness at any translation is above the least on the way there from none.
    fn highest_above_lowest(&self) -> u32 {
        let above = |to: [i32; D]| {
            let steps = to.iter().map(|c| c.abs()).max().filter(|&n| n != 0)?;
            let on_the_way = |s: i32| to.map(|c| (c * s + steps / 2 * c.signum()) / steps);
            let lowest = (1..=steps).filter_map(|s| self.at(on_the_way(s))).min()?;
            Some(self.at(to)? - lowest)
        };
        self.differences.iter().filter_map(|c| above(c.position)).max().map_or(0, |above| above as u32)
    }
}

/// The mean of `n` values, 0 of none.
fn rounded(sum: u64, n: u64) -> u8 {
    let n = n.max(1);
    ((2 * sum + n) / (2 * n)) as u8
}

/// A copy of at most [`COARSE`] samples, each the mean of the valid ones of a box, and which of them have any.
fn coarse<const D: usize>(
    grid: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
) -> Result<(Grid<u8, D>, Grid<bool, D>), Error> {
    let (fine, channels) = (grid.domain(), grid.channels());
    let shape = |side: u32| Domain::open(fine.shape.map(|n| n.div_ceil(side)));
    let side = (1..).find(|&side| shape(side).len() <= COARSE).unwrap_or(u32::MAX);
    let domain = shape(side);
    let mut sums = try_vec(channels * domain.len(), 0_u64)?;
    let mut counts = try_vec(domain.len(), 0_u64)?;
    for (i, at) in fine.positions().enumerate().filter(|&(i, _)| valid.is_none_or(|v| v.samples()[i])) {
        let cell = domain.index(at.map(|p| p / side));
        counts[cell] += 1;
        (0..channels).for_each(|c| sums[c * domain.len() + cell] += u64::from(grid.plane(c)[i]));
    }
    let mean = |(i, &sum): (usize, &u64)| rounded(sum, counts[i % domain.len()]);
    let means = collected(sums.iter().enumerate().map(mean))?;
    let known = collected(counts.iter().map(|&n| n != 0))?;
    Ok((Grid::from_vec(domain, channels, means)?, Grid::from_vec(domain, 1, known)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Seed, Source, Transform};

    fn one(shape: [u32; 2], at: impl Fn(u32, u32) -> u8) -> Exemplars<2> {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| at(y, x)).collect();
        let features = Grid::from_vec(domain, 1, samples).expect("right length");
        let source = Source { features, valid: None, origin: Origin { exemplar: 0, transform: Transform::IDENTITY } };
        Exemplars::from_sources(vec![source], vec![1]).expect("well formed")
    }

    #[test]
    fn regular_textures_are_told_from_noise() {
        let checks = one([60, 70], |y, x| if (y / 8 + x / 8) % 2 == 0 { 200 } else { 40 });
        assert!(900 < periodicity(&checks).expect("memory suffices"));
        let fine = one([400, 300], |y, x| if (y / 40 + x / 40) % 2 == 0 { 200 } else { 40 });
        assert!(900 < periodicity(&fine).expect("memory suffices"));
        let noise = one([60, 70], |y, x| Seed(1).derive("noise", u64::from(y * 70 + x)).0 as u8);
        assert!(periodicity(&noise).expect("memory suffices") < 300);
        assert_eq!(periodicity(&one([60, 70], |_, _| 7)), Ok(0));
    }

    #[test]
    fn gradients_and_holes_are_no_repetition() {
        let ramp = one([50, 40], |y, x| (y * 3 + x * 2) as u8);
        assert!(periodicity(&ramp).expect("memory suffices") < 300);
        let saw = one([50, 40], |y, x| (y * 5 + x * 3) as u8);
        assert!(periodicity(&saw).expect("memory suffices") < 700);
        let mut checks = one([60, 70], |y, x| if (y / 8 + x / 8) % 2 == 0 { 200 } else { 40 }).sources()[0].clone();
        let hole = |[y, x]: [u32; 2]| y.abs_diff(25) < 9 && x.abs_diff(30) < 12;
        let valid = checks.domain().positions().map(|at| !hole(at)).collect();
        checks.valid = Some(Grid::from_vec(checks.domain(), 1, valid).expect("right length"));
        let holed = Exemplars::from_sources(vec![checks], vec![1]).expect("well formed");
        assert!(900 < periodicity(&holed).expect("memory suffices"));
    }
}
