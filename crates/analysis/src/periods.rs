//! Translations under which an exemplar resembles itself: its periods.

use selvedge_core::{Domain, Grid, collected, try_vec};
use selvedge_fft_ssd::{Costs, Error, Scratch, SsdSearcher, Template};

use crate::reach::{Reach, SAMPLES, asked_once, shape_of_middle};

/// A translation under which an exemplar resembles itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period<const D: usize> {
    /// The translation in samples, slowest axis first; its first component that is not 0 is positive.
    pub vector: [i32; D],
    /// How alike, in thousandths: 1000 less the mean squared difference at this translation over twice the variance. An
    /// exact repetition has 1000, unrelated samples 0.
    pub strength: u32,
}

/// The translations of at most half the exemplar that are likelier than all around them, strongest first; of
/// those within a twentieth of the strongest left, the shorter first, so that a period comes before its multiples.
///
/// Strength is a correlation of the features with themselves, mean subtracted, found from exact sums of squared
/// differences over the samples that overlap; samples that are not valid do not count. Of more than 2^20 samples only
/// the middle is looked at, the longest side halved until it fits. A flat exemplar has no period. Takes
/// `O(samples * log(samples))`.
///
/// # Errors
/// [`Error::Core`] if weights and channels differ or memory is short.
pub fn periods<const D: usize>(
    features: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
    weights: &[u8],
) -> Result<Vec<Period<D>>, Error> {
    let strengths = Strengths::of(features, valid, weights)?;
    strengths.map_or_else(|| Ok(Vec::new()), |s| s.periods())
}

/// The sums of squared differences of a grid and itself, where it is valid, at
/// one of each pair of opposite translations within `reach`.
fn differences<const D: usize>(
    features: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
    weights: &[u8],
    reach: Reach<D>,
) -> Result<Costs<D>, Error> {
    let options = asked_once(features.domain(), weights, valid.is_some(), reach)?;
    let searcher = SsdSearcher::of_grid(features, valid, weights, options)?;
    let template = valid.map_or(Template::of(features), |v| Template::of(features).masked(v.samples()));
    let samples = valid.map_or(features.domain().len(), |v| v.samples().iter().filter(|&&v| v).count());
    let (first, count) = reach.positions();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search_box(&template, first, count, (samples / reach.one_in) as u64, &mut scratch, &mut costs)?;
    Ok(costs)
}

/// Twice the weighted variance of the samples that count, as a fraction: `2 (n sum w v^2 - (sum v)^2 w) / n^2`.
pub(crate) fn twice_variance<const D: usize>(
    features: &Grid<u8, D>,
    mask: Option<&[bool]>,
    weights: &[u8],
) -> (u128, u128) {
    let mut variance = 0;
    let mut n = 0;
    for (c, &w) in weights.iter().enumerate() {
        let (mut sum, mut squares) = (0_u64, 0_u64);
        n = 0_u64;
        for (_, &v) in features.plane(c).iter().enumerate().filter(|&(i, _)| mask.is_none_or(|m| m[i])) {
            (n, sum, squares) = (n + 1, sum + u64::from(v), squares + u64::from(v) * u64::from(v));
        }
        variance += u128::from(w) * (u128::from(n) * u128::from(squares) - u128::from(sum) * u128::from(sum));
    }
    (2 * variance, u128::from(n) * u128::from(n))
}

/// In thousandths, of a sum over so many samples.
pub(crate) fn likeness(error: u64, samples: u64, (variance, n2): (u128, u128)) -> i64 {
    // Sums stay below 2^20 * 65025 * 2040 < 2^47, and of 2^28 samples the square is below 2^57: the product fits.
    let ratio = u128::from(error) * n2 * 1000 / (u128::from(samples) * variance);
    1000 - i64::try_from(ratio).unwrap_or(i64::MAX - 1000)
}

/// How alike an exemplar is to itself at each translation.
pub(crate) struct Strengths<const D: usize> {
    pub(crate) costs: Costs<D>,
    /// Numerator and denominator.
    twice_variance: (u128, u128),
}

impl<const D: usize> Strengths<D> {
    /// `None` for a flat exemplar.
    pub(crate) fn of(
        features: &Grid<u8, D>,
        valid: Option<&Grid<bool, D>>,
        weights: &[u8],
    ) -> Result<Option<Self>, Error> {
        if weights.len() != features.channels() {
            let (expected, found) = (features.channels(), weights.len());
            return Err(selvedge_core::Error::Weights { expected, found }.into());
        }
        let features = &middle(features, SAMPLES)?;
        let valid = valid.map(|valid| middle(valid, SAMPLES)).transpose()?;
        Self::within(features, valid.as_ref(), weights, Reach::half(features.domain()))
    }

    /// The same within another reach, whatever the size.
    pub(crate) fn within(
        features: &Grid<u8, D>,
        valid: Option<&Grid<bool, D>>,
        weights: &[u8],
        reach: Reach<D>,
    ) -> Result<Option<Self>, Error> {
        let twice_variance = twice_variance(features, valid.map(Grid::samples), weights);
        if twice_variance.0 == 0 {
            return Ok(None);
        }
        Ok(Some(Self { costs: differences(features, valid, weights, reach)?, twice_variance }))
    }

    /// See [`periods`].
    pub(crate) fn periods(&self) -> Result<Vec<Period<D>>, Error> {
        let mut found = collected(self.costs.iter().filter_map(|c| self.peak(c.position)))?;
        rank(&mut found);
        Ok(found)
    }

    /// In thousandths; `None` beyond the translations looked at.
    pub(crate) fn at(&self, vector: [i32; D]) -> Option<i64> {
        let vector = if vector[0] < 0 { vector.map(|v| -v) } else { vector };
        let c = self.costs.get(0, vector)?;
        Some(likeness(c.error, c.samples, self.twice_variance))
    }

    /// The period at a vector, if it is above all its neighbours; of equal neighbours the first counts.
    pub(crate) fn peak(&self, vector: [i32; D]) -> Option<Period<D>> {
        let first = vector.iter().find(|&&v| v != 0)?;
        let here = self.at(vector).filter(|&s| 0 < *first && 0 < s)?;
        let around = Domain::<D>::open([3; D]);
        for at in around.positions() {
            let step: [i32; D] = at.map(|a| a as i32 - 1);
            // Along an axis with nowhere to go there are no neighbours.
            if step.iter().zip(self.costs.sources()[0].shape).any(|(&s, n)| s != 0 && n == 1) || step == [0; D] {
                continue;
            }
            let there = self.at(std::array::from_fn(|a| vector[a] + step[a]))?;
            if here < there || (here == there && step < [0; D]) {
                return None;
            }
        }
        Some(Period { vector, strength: here as u32 })
    }
}

/// Strongest first; of those within a twentieth of the strongest left, the shorter first.
fn rank<const D: usize>(found: &mut [Period<D>]) {
    let length = |p: &Period<D>| p.vector.iter().map(|&v| i64::from(v).pow(2)).sum::<i64>();
    found.sort_unstable_by_key(|p| (std::cmp::Reverse(p.strength), length(p), p.vector));
    let mut rest = found;
    while let Some(strongest) = rest.first().map(|p| p.strength) {
        let n = rest.partition_point(|p| strongest - strongest / 20 <= p.strength);
        rest[..n].sort_unstable_by_key(|p| (length(p), std::cmp::Reverse(p.strength), p.vector));
        rest = &mut rest[n..];
    }
}

/// The middle of a grid, its longest side halved until it has at most so many samples.
pub(crate) fn middle<T: Copy + Default, const D: usize>(grid: &Grid<T, D>, most: usize) -> Result<Grid<T, D>, Error> {
    let shape = shape_of_middle(grid.domain().shape, most);
    let (from, to) = (grid.domain(), Domain::open(shape));
    let first: [u32; D] = std::array::from_fn(|a| (from.shape[a] - shape[a]) / 2);
    let mut samples = try_vec(to.len() * grid.channels(), T::default())?;
    for (c, plane) in samples.chunks_mut(to.len().max(1)).enumerate() {
        for (at, sample) in to.positions().zip(plane) {
            *sample = grid.plane(c)[from.index(std::array::from_fn(|a| at[a] + first[a]))];
        }
    }
    Ok(Grid::from_vec(to, grid.channels(), samples)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    /// A texture that repeats itself under the two vectors, of noise in its cell.
    fn lattice(shape: [u32; 2], height: u32, width: u32, shear: u32) -> Grid<u8, 2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(4).rng();
        let cell: Vec<u8> = (0..height * width).map(|_| rng.below(256) as u8).collect();
        let value = |at: [u32; 2]| {
            let x = at[1] + (height * width - at[0] / height) * shear % width;
            cell[(at[0] % height * width + x % width) as usize]
        };
        Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap()
    }

    #[test]
    fn the_shortest_periods_of_a_lattice_come_first() {
        let found = periods(&lattice([70, 64], 11, 13, 0), None, &[1]).unwrap();
        assert_eq!(found[0], Period { vector: [11, 0], strength: 1000 });
        assert_eq!(found[1], Period { vector: [0, 13], strength: 1000 });
        assert!(
            found.iter().take_while(|p| p.strength == 1000).all(|p| p.vector[0] % 11 == 0 && p.vector[1] % 13 == 0)
        );
    }

    #[test]
    fn sheared_rows_have_oblique_periods() {
        // Each row of bricks is moved by half a brick.
        let found = periods(&lattice([90, 80], 8, 20, 10), None, &[3]).unwrap();
        let vectors: Vec<_> = found.iter().take(3).map(|p| p.vector).collect();
        assert_eq!(vectors, [[8, -10], [8, 10], [16, 0]]);
    }

    #[test]
    fn flat_and_single_samples_have_none_and_noise_only_weak_ones() {
        let flat = Grid::try_filled(Domain::open([20, 30]), 2, 7_u8).unwrap();
        assert_eq!(periods(&flat, None, &[1, 1]), Ok(Vec::new()));
        let one = Grid::try_filled(Domain::open([1, 1]), 1, 7_u8).unwrap();
        assert_eq!(periods(&one, None, &[1]), Ok(Vec::new()));
        let mut rng = Seed(5).rng();
        let noise =
            Grid::from_vec(Domain::open([64, 64]), 1, (0..4096).map(|_| rng.below(256) as u8).collect()).unwrap();
        // Means over 512 samples and more: 6 standard deviations are below 270 thousandths.
        assert!(periods(&noise, None, &[1]).unwrap().iter().all(|p| p.strength < 270));
        assert!(matches!(periods(&noise, None, &[1, 1]), Err(Error::Core(selvedge_core::Error::Weights { .. }))));
    }

    #[test]
    fn holes_do_not_count() {
        let mut grid = lattice([66, 65], 11, 13, 0);
        let mut valid = Grid::try_filled(grid.domain(), 1, true).unwrap();
        for y in 20..30 {
            for x in 5..50 {
                grid.set(0, [y, x], 0);
                valid.set(0, [y, x], false);
            }
        }
        let found = periods(&grid, Some(&valid), &[1]).unwrap();
        assert_eq!(found[0], Period { vector: [11, 0], strength: 1000 });
    }

    #[test]
    fn clips_repeat_in_time() {
        let domain = Domain::open([24, 9, 8]);
        let mut rng = Seed(6).rng();
        let frames: Vec<u8> = (0..7 * 72).map(|_| rng.below(256) as u8).collect();
        let samples = (0..domain.len()).map(|i| frames[i % frames.len()]).collect();
        let found = periods(&Grid::from_vec(domain, 1, samples).unwrap(), None, &[1]).unwrap();
        assert_eq!(found[0], Period { vector: [7, 0, 0], strength: 1000 });
    }

    #[test]
    fn large_exemplars_are_looked_at_in_the_middle() {
        let found = periods(&lattice([1500, 1400], 11, 13, 0), None, &[1]).unwrap();
        assert_eq!(found[0], Period { vector: [11, 0], strength: 1000 });
    }
}
