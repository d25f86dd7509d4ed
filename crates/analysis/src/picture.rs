//! A small picture of a texture, and what is left of it without its shade.

use selvedge_core::{Domain, Grid, collected, try_vec};
use selvedge_fft_ssd::Error;

/// Cells along the longer side at most: what is finer does not tell one kind from another, and all of it takes
/// milliseconds.
const SIDE: u32 = 200;
/// Steps of a feature: means are kept finer than features are.
pub(crate) const STEPS: i32 = 16;

/// Means of a texture's features over square cells, in sixteenths of a feature.
pub(crate) struct Picture {
    /// Side of a cell in samples.
    pub(crate) side: u32,
    pub(crate) means: Grid<i32, 2>,
    /// False where a cell has no valid sample.
    pub(crate) known: Grid<bool, 2>,
}

/// The last two axes.
pub(crate) fn frame<const D: usize>(domain: Domain<D>) -> Domain<2> {
    Domain::open([if D < 2 { 1 } else { domain.shape[D - 2] }, domain.shape[D - 1]])
}

/// The side of the cells of a frame, and how many there are.
pub(crate) fn cells(frame: Domain<2>) -> (u32, Domain<2>) {
    let [height, width] = frame.shape;
    let side = height.max(width).div_ceil(SIDE).max(1);
    (side, Domain::open(frame.shape.map(|n| n.div_ceil(side))))
}

impl Picture {
    /// Of the last two axes, in the middle of the others.
    pub(crate) fn of<const D: usize>(features: &Grid<u8, D>, valid: Option<&Grid<bool, D>>) -> Result<Self, Error> {
        let fine = frame(features.domain());
        let first = features.domain().len() / fine.len().max(1) / 2 * fine.len();
        let (side, cells) = cells(fine);
        let mut sums = try_vec(cells.len() * features.channels(), 0_i64)?;
        let mut counts = try_vec(cells.len(), 0_i64)?;
        for (i, at) in fine.positions().enumerate().filter(|&(i, _)| valid.is_none_or(|v| v.samples()[first + i])) {
            let cell = cells.index(at.map(|p| p / side));
            counts[cell] += 1;
            for c in 0..features.channels() {
                sums[c * cells.len() + cell] += i64::from(features.plane(c)[first + i]);
            }
        }
        let mean = |(i, &sum): (usize, &i64)| rounded(sum * i64::from(STEPS), counts[i % cells.len()]);
        let means = Grid::from_vec(cells, features.channels(), collected(sums.iter().enumerate().map(mean))?)?;
        Ok(Self { side, means, known: Grid::from_vec(cells, 1, collected(counts.iter().map(|&n| n != 0))?)? })
    }

    /// All cells.
    pub(crate) fn domain(&self) -> Domain<2> {
        self.known.domain()
    }

    /// Height and width in cells.
    pub(crate) fn shape(&self) -> [u32; 2] {
        self.domain().shape
    }

    /// The shade: means over boxes that reach `radius` cells to each side, taken twice.
    pub(crate) fn shade(&self, radius: u32) -> Result<Self, Error> {
        let once = self.boxed(radius)?;
        once.boxed(radius)
    }

    /// What is left when another picture of the same shape is taken away.
    pub(crate) fn without(&self, other: &Self) -> Result<Self, Error> {
        let left = self.means.samples().iter().zip(other.means.samples()).map(|(a, b)| a - b);
        let means = Grid::from_vec(self.means.domain(), self.means.channels(), collected(left)?)?;
        Ok(Self { side: self.side, means, known: self.known.map(|k| k)? })
    }

    /// Half of it as features about 128: differences of features span two of their ranges.
    pub(crate) fn features(&self) -> Result<Grid<u8, 2>, Error> {
        Ok(self.means.map(|v| (128 + v.div_euclid(2 * STEPS)).clamp(0, 255) as u8)?)
    }

    /// The variance of known cells, summed over channels by their weights, times the square of their number.
    pub(crate) fn variance(&self, weights: &[u8]) -> i128 {
        let mut variance = 0;
        for (c, &weight) in weights.iter().enumerate() {
            let known = self.known.samples().iter().zip(self.means.plane(c)).filter(|&(&known, _)| known);
            let (n, sum, squares) = known.fold((0, 0, 0), |(n, sum, squares), (_, &v)| {
                (n + 1, sum + i128::from(v), squares + i128::from(v) * i128::from(v))
            });
            variance += i128::from(weight) * (n * squares - sum * sum);
        }
        variance
    }

    /// Skewness of the known cells' channels, summed by their weights, in thousandths; 0 where all are alike.
    pub(crate) fn skew(&self, weights: &[u8]) -> i32 {
        let bright = |i: usize| {
            weights.iter().enumerate().map(move |(c, &w)| i128::from(w) * i128::from(self.means.plane(c)[i]))
        };
        let known = (0..self.domain().len()).filter(|&i| self.known.samples()[i]).map(|i| bright(i).sum::<i128>());
        let (n, s1, s2, s3) = known
            .fold((0_i128, 0_i128, 0_i128, 0_i128), |(n, s1, s2, s3), v| (n + 1, s1 + v, s2 + v * v, s3 + v * v * v));
        // Central moments, times the square and the cube of the number.
        let (second, third) = ((n * s2 - s1 * s1) as f64, (n * n * s3 - 3 * n * s1 * s2 + 2 * s1 * s1 * s1) as f64);
        if second <= 0.0 { 0 } else { (1000.0 * third / (second * second.sqrt())).round() as i32 }
    }

    /// Means over boxes, of what is known in them.
    fn boxed(&self, radius: u32) -> Result<Self, Error> {
        let domain = self.means.domain();
        let counts = Sums::of(domain, |i| i64::from(self.known.samples()[i]))?;
        let mut means = self.means.map(|v| v)?;
        for c in 0..self.means.channels() {
            let plane = self.means.plane(c);
            let sums = Sums::of(domain, |i| if self.known.samples()[i] { plane[i].into() } else { 0 })?;
            for (at, mean) in domain.positions().zip(means.plane_mut(c)) {
                *mean = rounded(sums.around(at, radius), counts.around(at, radius));
            }
        }
        Ok(Self { side: self.side, means, known: self.known.map(|k| k)? })
    }
}

/// The mean of `n` values, 0 of none.
fn rounded(sum: i64, n: i64) -> i32 {
    let n = n.max(1);
    (2 * sum + n).div_euclid(2 * n) as i32
}

/// Sums over all boxes from the first sample on.
struct Sums {
    shape: [usize; 2],
    sums: Vec<i64>,
}

impl Sums {
    fn of(domain: Domain<2>, at: impl Fn(usize) -> i64) -> Result<Self, Error> {
        let [h, w] = domain.shape.map(|n| n as usize);
        let mut sums = try_vec((h + 1) * (w + 1), 0_i64)?;
        for y in 0..h {
            let mut row = 0;
            for x in 0..w {
                row += at(y * w + x);
                sums[(y + 1) * (w + 1) + x + 1] = sums[y * (w + 1) + x + 1] + row;
            }
        }
        Ok(Self { shape: [h, w], sums })
    }

    /// The sum over the part of a box that lies inside.
    fn around(&self, at: [u32; 2], radius: u32) -> i64 {
        let first = at.map(|p| p.saturating_sub(radius) as usize);
        let end: [usize; 2] = std::array::from_fn(|a| ((at[a] + radius + 1) as usize).min(self.shape[a]));
        let sum = |y: usize, x: usize| self.sums[y * (self.shape[1] + 1) + x];
        sum(end[0], end[1]) + sum(first[0], first[1]) - sum(first[0], end[1]) - sum(end[0], first[1])
    }
}
