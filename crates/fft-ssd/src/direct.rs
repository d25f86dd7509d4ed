//! The direct engine: sums of products by the kernels, four rows of positions at a time.
//!
//! With `t' = t - 128` and source values `I` (0 where not valid),
//! `(t - I)^2 = t'^2 + 256 t' - 2 t' I + (I - 128)^2` on valid samples, so a cost is a constant of the template, twice a
//! correlation of bytes with signed bytes, and a sum over the mask that a table gives. Takes `O(samples * positions)`.

use crate::Error;
use crate::job::Job;
use crate::kernel::{Block, CHUNK, Row};
use crate::pack::Packed;
use crate::prepared::Squares;
use crate::sums::{Corners, Table};
use crate::taps::{ROWS, Taps};
use crate::word::Word;
use selvedge_core::par;

/// What a template's own value adds beside its square: see [`Job::own`].
pub(crate) const BIAS: i64 = 256;

/// Working memory of the direct engine.
#[derive(Debug, Default)]
pub(crate) struct DirectScratch {
    taps: Taps,
    corners: Corners,
}

/// Costs of every position; those whose number of compared samples varies still lack the template's own part.
pub(crate) fn search<W: Word + Squares>(
    job: &Job<'_>,
    scratch: &mut DirectScratch,
    map: &mut [W],
) -> Result<(), Error> {
    let image = job.prepared.packed(job.source, job.weights.len(), job.kernel.lanes())?;
    let table = W::table(job.prepared, job.source, job.weights)?;
    let height = job.prepared.extension.shape[1];
    scratch.taps.build(job.template, job.weights, image, height, size_of::<W>() == 8);
    scratch.corners.of_mask(job.template, table.shape);
    let direct = Direct {
        job,
        image,
        table,
        taps: &scratch.taps,
        corners: &scratch.corners,
        constant: W::wrapping(job.constant(BIAS)),
    };
    let task = job.task(ROWS);
    par::for_rows(map, task, |number, part| direct.rows(task, number, part));
    Ok(())
}

struct Direct<'a, W> {
    job: &'a Job<'a>,
    image: &'a Packed,
    table: &'a Table<W>,
    taps: &'a Taps,
    corners: &'a Corners,
    constant: W,
}

impl<W: Word> Direct<'_, W> {
    /// The rows of one task, four at a time.
    fn rows(&self, task: usize, number: usize, part: &mut [W]) {
        let width = self.job.range.count[2];
        let first = number * task / width;
        for (i, rows) in part.chunks_mut(ROWS * width).enumerate() {
            let row = first + i * ROWS;
            let height = self.job.range.count[1];
            self.block(row / height, row % height, rows);
        }
    }

    /// Up to four rows from row `y` of frame `t` on.
    fn block(&self, t: usize, y: usize, rows: &mut [W]) {
        let width = self.job.range.count[2];
        let [_, height, _] = self.job.prepared.extension.shape;
        for x in (0..width).step_by(CHUNK) {
            let n = CHUNK.min(width - x);
            let products = self.products((t * height + y) * self.image.width + x, n);
            for (r, row) in rows.chunks_mut(width).enumerate() {
                let from = (t * self.table.shape[1] + y + r) * self.table.shape[2] + x;
                let corners =
                    Row { table: &self.table.sums[from..], plus: &self.corners.plus, minus: &self.corners.minus };
                self.job.kernel.finish(&mut row[x..x + n], self.constant, &corners, &products[r][..n]);
            }
        }
    }

    /// Correlations, times -2, at `n` positions of four rows, the first at word `base`.
    fn products(&self, base: usize, n: usize) -> [[W; CHUNK]; ROWS] {
        let mut products = [[W::ZERO; CHUNK]; ROWS];
        let mut sums: Block = [[0; CHUNK]; ROWS];
        for (number, group) in self.taps.groups.iter().enumerate() {
            self.job.kernel.correlate(&self.image.words, base, self.taps, number, n, &mut sums);
            for (product, &sum) in products.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
                *product = product.plus(W::wrapping(-2 * i64::from(sum) * group.scale));
            }
        }
        products
    }
}
