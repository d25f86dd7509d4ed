//! A block of a template over all tiles: products, inverse transforms, rounding, and what is added to each position.

use super::bound::LIMIT;
use super::size::Window;
use super::spectra::Spectra;
use super::transform::C64;
use super::workers::{self, Worker, deal};
use super::{FftScratch, Term, signals};
use crate::Error;
use crate::axes::Shape;
use crate::job::Job;
use crate::kernel::{CHUNK, Row};
use crate::sums::Corners;
use crate::taps::ROWS;
use crate::template::Checked;
use crate::word::Word;

/// Columns lie this many values more apart than they are long: at a power of two, all their rows would fall into one
/// set of the first-level cache.
const GAP: usize = 4;

/// A part of a template, and the positions it is asked about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// First sample of the template.
    pub(super) start: Shape,
    /// Samples before this belong to an earlier block.
    pub(super) fresh: Shape,
    pub(super) shape: Shape,
    pub(super) window: Window,
}

impl Block {
    /// Calls `f` with the index of each sample of the block that counts.
    pub(super) fn each(&self, template: &Checked<'_>, mut f: impl FnMut(usize)) {
        for t in self.fresh[0]..self.start[0] + self.shape[0] {
            for y in self.fresh[1]..self.start[1] + self.shape[1] {
                let row = (t * template.shape[1] + y) * template.shape[2];
                let samples = row + self.fresh[2]..row + self.start[2] + self.shape[2];
                samples.filter(|&i| template.counts(i)).for_each(&mut f);
            }
        }
    }

    /// Row `y` of frame `t` of a term's signal of the template.
    fn load(&self, job: &Job<'_>, term: Term, t: usize, y: usize, to: &mut [f64]) {
        let (t, y) = (self.start[0] + t, self.start[1] + y);
        if t < self.fresh[0] || y < self.fresh[1] {
            return;
        }
        let row = (t * job.template.shape[1] + y) * job.template.shape[2];
        for x in self.fresh[2]..self.start[2] + self.shape[2] {
            if job.template.counts(row + x) {
                to[x - self.start[2]] = term.value(job, row + x);
            }
        }
    }
}

/// What stands at a position beside the correlations.
pub(super) struct Finish<'a, W> {
    pub(super) constant: W,
    /// A table and its shape; empty if no corners are.
    pub(super) table: &'a [W],
    pub(super) shape: Shape,
    pub(super) corners: &'a Corners,
}

impl<W: Word> Finish<'_, W> {
    /// The corners for positions from `at` on.
    fn row(&self, at: Shape) -> Row<'_, W> {
        let from = (at[0] * self.shape[1] + at[1]) * self.shape[2] + at[2];
        Row { table: self.table.get(from..).unwrap_or(&[]), plus: &self.corners.plus, minus: &self.corners.minus }
    }
}

/// Up to four rows of one tile of the map.
struct Rows<'m, W> {
    /// The tile, counted from the batch's first.
    tile: usize,
    /// First row, in the tile.
    t: usize,
    y: usize,
    /// First position, in the map.
    at: Shape,
    rows: [&'m mut [W]; ROWS],
}

/// Writes (`first`) or adds a block's correlations. False if a value was too far from an integer.
#[expect(clippy::too_many_arguments, reason = "one call, from the engine's loop over blocks")]
pub(super) fn correlate<W: Word>(
    job: &Job<'_>,
    terms: &[Term],
    block: &Block,
    spectra: &Spectra,
    finish: &Finish<'_, W>,
    first: bool,
    scratch: &mut FftScratch,
    map: &mut [W],
) -> Result<bool, Error> {
    let (tiling, transforms) = (&spectra.tiling, &spectra.transforms);
    let kept = spectra.fits(job.cache, terms.len());
    let signals = signals(job);
    if kept {
        for term in terms {
            spectra.get(term.signal(), &signals, &mut scratch.workers)?;
        }
    }
    let FftScratch { workers, rows, template, columns, transient, .. } = scratch;
    workers::prepare(workers, transforms);
    workers.iter_mut().for_each(|w| w.residual = 0.0);
    let len = transforms.len();
    crate::costs::fit(template, terms.len() * len)?;
    let load = |term: usize, t: usize, y: usize, row: &mut [f64]| block.load(job, terms[term], t, y, row);
    transforms.forward(terms.len(), [block.shape[0], block.shape[1]], load, rows, template, workers);

    let mut tasks = tasks(job, block, spectra, map);
    let (batch, column) = (workers.len(), transforms.column());
    let stride = column + GAP;
    let mut tasks = tasks.as_mut_slice();
    for tile in (0..tiling.n_tiles()).step_by(batch) {
        let tiles = batch.min(tiling.n_tiles() - tile);
        if !kept {
            crate::costs::fit(transient, tiles * terms.len() * len)?;
            for (i, spectrum) in transient.chunks_mut(len).enumerate() {
                spectra.tile(
                    tile + i / terms.len(),
                    terms[i % terms.len()].signal(),
                    &signals,
                    rows,
                    spectrum,
                    workers,
                );
            }
        }
        let spectrum = |term: usize, t: usize, kx: usize| -> &[C64] {
            let (all, at) = match spectra.kept(terms[term].signal(), job.weights.len()).filter(|_| kept) {
                Some(all) => (all, (tile + t) * len),
                None => (transient.as_slice(), (t * terms.len() + term) * len),
            };
            &all[at + kx * column..][..column]
        };
        crate::costs::fit(columns, tiles * transforms.half() * stride)?;
        deal(columns, stride, workers, |number, to, worker| {
            let (t, kx) = (number / transforms.half(), number % transforms.half());
            let to = &mut to[..column];
            for term in 0..terms.len() {
                let own = &template[(term * transforms.half() + kx) * column..][..column];
                job.kernel.multiply(to, own, spectrum(term, t, kx), term == 0);
            }
            let answered = tiling.hop[0].min(block.window.count[0] - tiling.origin(tile + t)[0]);
            transforms.inverse_column(to, answered, worker);
        });
        let (these, others) = tasks.split_at_mut(tasks.iter().take_while(|r| r.tile < tile + tiles).count());
        tasks = others;
        let pass = Pass { job, spectra, finish, first, columns, stride, tile };
        deal(these, 1, workers, |_, rows, worker| pass.rows(&mut rows[0], worker));
    }
    Ok(workers.iter().all(|w| w.residual < LIMIT))
}

/// The map's rows, four by four, tile by tile.
fn tasks<'m, W: Word>(job: &Job<'_>, block: &Block, spectra: &Spectra, map: &'m mut [W]) -> Vec<Rows<'m, W>> {
    let (tiling, window) = (&spectra.tiling, &block.window);
    let [_, height, width] = job.range.count;
    let mut list: Vec<Rows<'m, W>> = Vec::new();
    let mut first = Vec::new();
    let groups = |tile: usize| {
        let origin = tiling.origin(tile);
        let answered = [0, 1].map(|a: usize| tiling.hop[a].min(window.count[a] - origin[a]));
        (origin, answered[0], answered[1].div_ceil(ROWS))
    };
    for tile in 0..tiling.n_tiles() {
        first.push(list.len());
        let (origin, frames, groups) = groups(tile);
        for i in 0..frames * groups {
            let (t, y) = (i / groups, i % groups * ROWS);
            let local = [t, y, 0];
            let at = [0, 1, 2].map(|a: usize| window.first[a] + origin[a] + local[a]);
            list.push(Rows { tile, t, y, at, rows: std::array::from_fn(|_| <&mut [W]>::default()) });
        }
    }
    for (i, row) in map.chunks_mut(width).enumerate() {
        let (t, y) = ((i / height).wrapping_sub(window.first[0]), (i % height).wrapping_sub(window.first[1]));
        if window.count[0] <= t || window.count[1] <= y {
            continue;
        }
        let (tile_t, tile_y) = (t / tiling.hop[0], y / tiling.hop[1]);
        let row = &mut row[window.first[2]..window.first[2] + window.count[2]];
        for (tile_x, part) in row.chunks_mut(tiling.hop[2]).enumerate() {
            let tile = (tile_t * tiling.tiles[1] + tile_y) * tiling.tiles[2] + tile_x;
            let (origin, _, groups) = groups(tile);
            let (t, y) = (t - origin[0], y - origin[1]);
            list[first[tile] + t * groups + y / ROWS].rows[y % ROWS] = part;
        }
    }
    list
}

/// The last pass of a batch of tiles.
struct Pass<'a, W> {
    job: &'a Job<'a>,
    spectra: &'a Spectra,
    finish: &'a Finish<'a, W>,
    first: bool,
    columns: &'a [C64],
    stride: usize,
    /// The batch's first tile.
    tile: usize,
}

impl<W: Word> Pass<'_, W> {
    /// Four rows: gathers them from the columns, two by two into a complex row, and back to positions.
    fn rows(&self, task: &mut Rows<'_, W>, worker: &mut Worker) {
        let transforms = &self.spectra.transforms;
        let [_, height, width] = transforms.size;
        let Worker { line, second, scratch, residual, .. } = worker;
        let (line, second) = (&mut line[..width], &mut second[..width]);
        let from = (task.tile - self.tile) * transforms.half() * self.stride + task.t * height + task.y;
        // Below the last row lie values of no meaning, which must not enter a row's partner.
        let there = ROWS.min(height - task.y);
        for k in 0..transforms.half() {
            let mut column = [C64::default(); ROWS];
            column[..there].copy_from_slice(&self.columns[from + k * self.stride..][..there]);
            join(line, k, column[0], column[1]);
            join(second, k, column[2], column[3]);
        }
        for (i, z) in [line, second].into_iter().enumerate() {
            let rows = &mut task.rows[2 * i..2 * i + 2];
            if rows[0].is_empty() {
                break;
            }
            transforms.inverse_row(z, scratch);
            *residual = residual.max(self.two(z, [task.at[0], task.at[1] + 2 * i, task.at[2]], rows));
        }
    }

    /// Rounds two rows of positions (the second may be empty) and finishes them.
    fn two(&self, z: &[C64], at: Shape, rows: &mut [&mut [W]]) -> f64 {
        let scale = 1.0 / self.spectra.tiling.size.iter().product::<usize>() as f64;
        let mut residual: f64 = 0.0;
        for (number, z) in z[..rows[0].len()].chunks(CHUNK).enumerate() {
            let mut rounded = [[W::ZERO; CHUNK]; 2];
            residual = residual.max(self.job.kernel.round(z, scale, &mut rounded));
            for (r, row) in rows.iter_mut().enumerate().filter(|(_, row)| !row.is_empty()) {
                let x = number * CHUNK;
                let out = &mut row[x..x + z.len()];
                if self.first {
                    let corners = self.finish.row([at[0], at[1] + r, at[2] + x]);
                    self.job.kernel.finish(out, self.finish.constant, &corners, &rounded[r][..z.len()]);
                } else {
                    out.iter_mut().zip(&rounded[r]).for_each(|(out, &more)| *out = out.plus(more));
                }
            }
        }
        residual
    }
}

/// Puts frequency `k` of two real rows `a` and `b` into the spectrum of `a + i b`.
#[inline]
fn join(z: &mut [C64], k: usize, a: C64, b: C64) {
    let n = z.len();
    if k != 0 && 2 * k != n {
        z[n - k] = C64::new(a.re + b.im, b.re - a.im);
    }
    z[k] = C64::new(a.re - b.im, a.im + b.re);
}
