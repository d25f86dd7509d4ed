//! How alike a texture is to itself at single translations, where few are asked for.

use selvedge_core::{Domain, Grid};

use crate::periods::{likeness, twice_variance};
use crate::reach::Reach;

/// Samples that are compared at a translation: of what overlaps in more, one row of each band of rows, all of whose
/// samples are. They place a period to a sample: its likeness falls on both sides by far more than rows differ. At even
/// distances they could all be mortar.
const COMPARED: usize = 1 << 17;

/// A texture that is moved over itself, by at most half of its sides.
pub(crate) struct Near<'a, const D: usize> {
    features: &'a Grid<u8, D>,
    valid: Option<&'a Grid<bool, D>>,
    weights: &'a [u8],
    twice_variance: (u128, u128),
    /// As far as all translations at once are looked at.
    reach: Reach<D>,
    /// Those that count.
    samples: usize,
}

impl<'a, const D: usize> Near<'a, D> {
    /// `None` for a flat texture.
    pub(crate) fn new(features: &'a Grid<u8, D>, valid: Option<&'a Grid<bool, D>>, weights: &'a [u8]) -> Option<Self> {
        let mask = valid.map(Grid::samples);
        let twice_variance = twice_variance(features, mask, weights);
        let samples = mask.map_or(features.domain().len(), |mask| mask.iter().filter(|&&v| v).count());
        let reach = Reach::half(features.domain());
        (twice_variance.0 != 0).then_some(Self { features, valid, weights, twice_variance, reach, samples })
    }

    /// In thousandths, as [`Strengths::at`](crate::periods::Strengths::at) has it, of a translation down and across;
    /// `None` where it is too far.
    pub(crate) fn at(&self, by: [i32; 2]) -> Option<i64> {
        let domain = self.features.domain();
        let by: [i32; D] = std::array::from_fn(|a| if a + 2 < D { 0 } else { by[a + 2 - D] });
        let is_near = (0..D).all(|a| by[a].unsigned_abs() <= self.reach.most[a]);
        if D < 2 || !is_near {
            return None;
        }
        // What overlaps, in the texture as it stands: what is compared with it is further by `by`.
        let first = by.map(|n| n.min(0).unsigned_abs());
        let shape: [u32; D] = std::array::from_fn(|a| domain.shape[a] - by[a].unsigned_abs());
        let overlap = Domain::open(shape);
        let width = shape[D - 1] as usize;
        let every = overlap.len().div_ceil(COMPARED).max(1);
        let (mut error, mut compared, mut seen) = (0_u64, 0, 0);
        let rows = overlap.len() / width.max(1);
        for band in 0..rows.div_ceil(every) {
            let row = (band * every + keyed(band) % every).min(rows - 1);
            let at = overlap.position(row * width);
            let here = domain.index(std::array::from_fn(|a| at[a] + first[a]));
            let there = domain.index(std::array::from_fn(|a| (at[a] + first[a]).wrapping_add_signed(by[a])));
            let (row_error, counted) = self.row(here, there, width);
            (error, compared, seen) = (error + row_error, compared + counted, seen + width);
        }
        let enough =
            self.samples as u128 * seen as u128 <= (compared * self.reach.one_in) as u128 * overlap.len() as u128;
        (0 < compared && enough).then(|| likeness(error, compared as u64, self.twice_variance))
    }

    /// The error of samples from `here` on beside those from `there` on, and how many count.
    fn row(&self, here: usize, there: usize, width: usize) -> (u64, usize) {
        let planes = || self.weights.iter().enumerate().map(|(c, &w)| (self.features.plane(c), u64::from(w)));
        let squared = |a: u8, b: u8| u32::from(a.abs_diff(b)).pow(2);
        let Some(valid) = self.valid.map(Grid::samples) else {
            // A square is at most 65,025: so many fit into 32 bits.
            let part = |(a, b): (&[u8], &[u8])| -> u64 {
                u64::from(a.iter().zip(b).map(|(&a, &b)| squared(a, b)).sum::<u32>())
            };
            let of_plane = |plane: &[u8]| -> u64 {
                let parts = plane[here..here + width].chunks(1 << 15);
                parts.zip(plane[there..there + width].chunks(1 << 15)).map(part).sum()
            };
            return (planes().map(|(plane, w)| w * of_plane(plane)).sum(), width);
        };
        let counts = |&i: &usize| valid[here + i] && valid[there + i];
        let error =
            |i| planes().map(|(plane, w)| w * u64::from(squared(plane[here + i], plane[there + i]))).sum::<u64>();
        (0..width).filter(counts).fold((0, 0), |(sum, n), i| (sum + error(i), n + 1))
    }
}

/// Some number that is always the same, and has no period.
fn keyed(band: usize) -> usize {
    ((band as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periods::Strengths;
    use selvedge_core::Seed;

    #[test]
    fn single_translations_are_as_alike_as_all_at_once() {
        let mut rng = Seed(3).rng();
        for masked in [false, true] {
            let domain = Domain::open([23, 31]);
            let samples = (0..2 * domain.len()).map(|i| (i * i % 200) as u8 ^ rng.below(32) as u8).collect();
            let features = Grid::from_vec(domain, 2, samples).unwrap();
            let valid = domain.positions().map(|[y, x]| 9 < y || 12 < x).collect();
            let valid = masked.then(|| Grid::from_vec(domain, 1, valid).unwrap());
            let all = Strengths::of(&features, valid.as_ref(), &[2, 9]).unwrap().unwrap();
            let near = Near::new(&features, valid.as_ref(), &[2, 9]).unwrap();
            let vectors = (-13..=13).flat_map(|y| (-17..=17).map(move |x| [y, x]));
            let told: Vec<_> = vectors.map(|v| (v, near.at(v), all.at(v))).collect();
            assert!(told.iter().all(|(_, one, other)| one == other), "{told:?}");
            assert!(told.iter().any(|(_, one, _)| one.is_none()) && told.iter().any(|(_, one, _)| one.is_some()));
        }
        let flat = Grid::from_vec(Domain::open([4, 4]), 1, vec![9; 16]).unwrap();
        assert!(Near::new(&flat, None, &[1]).is_none());
    }

    #[test]
    fn rows_of_a_large_texture_place_its_period() {
        let (domain, mut rng) = (Domain::open([700, 600]), Seed(4).rng());
        let cell: Vec<u8> = (0..90 * 77).map(|_| rng.below(200) as u8).collect();
        let value = |[y, x]: [u32; 2]| cell[(y % 90 * 77 + x % 77) as usize] + (y * 31 + x * 17) as u8 % 40;
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let near = Near::new(&features, None, &[1]).unwrap();
        let best = (85..95).flat_map(|y| (-5..6).map(move |x| [y, x])).max_by_key(|&v| near.at(v));
        assert_eq!(best, Some([90, 0]));
    }

    #[test]
    fn rows_that_are_all_alike_place_no_period() {
        // Courses of 32 rows, of which the first is the same everywhere: what is compared is one row of 32.
        let domain = Domain::open([2048, 2048]);
        let value = |[y, x]: [u32; 2]| if y % 32 == 0 { 9 } else { (x % 60 * 4) as u8 };
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let near = Near::new(&features, None, &[1]).unwrap();
        let best = (50..70).max_by_key(|&x| near.at([0, x]));
        assert_eq!(best, Some(60));
    }
}
