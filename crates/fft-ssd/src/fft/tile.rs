//! A block of a template over all tiles: products, inverse transforms, rounding, and what is added to each position.

use std::ops::Range;

use super::size::{Tiling, Window};
use super::spectra::Spectra;
use super::workers::{C64, Worker, deal};
use super::{FftScratch, Term, signals};
use crate::Error;
use crate::axes::Shape;
use crate::job::Job;
use crate::kernel::{CHUNK, Row};
use crate::memory::{fit, reserve};
use crate::sums::Corners;
use crate::taps::ROWS;
use crate::template::Checked;
use crate::word::Word;

/// Columns lie this many values more apart than they are long: at a power of two, all their rows would fall into one
/// set of the first-level cache.
pub(super) const GAP: usize = 4;

/// Values of the columns that a worker has at once: a share of the second-level cache.
const BATCH: usize = 1 << 16;

/// Tiles that are transformed back together.
pub(super) fn batch(half: usize, column: usize, threads: usize) -> usize {
    threads * (BATCH / (half * (column + GAP))).max(1)
}

/// A part of a template, and the positions it is asked about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// First sample of the template.
    pub(super) start: Shape,
    /// Samples before this belong to an earlier block,
    pub(super) fresh: Shape,
    /// and from this on to a later one.
    pub(super) end: Shape,
    pub(super) shape: Shape,
    pub(super) window: Window,
}

impl Block {
    /// The same box with one half of its samples each; `None` if it has but one.
    pub(super) fn halves(self) -> Option<[Self; 2]> {
        let lengths = [0, 1, 2].map(|a: usize| self.end[a] - self.fresh[a]);
        let longest = (0..3).max_by_key(|&a| lengths[a]).filter(|&a| 1 < lengths[a])?;
        let (mut former, mut latter) = (self, self);
        former.end[longest] -= lengths[longest] / 2;
        latter.fresh[longest] = former.end[longest];
        Some([former, latter])
    }

    /// Calls `f` with the index of each sample of the block that counts.
    pub(super) fn each(&self, template: &Checked<'_>, mut f: impl FnMut(usize)) {
        for t in self.fresh[0]..self.end[0] {
            for y in self.fresh[1]..self.end[1] {
                let row = (t * template.shape[1] + y) * template.shape[2];
                let samples = row + self.fresh[2]..row + self.end[2];
                samples.filter(|&i| template.counts(i)).for_each(&mut f);
            }
        }
    }

    /// Row `y` of frame `t` of a plane of a term's signal.
    fn load(&self, job: &Job<'_>, term: Term, plane: usize, t: usize, y: usize, to: &mut [f64]) {
        let (t, y) = (self.start[0] + t, self.start[1] + y);
        if !(self.fresh[0]..self.end[0]).contains(&t) || !(self.fresh[1]..self.end[1]).contains(&y) {
            return;
        }
        let row = (t * job.template.shape[1] + y) * job.template.shape[2];
        for x in self.fresh[2]..self.end[2] {
            if job.template.counts(row + x) {
                to[x - self.start[2]] = term.value(job, plane, row + x);
            }
        }
    }
}

/// A block, how its positions are cut into tiles, and the source's spectra of those.
pub(super) struct Tiled<'a> {
    pub(super) block: Block,
    /// It shares the tiles of the spectra; how many positions a tile answers is its own.
    pub(super) tiling: Tiling,
    pub(super) spectra: &'a Spectra,
    /// The spectra are kept.
    pub(super) kept: bool,
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
pub(super) fn correlate<W: Word>(
    job: &Job<'_>,
    terms: &[Term],
    tiled: &Tiled<'_>,
    finish: &Finish<'_, W>,
    first: bool,
    scratch: &mut FftScratch,
    map: &mut [W],
) -> Result<bool, Error> {
    let &Tiled { ref block, ref tiling, spectra, kept } = tiled;
    let transforms = &spectra.transforms;
    if kept {
        let signals = signals(job);
        for term in terms {
            spectra.get(term.signal(), &signals, &mut scratch.workers)?;
        }
    }
    transforms.prepare(&mut scratch.workers)?;
    scratch.workers.iter_mut().for_each(|w| w.residual = 0.0);
    forward(job, terms, tiled, scratch)?;
    let mut tasks = tasks(job, block, tiling, map)?;
    let mut tasks = tasks.as_mut_slice();
    let stride = transforms.column() + GAP;
    let batch = batch(transforms.half(), transforms.column(), scratch.workers.len());
    for tile in (0..tiling.n_tiles()).step_by(batch) {
        let tiles = batch.min(tiling.n_tiles() - tile);
        if !kept {
            transform_tiles(job, terms, tiled, tile..tile + tiles, scratch)?;
        }
        let FftScratch { workers, templates, columns, transient, .. } = scratch;
        let source = TileColumns { job, terms, spectra, kept, tile, transient };
        fit(columns, tiles * transforms.half() * stride)?;
        // Tiles of one frequency follow each other, so that they find the template's column near.
        deal(columns, stride, workers, |number, to, worker| {
            let (t, kx) = (number % tiles, number / tiles);
            let to = &mut to[..transforms.column()];
            source.multiplied(&templates[..terms.len()], t, kx, to, &mut worker.line);
            let answered = tiling.hop[0].min(block.window.count[0] - tiling.origin(tile + t)[0]);
            transforms.inverse_column(to, answered, worker);
        });
        let (these, others) = tasks.split_at_mut(tasks.iter().take_while(|r| r.tile < tile + tiles).count());
        tasks = others;
        let pass = Pass { job, spectra, finish, first, columns, stride, tile, tiles };
        deal(these, 1, workers, |_, rows, worker| pass.rows(&mut rows[0], worker));
    }
    Ok(scratch.workers.iter().all(|w| w.residual <= scratch.bound))
}

/// The spectrum of the block of each term's template.
fn forward(job: &Job<'_>, terms: &[Term], tiled: &Tiled<'_>, scratch: &mut FftScratch) -> Result<(), Error> {
    let FftScratch { workers, rows, templates, .. } = scratch;
    let (block, transforms) = (&tiled.block, &tiled.spectra.transforms);
    templates.resize_with(terms.len().max(templates.len()), Vec::new);
    for (term, template) in terms.iter().zip(templates) {
        fit(template, term.planes(job) * transforms.len())?;
        let load = |plane: usize, t: usize, y: usize, row: &mut [f64]| block.load(job, *term, plane, t, y, row);
        transforms.forward(term.planes(job), [block.shape[0], block.shape[1]], load, rows, template, workers)?;
    }
    Ok(())
}

/// The source's spectra under a batch of tiles, which nobody keeps.
fn transform_tiles(
    job: &Job<'_>,
    terms: &[Term],
    tiled: &Tiled<'_>,
    tiles: Range<usize>,
    scratch: &mut FftScratch,
) -> Result<(), Error> {
    let FftScratch { workers, rows, transient, .. } = scratch;
    let (spectra, signals) = (tiled.spectra, signals(job));
    transient.resize_with(terms.len().max(transient.len()), Vec::new);
    for (term, transient) in terms.iter().zip(transient) {
        let len = term.planes(job) * spectra.transforms.len();
        fit(transient, tiles.len() * len)?;
        for (tile, spectra_of_tile) in tiles.clone().zip(transient.chunks_mut(len)) {
            spectra.tile(tile, term.signal(), &signals, rows, spectra_of_tile, workers)?;
        }
    }
    Ok(())
}

/// The source's spectra under a batch of tiles, column by column.
struct TileColumns<'a> {
    job: &'a Job<'a>,
    terms: &'a [Term],
    spectra: &'a Spectra,
    kept: bool,
    /// The batch's first tile.
    tile: usize,
    /// Where they are not kept, those of the batch for each term.
    transient: &'a [Vec<C64>],
}

impl TileColumns<'_> {
    /// The planes of one column of a tile of the batch.
    fn of(&self, term: usize, t: usize, kx: usize) -> &[C64] {
        let (transforms, signal) = (&self.spectra.transforms, self.terms[term].signal());
        let of_column = self.terms[term].planes(self.job) * transforms.column();
        let (all, t) = match self.spectra.kept(signal).filter(|_| self.kept) {
            Some(all) => (all, self.tile + t),
            None => (self.transient[term].as_slice(), t),
        };
        &all[(t * transforms.half() + kx) * of_column..][..of_column]
    }

    /// The column's products with those of the templates, summed over planes and terms.
    fn multiplied(&self, templates: &[Vec<C64>], t: usize, kx: usize, to: &mut [C64], line: &mut [C64]) {
        let kernel = self.job.kernel;
        for (term, template) in templates.iter().enumerate() {
            let of_source = self.of(term, t, kx);
            let of_template = &template[kx * of_source.len()..][..of_source.len()];
            if term == 0 {
                kernel.multiply(to, of_template, of_source);
            } else {
                let more = &mut line[..to.len()];
                kernel.multiply(more, of_template, of_source);
                to.iter_mut().zip(more).for_each(|(to, more)| *to += *more);
            }
        }
    }
}

/// The map's rows, four by four, tile by tile.
fn tasks<'m, W: Word>(
    job: &Job<'_>,
    block: &Block,
    tiling: &Tiling,
    map: &'m mut [W],
) -> Result<Vec<Rows<'m, W>>, Error> {
    let window = &block.window;
    let [_, height, width] = job.range.count;
    let mut list: Vec<Rows<'m, W>> = Vec::new();
    let mut first = Vec::new();
    reserve(&mut first, tiling.n_tiles())?;
    let groups = |tile: usize| {
        let origin = tiling.origin(tile);
        let answered = [0, 1].map(|a: usize| tiling.hop[a].min(window.count[a] - origin[a]));
        (origin, answered[0], answered[1].div_ceil(ROWS))
    };
    for tile in 0..tiling.n_tiles() {
        first.push(list.len());
        let (origin, frames, groups) = groups(tile);
        reserve(&mut list, frames * groups)?;
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
    Ok(list)
}

/// The last pass of a batch of tiles.
struct Pass<'a, W> {
    job: &'a Job<'a>,
    spectra: &'a Spectra,
    finish: &'a Finish<'a, W>,
    first: bool,
    columns: &'a [C64],
    stride: usize,
    /// The batch's first tile, and how many it has.
    tile: usize,
    tiles: usize,
}

impl<W: Word> Pass<'_, W> {
    /// Four rows: gathers them from the columns, two by two into a complex row, and back to positions.
    fn rows(&self, task: &mut Rows<'_, W>, worker: &mut Worker) {
        let transforms = &self.spectra.transforms;
        let [_, height, width] = transforms.size;
        let Worker { line, second, scratch, residual, .. } = worker;
        let (line, second) = (&mut line[..width], &mut second[..width]);
        let from = (task.tile - self.tile) * self.stride + task.t * height + task.y;
        let step = self.tiles * self.stride;
        // Below the last row lie values of no meaning, which must not enter a row's partner.
        let there = ROWS.min(height - task.y);
        for k in 0..transforms.half() {
            // The gap after each column makes four values safe to read.
            let mut column = *self.columns[from + k * step..].first_chunk::<ROWS>().expect("columns have a gap");
            column[there..].fill(C64::default());
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
