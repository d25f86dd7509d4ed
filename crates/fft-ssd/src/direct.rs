//! The direct engine: sums of products by the kernels, four rows of positions at a time.
//!
//! With `t' = t - 128` and source values `I` (0 where not valid),
//! `(t - I)^2 = t'^2 + 256 t' - 2 t' I + (I - 128)^2` on valid samples, so a cost is a constant of the template, twice
//! a correlation of bytes with signed bytes, and a sum over the mask that a table gives. Takes
//! `O(samples * positions)`.

use crate::Error;
use crate::axes::Shape;
use crate::job::Job;
use crate::kernel::{Block, CHUNK, Row};
use crate::memory::push;
use crate::pack::Packed;
use crate::prepared::Squares;
use crate::sums::{Corners, Table};
use crate::taps::{Image, ROWS, Taps};
use crate::template::Checked;
use crate::word::Word;

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
    let direct = Direct::new(job, &[*job.template], scratch)?;
    job.each_part(map, ROWS, cost(job), |t, y, part| {
        let mut buffers = Buffers::default();
        direct.chunks([t, y], part, |from, rows| {
            direct.products(&from, &mut buffers);
            rows.each(|r, row| direct.finish(&from, r, &buffers.products, row));
        });
    });
    Ok(())
}

/// Templates of one shape, over one source, whose errors count equally often.
pub(crate) struct Weighted<'a> {
    /// Of the first template.
    pub(crate) job: Job<'a>,
    pub(crate) templates: &'a [Checked<'a>],
    pub(crate) weight: u32,
}

/// The weighted sum of the costs of all terms, of which each fits 32 bits, at every position. All look at the same
/// positions; the sum is taken chunk by chunk, so that it costs no more memory than its own.
pub(crate) fn search_sum(terms: &[Weighted<'_>], scratch: &mut [DirectScratch], map: &mut [u64]) -> Result<(), Error> {
    let mut sums = Vec::new();
    for (term, scratch) in terms.iter().zip(scratch) {
        push(&mut sums, (Direct::<u32>::new(&term.job, term.templates, scratch)?, term.weight))?;
    }
    let Some((first, _)) = sums.first() else { return Ok(()) };
    let nanoseconds = terms.iter().map(|term| cost(&term.job)).sum();
    first.job.each_part(map, ROWS, nanoseconds, |t, y, part| {
        let mut buffers = Buffers::default();
        first.chunks([t, y], part, |from, rows| {
            for (i, (direct, weight)) in sums.iter().enumerate() {
                direct.products(&from, &mut buffers);
                let Buffers { products, errors, .. } = &mut buffers;
                let errors = &mut errors[..from.n];
                rows.each(|r, row| {
                    direct.finish(&from, r, products, errors);
                    if i == 0 {
                        direct.job.kernel.weigh(row, errors, *weight);
                    } else {
                        direct.job.kernel.add(row, errors, *weight);
                    }
                });
            }
        });
    });
    Ok(())
}

/// About how many nanoseconds a search takes.
pub(crate) fn cost(job: &Job<'_>) -> f64 {
    let positions: f64 = job.range.count.iter().map(|&n| n as f64).product();
    let products = job.template.samples as f64 * job.kernel.products(job.weights);
    // Validity of any shape takes plain loops where the template's own part varies.
    let loops = if job.varies() && !job.prepared.is_box { job.template.samples as f64 } else { 0.0 };
    positions * (1.0 + products + loops)
}

/// One source and what is multiplied with it.
struct Direct<'a, W> {
    job: &'a Job<'a>,
    image: &'a Packed,
    table: &'a Table<W>,
    taps: &'a Taps,
    corners: &'a Corners,
    constant: W,
}

/// Neighbouring positions of up to four rows.
#[derive(Clone, Copy)]
struct Chunk {
    /// Frame, row and column of the first.
    at: Shape,
    /// Positions of a row.
    n: usize,
}

/// What is computed of a chunk; kept from one to the next, for clearing it would take a while. It begins at a cache
/// line (and so does each row), or where it lay on the stack would decide whether every vector crosses two.
#[repr(align(64))]
struct Buffers<W> {
    products: [[W; CHUNK]; ROWS],
    sums: Block,
    errors: [W; CHUNK],
}

impl<W: Word> Default for Buffers<W> {
    fn default() -> Self {
        Self { products: [[W::ZERO; CHUNK]; ROWS], sums: [[0; CHUNK]; ROWS], errors: [W::ZERO; CHUNK] }
    }
}

/// The rows of a map under a chunk.
struct Rows<'m, W> {
    rows: &'m mut [W],
    width: usize,
    chunk: Chunk,
}

impl<W> Rows<'_, W> {
    /// Calls `f(number, positions)` for each row.
    fn each(&mut self, mut f: impl FnMut(usize, &mut [W])) {
        let Chunk { at: [_, _, x], n } = self.chunk;
        self.rows.chunks_mut(self.width).enumerate().for_each(|(r, row)| f(r, &mut row[x..x + n]));
    }
}

impl<'a, W: Word + Squares> Direct<'a, W> {
    /// Prepares the sum of some templates of the job's shape.
    fn new(job: &'a Job<'a>, templates: &[Checked<'_>], scratch: &'a mut DirectScratch) -> Result<Self, Error> {
        let image = job.prepared.packed(job.source, job.weights.len(), job.kernel.lanes())?;
        let table = W::table(job.prepared, job.source, job.weights)?;
        let to = Image { packed: image, weights: job.weights, height: job.prepared.extension.shape[1] };
        scratch.taps.build(templates, &to, size_of::<W>() == 8)?;
        scratch.corners.of_masks(templates, table.shape)?;
        let constants = templates.iter().map(|template| Job { template, ..*job }.constant(BIAS));
        let constant = W::wrapping(constants.fold(0, i64::wrapping_add));
        Ok(Self { job, image, table, taps: &scratch.taps, corners: &scratch.corners, constant })
    }
}

impl<W: Word> Direct<'_, W> {
    /// Calls `f` for all chunks of up to [`ROWS`] rows, which begin at a frame and row.
    fn chunks<T>(&self, [t, y]: [usize; 2], rows: &mut [T], mut f: impl FnMut(Chunk, &mut Rows<'_, T>)) {
        let width = self.job.range.count[2];
        // Chunks of about equal width, in steps of a vector: a narrow last one would leave multipliers idle.
        let step = width.div_ceil(width.div_ceil(CHUNK)).next_multiple_of(16);
        for x in (0..width).step_by(step) {
            let chunk = Chunk { at: [t, y, x], n: step.min(width - x) };
            f(chunk, &mut Rows { rows, width, chunk });
        }
    }

    /// Correlations, times -2, at the positions of a chunk.
    fn products(&self, chunk: &Chunk, to: &mut Buffers<W>) {
        let [t, y, x] = chunk.at;
        let base = (t * self.job.prepared.extension.shape[1] + y) * self.image.width + x;
        if self.taps.groups.is_empty() {
            to.products = [[W::ZERO; CHUNK]; ROWS];
        }
        for (number, group) in self.taps.groups.iter().enumerate() {
            self.job.kernel.correlate(&self.image.words, base, self.taps, number, chunk.n, &mut to.sums);
            for (products, sums) in to.products.iter_mut().zip(&to.sums) {
                let (products, sums) = (&mut products[..chunk.n], &sums[..chunk.n]);
                self.job.kernel.scale(products, sums, W::wrapping(-2 * group.scale), number != 0);
            }
        }
    }

    /// Errors of one row of a chunk, from its products.
    fn finish(&self, chunk: &Chunk, r: usize, products: &[[W; CHUNK]; ROWS], to: &mut [W]) {
        let [t, y, x] = chunk.at;
        let from = (t * self.table.shape[1] + y + r) * self.table.shape[2] + x;
        let corners = Row { table: &self.table.sums[from..], plus: &self.corners.plus, minus: &self.corners.minus };
        self.job.kernel.finish(to, self.constant, &corners, &products[r][..chunk.n]);
    }
}
