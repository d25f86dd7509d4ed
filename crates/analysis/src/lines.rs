//! Straight lines and rows: how much of a texture changes across one axis alone.

use crate::picture::Picture;

/// How much of a texture is lines along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Thousandths of the variance that the means of rows have: planks and courses that lie, lines of text.
    pub rows: u32,
    /// Thousandths of the variance that the means of columns have.
    pub columns: u32,
    /// Thousandths of all squared differences of neighbours that lie along x: 500 without a direction, 1000 where all
    /// lines stand upright.
    pub upright: u32,
}

impl Lines {
    /// Of a picture without its shade.
    pub(crate) fn of(picture: &Picture, weights: &[u8]) -> Self {
        let [h, w] = picture.shape().map(|n| n as usize);
        let n = picture.known.samples().iter().filter(|&&k| k).count() as i128;
        let all = picture.variance(weights);
        let [along_x, along_y] = [1, w].map(|step| differences(picture, weights, step));
        Self {
            rows: share(squares(picture, weights, h, |i| i / w) * n, all),
            columns: share(squares(picture, weights, w, |i| i % w) * n, all),
            upright: share(along_x, along_x + along_y),
        }
    }

    /// The lesser of the shares of rows and columns.
    pub(crate) fn lesser(&self) -> u32 {
        self.rows.min(self.columns)
    }

    /// The larger share, and how many thousandths of the differences lie along its lines.
    pub(crate) fn strongest(&self) -> (u32, u32) {
        if self.columns <= self.rows { (self.rows, self.upright) } else { (self.columns, 1000 - self.upright) }
    }
}

/// The sum over groups of cells of their sums' squares over their numbers, less that of all.
fn squares(picture: &Picture, weights: &[u8], groups: usize, group: impl Fn(usize) -> usize) -> i128 {
    let mut total = 0;
    for (c, &weight) in weights.iter().enumerate() {
        let mut sums = vec![(0_i128, 0_i128); groups];
        for (i, &v) in picture.means.plane(c).iter().enumerate().filter(|&(i, _)| picture.known.samples()[i]) {
            let (sum, n) = &mut sums[group(i)];
            (*sum, *n) = (*sum + i128::from(v), *n + 1);
        }
        let of = |(sum, n): (i128, i128)| sum * sum / n.max(1);
        let (sum, n) = sums.iter().fold((0, 0), |(a, b), &(sum, n)| (a + sum, b + n));
        total += i128::from(weight) * (sums.iter().map(|&s| of(s)).sum::<i128>() - of((sum, n)));
    }
    total
}

/// The sum of squared differences of cells that are `step` apart in a row or column.
fn differences(picture: &Picture, weights: &[u8], step: usize) -> i128 {
    let w = picture.shape()[1] as usize;
    let known = picture.known.samples();
    let pairs = || (step..known.len()).filter(move |&i| (step != 1 || i % w != 0) && known[i] && known[i - step]);
    let of = |(c, &weight): (usize, &u8)| {
        let plane = picture.means.plane(c);
        i128::from(weight) * pairs().map(|i| i128::from(plane[i] - plane[i - step]).pow(2)).sum::<i128>()
    };
    weights.iter().enumerate().map(of).sum()
}

/// A part of a whole in thousandths, 0 of nothing.
pub(crate) fn share(part: i128, whole: i128) -> u32 {
    (part.max(0) * 1000).checked_div(whole).map_or(0, |share| share as u32)
}
