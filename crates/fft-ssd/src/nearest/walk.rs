//! All windows against all positions, displacement by displacement.

mod scaled;

pub(super) use scaled::{least, scaled};

use super::comparison::Comparison;
use super::field::{Asked, Barred, Continued, Offered, groups};
use super::{Best, joined};
use crate::Error;
use crate::kernel::{self, Cells, Kernel, Lanes, SHIFTS};
use selvedge_core::{Domain, par, try_vec};
use std::ops::Range;

/// Rows of windows that are done together: their running answers stay in the second cache, and the cells above and
/// below them that other bands need too are few.
const BAND: usize = 16;

/// Error and position of the nearest window of one source, for each window.
pub(super) fn nearest(comparison: Comparison<'_>, kernel: Kernel) -> Result<Vec<Best>, Error> {
    Walk::new(comparison, kernel)?.nearest()
}

/// How many windows of the picture itself are like each window.
pub(super) fn alike(comparison: Comparison<'_>, error: u64, apart: u32, kernel: Kernel) -> Result<Vec<u32>, Error> {
    Walk::new(comparison, kernel)?.alike(error, apart)
}

struct Walk {
    kernel: Kernel,
    /// Words of picture and source by group of channels, with the group's weight.
    groups: Vec<(u32, Asked, Offered)>,
    barred: Barred,
    /// Rows and columns of windows, and of their positions in the source.
    asked: [usize; 2],
    offered: [usize; 2],
    /// Shape of the source, continued.
    source: [usize; 2],
    /// After which displacements it repeats itself.
    periods: [Option<usize>; 2],
    step: usize,
    /// Cells along a window's side.
    cells: usize,
}

/// One displacement of a vector's first lane, and which it is in the order of all.
#[derive(Clone, Copy)]
struct Shift {
    y: isize,
    x: isize,
    number: u32,
}

/// Sums of one band and displacement.
struct Sums {
    row: Vec<Lanes>,
    ring: Vec<Vec<Lanes>>,
    columns: Vec<Lanes>,
}

impl Walk {
    fn new(comparison: Comparison<'_>, kernel: Kernel) -> Result<Self, Error> {
        let Comparison { picture, source, weights, windows } = comparison;
        let (domain, step) = (source.features.domain(), windows.step as usize);
        let (positions, asked) = (comparison.offered(), comparison.asked());
        let picture = Continued::new(picture, asked, windows, windows.step);
        let continued = Continued::new(source, positions, windows, 1);
        let words = |group: super::field::Group| -> Result<_, Error> {
            Ok((group.weight, Asked::new(&picture, &group, step)?, Offered::new(&continued, &group, step)?))
        };
        Ok(Self {
            kernel,
            groups: groups(weights, step).into_iter().map(words).collect::<Result<_, _>>()?,
            barred: Barred::new(&continued, positions, windows.side as usize)?,
            asked: lengths(asked),
            offered: lengths(positions),
            source: continued.shape,
            periods: [0, 1].map(|a| domain.periodic[a].then_some(domain.shape[a] as usize)),
            step,
            cells: windows.side as usize / step,
        })
    }

    fn nearest(&self) -> Result<Vec<Best>, Error> {
        let band = |b: usize| {
            let rows = self.rows(b);
            let n = rows.len() * self.asked[1];
            let mut best = try_vec(n, [u32::MAX; SHIFTS])?;
            let mut codes = try_vec(n, [0_u32; SHIFTS])?;
            self.walk(rows.clone(), |row, columns, windows, shift| {
                let at = row * self.asked[1];
                let (best, codes) =
                    (&mut best[at + columns.start..at + columns.end], &mut codes[at + columns.start..at + columns.end]);
                self.kernel.lower(windows, shift.number, best, codes);
            })?;
            let answer = |i: usize| self.answer(rows.start + i / self.asked[1], i % self.asked[1], &best[i], &codes[i]);
            Ok((0..n).map(answer).collect())
        };
        joined(par::map_indexed(self.bands(), band), self.asked[0] * self.asked[1])
    }

    fn alike(&self, error: u64, apart: u32) -> Result<Vec<u32>, Error> {
        let most = u32::try_from(error).unwrap_or(u32::MAX).min(u32::MAX - 1);
        let near = |axis: usize, by: isize| {
            let away = match self.periods[axis] {
                Some(n) => (by.rem_euclid(n as isize) as usize).min((-by).rem_euclid(n as isize) as usize),
                None => by.unsigned_abs(),
            };
            away < apart as usize
        };
        let band = |b: usize| {
            let rows = self.rows(b);
            let mut counts = try_vec(rows.len() * self.asked[1], [0_u32; SHIFTS])?;
            self.walk(rows, |row, columns, windows, shift| {
                let at = row * self.asked[1];
                let is_near = near(0, shift.y);
                let skip =
                    std::array::from_fn(|lane| if is_near && near(1, shift.x + lane as isize) { u32::MAX } else { 0 });
                self.kernel.count(windows, &skip, most, &mut counts[at + columns.start..at + columns.end]);
            })?;
            Ok(counts.iter().map(|c| c.iter().sum()).collect())
        };
        joined(par::map_indexed(self.bands(), band), self.asked[0] * self.asked[1])
    }

    fn bands(&self) -> usize {
        self.asked[0].div_ceil(BAND)
    }

    fn rows(&self, band: usize) -> Range<usize> {
        band * BAND..self.asked[0].min((band + 1) * BAND)
    }

    /// Displacements of vectors: rows from, rows to, columns from, and vectors a row.
    fn shifts(&self) -> ([isize; 2], usize) {
        let reach = |axis: usize| self.asked[axis].saturating_sub(1) * self.step;
        let first = [-(reach(0) as isize), -(reach(1) as isize)];
        (first, (reach(1) + self.offered[1]).div_ceil(SHIFTS))
    }

    /// Calls `fold(row, columns, windows, shift)` for each row of a band (from 0) and those of its windows that a
    /// displacement takes into the source: in the order of positions for each window and lane.
    fn walk(
        &self,
        rows: Range<usize>,
        mut fold: impl FnMut(usize, Range<usize>, &kernel::Windows<'_>, Shift),
    ) -> Result<(), Error> {
        if self.offered.contains(&0) || self.asked[1] == 0 {
            return Ok(());
        }
        let (first, vectors) = self.shifts();
        let cells = self.asked[1] + self.cells - 1;
        let row = try_vec(cells, [0; SHIFTS])?;
        let ring = (0..self.cells).map(|_| try_vec(cells, [0; SHIFTS])).collect::<Result<_, _>>()?;
        let mut sums = Sums { ring, columns: row.clone(), row };
        for y in first[0]..self.offered[0] as isize {
            for vector in 0..vectors {
                let number = (y - first[0]) as u32 * vectors as u32 + vector as u32;
                let shift = Shift { y, x: first[1] + (vector * SHIFTS) as isize, number };
                self.at(rows.clone(), shift, &mut sums, &mut fold);
            }
        }
        Ok(())
    }

    /// One displacement: row after row of cells.
    fn at(
        &self,
        rows: Range<usize>,
        shift: Shift,
        sums: &mut Sums,
        fold: &mut impl FnMut(usize, Range<usize>, &kernel::Windows<'_>, Shift),
    ) {
        let columns = within(self.step, shift.x, SHIFTS, self.offered[1], 0..self.asked[1]);
        let rows_of_cells = rows.start..rows.end + self.cells - 1;
        let inside = within(self.step, shift.y, 1, self.source[0] + 1 - self.step, rows_of_cells);
        if columns.is_empty() || inside.len() < self.cells {
            return;
        }
        let n = columns.len() + self.cells - 1;
        sums.columns[..n].fill([0; SHIFTS]);
        sums.ring.iter_mut().for_each(|r| r[..n].fill([0; SHIFTS]));
        for (done, j) in inside.clone().enumerate() {
            self.sum_cells(j, columns.start, shift, &mut sums.row[..n]);
            self.kernel.slide(&mut sums.columns[..n], &sums.row[..n], &mut sums.ring[done % self.cells][..n]);
            if self.cells <= done + 1 {
                let row = j + 1 - self.cells;
                let y = (row * self.step) as isize + shift.y;
                let marks = self.barred.row(y as usize, (columns.start * self.step) as isize + shift.x);
                let (columns_of, cells, step) = (&sums.columns[..n], self.cells, self.step);
                let windows = kernel::Windows { columns: columns_of, cells, marks, step };
                fold(row - rows.start, columns.clone(), &windows, shift);
            }
        }
    }

    /// Cells of one row from a column on.
    fn sum_cells(&self, row: usize, column: usize, shift: Shift, to: &mut [Lanes]) {
        for (number, (weight, asked, offered)) in self.groups.iter().enumerate() {
            let y = ((row * self.step) as isize + shift.y) as usize;
            let x = ((column * self.step + SHIFTS) as isize + shift.x) as usize;
            let first = (row * asked.columns + column) * asked.taps;
            let range = first..first + to.len() * asked.taps;
            let cells = Cells {
                source: &offered.words[y * offered.width + x..],
                offsets: &offered.offsets,
                step: self.step,
                words: &asked.words[range.clone()],
                masks: asked.masks.get(range).unwrap_or(&[]),
                weight: *weight,
                more: number != 0,
            };
            self.kernel.cells(&cells, to);
        }
        if self.groups.is_empty() {
            to.fill([0; SHIFTS]);
        }
    }

    /// The best of all lanes of a window; of equal ones the first position.
    fn answer(&self, row: usize, column: usize, best: &Lanes, codes: &Lanes) -> Best {
        let lane = |lane: usize| (u64::from(best[lane]), self.place(row, column, codes[lane], lane));
        (0..SHIFTS).filter(|&l| best[l] != u32::MAX).map(lane).min()
    }

    /// The position in the source that a window has at a displacement.
    fn place(&self, row: usize, column: usize, code: u32, lane: usize) -> [u32; 2] {
        let (first, vectors) = self.shifts();
        let y = (row * self.step + code as usize / vectors) as isize + first[0];
        let x = (column * self.step + code as usize % vectors * SHIFTS + lane) as isize + first[1];
        [y as u32, x as u32]
    }
}

fn lengths(domain: Domain<2>) -> [usize; 2] {
    domain.shape.map(|n| n as usize)
}

/// Which of `among`, `step` apart, lie in `0..n` when moved by one of `lanes` displacements from `by` on.
fn within(step: usize, by: isize, lanes: usize, n: usize, among: Range<usize>) -> Range<usize> {
    let (step, lanes, n) = (step as isize, lanes as isize, n as isize);
    let first = (-by - (lanes - 1)).max(0).unsigned_abs().div_ceil(step.unsigned_abs());
    let end = if n <= by { 0 } else { ((n - 1 - by) / step + 1) as usize };
    let start = first.max(among.start);
    start..end.min(among.end).max(start)
}
