//! The same walk for errors that are scaled by where they lie: what is nearest to each position, and windows by their
//! scaled errors.

use super::super::comparison::Comparison;
use super::super::joined;
use super::super::scale::{Best, factor};
use super::{Shift, Walk};
use crate::Error;
use crate::kernel::{Kernel, SHIFTS};
use selvedge_core::{par, try_vec};
use std::ops::Range;

/// Parts of a picture whose nearest windows are looked for beside each other: each holds an error for every position,
/// so that more would take more memory than they bring threads.
const PARTS: usize = 8;

/// For each position of the source, row by row, the error of the most similar window of the picture; all ones where
/// none can stand.
pub(in crate::nearest) fn least(comparison: Comparison<'_>, kernel: Kernel) -> Result<Vec<u64>, Error> {
    let walk = Walk::new(comparison, kernel)?;
    let least = walk.least()?;
    let [rows, columns] = walk.offered;
    let at = |i: usize| match least[walk.barred.at(i / columns, (i % columns) as isize)] {
        u32::MAX => u64::MAX,
        error => u64::from(error),
    };
    Ok((0..rows * columns).map(at).collect())
}

/// For each window of the picture the position of least error times [`factor`] of what `least` says of the position.
pub(in crate::nearest) fn scaled(
    comparison: Comparison<'_>,
    (least, added): (&[u64], f64),
    kernel: Kernel,
) -> Result<Vec<Best>, Error> {
    let walk = Walk::new(comparison, kernel)?;
    let mut factors = try_vec(walk.barred.marks().len(), f32::INFINITY)?;
    for (i, &error) in least.iter().enumerate() {
        let columns = walk.offered[1];
        factors[walk.barred.at(i / columns, (i % columns) as isize)] = factor(error, added);
    }
    walk.scaled(&factors)
}

impl Walk {
    fn least(&self) -> Result<Vec<u32>, Error> {
        let bands = self.bands();
        let each = bands.div_ceil(PARTS).max(1);
        let part = |part: usize| {
            let mut least = try_vec(self.barred.marks().len(), u32::MAX)?;
            for band in part * each..bands.min((part + 1) * each) {
                let rows = self.rows(band);
                self.walk(rows.clone(), |row, columns, windows, shift| {
                    let at = self.position(&rows, row, &columns, shift);
                    self.kernel.lower_places(windows, columns.len(), &mut least[at..]);
                })?;
            }
            Ok::<_, Error>(least)
        };
        let mut parts = par::map_indexed(bands.div_ceil(each), part).into_iter();
        let mut all = parts.next().unwrap_or_else(|| Ok(try_vec(self.barred.marks().len(), u32::MAX)?))?;
        for part in parts {
            all.iter_mut().zip(part?).for_each(|(a, b)| *a = b.min(*a));
        }
        Ok(all)
    }

    fn scaled(&self, factors: &[f32]) -> Result<Vec<Best>, Error> {
        let band = |b: usize| {
            let rows = self.rows(b);
            let n = rows.len() * self.asked[1];
            let mut best = try_vec(n, [f32::INFINITY; SHIFTS])?;
            let mut codes = try_vec(n, [0_u32; SHIFTS])?;
            self.walk(rows.clone(), |row, columns, windows, shift| {
                let from = self.position(&rows, row, &columns, shift);
                let of = row * self.asked[1] + columns.start..row * self.asked[1] + columns.end;
                let (best, codes) = (&mut best[of.clone()], &mut codes[of]);
                self.kernel.lower_scaled(windows, &factors[from..], shift.number, best, codes);
            })?;
            let answer = |i: usize| {
                let (row, column) = (rows.start + i / self.asked[1], i % self.asked[1]);
                let lanes = (0..SHIFTS).filter(|&l| best[i][l] != f32::INFINITY);
                let all = lanes.map(|l| (best[i][l], self.place(row, column, codes[i][l], l)));
                all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            };
            Ok((0..n).map(answer).collect())
        };
        joined(par::map_indexed(self.bands(), band), self.asked[0] * self.asked[1])
    }

    /// Where the mark of the first window's position lies, at the first of the displacements.
    fn position(&self, rows: &Range<usize>, row: usize, columns: &Range<usize>, shift: Shift) -> usize {
        let y = ((rows.start + row) * self.step) as isize + shift.y;
        self.barred.at(y as usize, (columns.start * self.step) as isize + shift.x)
    }
}
