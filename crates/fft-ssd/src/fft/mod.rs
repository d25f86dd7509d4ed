//! The engine by Fourier transforms: overlap-save tiles, kept spectra of the source, exact integers by rounding.
//!
//! With values less 128, `(t - I)^2 = t'^2 - 2 t' I' + I'^2`: a constant, correlations of the channels, and a sum over
//! the mask. The template is transformed once, at the size of a tile; its channels are summed in the spectrum, so that
//! each tile takes one inverse transform, of which only the answered rows go through the last pass. A noisy mask, whose
//! corners would be too many, is correlated with the squares as one more channel. A search takes
//! `O(positions * log(tile))`, nearly independently of the template.

mod bound;
mod cache;
mod size;
mod spectra;
mod tile;
mod transform;
mod workers;

pub(crate) use cache::{Cache, Keep};

use crate::Error;
use crate::job::Job;
use crate::memory::push;
use crate::prepared::Squares;
use crate::sums::{Corners, Table};
use crate::word::Word;
use bound::Norms;
use size::{Tiling, Window};
use spectra::{Signal, Signals, Spectra};
use tile::{Block, Finish, Tiled};
use workers::{C64, Worker};

/// What a template's own value adds beside its square: see [`Job::own`].
pub(crate) const BIAS: i64 = 0;

/// A mask with more corners than this is correlated with the squares instead. Measured: 1024^2 positions take about
/// 0.1 ms a corner, and one more channel as much as 30 corners.
const CORNERS: usize = 40;

/// Blocks whose rounding bound is less than so many times too large are parted: a few parts make good for that with the
/// same spectra; of many, the direct engine takes over. Where it would be faster was not measured.
const PARTS: f64 = 8.0;

/// Largest block of a template that is transformed at once, in samples: it bounds what a tile takes, since tiles are
/// larger than the block.
const BLOCK: usize = 1 << 20;

/// Working memory of this engine.
#[derive(Debug)]
pub(crate) struct FftScratch {
    /// Largest block of a template; smaller in tests.
    block: usize,
    /// Largest rounding bound; smaller in tests.
    limit: f64,
    /// Rounding bound of the block at hand.
    bound: f64,
    workers: Vec<Worker>,
    rows: Vec<C64>,
    /// Spectra of the template, and of tiles that are not kept, term by term.
    templates: Vec<Vec<C64>>,
    transient: Vec<Vec<C64>>,
    columns: Vec<C64>,
    corners: Corners,
}

impl Default for FftScratch {
    fn default() -> Self {
        Self {
            block: BLOCK,
            limit: bound::LIMIT,
            bound: 0.0,
            workers: Vec::new(),
            rows: Vec::new(),
            templates: Vec::new(),
            transient: Vec::new(),
            columns: Vec::new(),
            corners: Corners::default(),
        }
    }
}

/// A signal of the template, with the signal of the source that it is correlated with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Term {
    /// `-2 W_c t'` with the channels.
    Cross,
    /// The mask with the squares.
    Squares,
    /// The template's own part with validity.
    Own,
    /// The mask with validity.
    Count,
}

impl Term {
    fn signal(self) -> Signal {
        match self {
            Self::Cross => Signal::Features,
            Self::Squares => Signal::Squares,
            Self::Own | Self::Count => Signal::Valid,
        }
    }

    fn planes(self, job: &Job<'_>) -> usize {
        self.signal().planes(job.weights.len())
    }

    /// The template's value at a sample that counts.
    fn value(self, job: &Job<'_>, plane: usize, index: usize) -> f64 {
        match self {
            Self::Cross => {
                let value = i32::from(job.template.features[plane * job.template.len() + index]) - 128;
                f64::from(-2 * i32::from(job.weights[plane]) * value)
            }
            Self::Squares | Self::Count => 1.0,
            Self::Own => job.own(index, BIAS) as f64,
        }
    }
}

/// Planes of all terms.
fn planes(terms: &[Term], job: &Job<'_>) -> usize {
    terms.iter().map(|t| t.planes(job)).sum()
}

/// Costs of every position. Where validity has any shape and the number of compared samples varies, also the template's
/// own part and the counts; else those are left to `cover`. False if rounding cannot be trusted: its bound is too large
/// for any block, or a value was too far from an integer. The map is then worthless.
pub(crate) fn search<W: Word + Squares>(
    job: &Job<'_>,
    keep: Keep<'_>,
    scratch: &mut FftScratch,
    map: &mut [W],
    counts: &mut [u32],
) -> Result<bool, Error> {
    let mut terms = vec![Term::Cross];
    let mut corners = std::mem::take(&mut scratch.corners);
    corners.of_masks(&[*job.template], Table::<W>::shape(job.prepared.extension.shape))?;
    let mut table: &[W] = &[];
    let mut shape = [0; 3];
    if corners.len() <= CORNERS {
        let squares = W::table(job.prepared, job.source, job.weights)?;
        (table, shape) = (&squares.sums, squares.shape);
    } else {
        terms.push(Term::Squares);
        corners.clear();
    }
    let mut exact = true;
    if job.varies() && !job.prepared.is_box {
        terms.push(Term::Own);
        let finish = Finish { constant: 0_u32, table: &[], shape: [0; 3], corners: &Corners::default() };
        exact &= correlate((job, keep), &[Term::Count], &finish, scratch, counts)?;
    }
    let constant = W::wrapping(job.constant(BIAS));
    exact &= correlate((job, keep), &terms, &Finish { constant, table, shape, corners: &corners }, scratch, map)?;
    scratch.corners = corners;
    Ok(exact)
}

/// The sum of the terms' correlations at every position, block by block of the template. False as [`search`].
fn correlate<W: Word>(
    (job, keep): (&Job<'_>, Keep<'_>),
    terms: &[Term],
    finish: &Finish<'_, W>,
    scratch: &mut FftScratch,
    map: &mut [W],
) -> Result<bool, Error> {
    let mut shape = job.template.shape;
    while scratch.block < shape.iter().product() {
        halve(&mut shape);
    }
    loop {
        match correlate_blocks((job, keep), terms, finish, shape, scratch, map)? {
            Outcome::Exact => return Ok(true),
            Outcome::TooLarge if shape != [1; 3] => halve(&mut shape),
            _ => return Ok(false),
        }
    }
}

/// How the blocks of a shape went.
enum Outcome {
    Exact,
    /// A value was too far from an integer.
    Wrong,
    /// The rounding bound of a block is far too large. The bound is known only once the spectra are.
    TooLarge,
}

fn correlate_blocks<W: Word>(
    (job, keep): (&Job<'_>, Keep<'_>),
    terms: &[Term],
    finish: &Finish<'_, W>,
    shape: [usize; 3],
    scratch: &mut FftScratch,
    map: &mut [W],
) -> Result<Outcome, Error> {
    let mut first = true;
    for block in blocks(job, shape)? {
        let tiling = Tiling::new(&job.prepared.extension, block.start, block.shape, &block.window);
        let is_kept = |spectra: &Spectra| fits(job, spectra.expected(planes(terms, job)), keep.budget);
        let expected = |spectra: &Spectra| if is_kept(spectra) { spectra.expected(planes(terms, job)) } else { 0 };
        let (name, is_scalar) = (job.prepared.name, job.kernel.is_scalar());
        let spectra = &*keep.cache.spectra(name, &tiling, is_scalar, keep.budget, expected)?;
        let kept = is_kept(spectra);
        let mut parts = vec![block];
        while let Some(block) = parts.pop() {
            let tiled = Tiled { block, tiling, spectra, kept };
            scratch.bound = rounding(job, terms, &tiled, scratch)?;
            if scratch.limit <= scratch.bound {
                // A few parts of its samples do with the same spectra; smaller blocks have smaller tiles, of smaller
                // norms.
                let halves = block.halves().filter(|_| scratch.bound < PARTS * scratch.limit);
                let Some(halves) = halves else { return Ok(Outcome::TooLarge) };
                halves.into_iter().try_for_each(|half| push(&mut parts, half))?;
            } else if tile::correlate(job, terms, &tiled, finish, first, scratch, map)? {
                first = false;
            } else {
                return Ok(Outcome::Wrong);
            }
        }
    }
    Ok(Outcome::Exact)
}

/// True if spectra of so many bytes are kept: they and the tables of the same source fit the budget.
fn fits(job: &Job<'_>, spectra: u64, budget: u64) -> bool {
    spectra.saturating_add(job.prepared.bytes()) <= budget
}

/// About how many nanoseconds a search takes, once the spectra of the source are there.
pub(crate) fn cost(job: &Job<'_>) -> f64 {
    let window = Window { first: [0; 3], count: job.range.count };
    let tiling = Tiling::new(&job.prepared.extension, [0; 3], job.template.shape, &window);
    // Fitted to three channels: each more is one more product and one more transform of the template.
    tiling.cost * (0.4 + 0.2 * job.weights.len() as f64)
}

/// Bytes that a search keeps for its source, and bytes that it works in, besides tables.
pub(crate) fn bytes(job: &Job<'_>, budget: u64, noisy: bool, threads: usize) -> (u64, u64) {
    let window = Window { first: [0; 3], count: job.range.count };
    let mut block = job.template.shape;
    while BLOCK < block.iter().product() {
        halve(&mut block);
    }
    let tiling = Tiling::new(&job.prepared.extension, [0; 3], block, &window);
    let half = tiling.size[2] / 2 + 1;
    let column = tiling.size[0] * tiling.size[1];
    let varies = usize::from(job.varies() && !job.prepared.is_box);
    let planes = job.weights.len() + usize::from(noisy) + varies;
    let batch = (tile::batch(half, column, threads)).min(tiling.n_tiles());
    let spectra = half * column * planes;
    let is_kept = fits(job, (spectra * tiling.n_tiles() * size_of::<C64>()) as u64, budget);
    let (kept, transient) = if is_kept { (spectra * tiling.n_tiles(), 0) } else { (0, spectra * batch) };
    // Rows on their way to a spectrum are as many as the spectrum's values; the template's are fewer.
    let working = spectra + spectra + transient + batch * half * (column + tile::GAP);
    let rows = tiling.n_tiles() * tiling.hop[0] * tiling.hop[1].div_ceil(4) * 128;
    ((kept * size_of::<C64>()) as u64, (working * size_of::<C64>() + rows) as u64)
}

fn halve(shape: &mut [usize; 3]) {
    let longest = (0..3).max_by_key(|&a| shape[a]).unwrap_or(2);
    shape[longest] = shape[longest].div_ceil(2);
}

/// Cuts a template into blocks of equal shape; where they overlap, samples belong to the earlier one. Positions at
/// which a block lies beside the source are left out of its window, except in the first block, which writes the whole
/// map.
fn blocks(job: &Job<'_>, shape: [usize; 3]) -> Result<Vec<Block>, Error> {
    let (whole, range) = (job.template.shape, &job.range);
    let along = |a: usize| {
        let starts = (0..whole[a]).step_by(shape[a]);
        starts.map(move |s| (s.min(whole[a] - shape[a]), s))
    };
    let mut list = Vec::new();
    for (t, fresh_t) in along(0) {
        for (y, fresh_y) in along(1) {
            for (x, fresh_x) in along(2) {
                let (start, fresh) = ([t, y, x], [fresh_t, fresh_y, fresh_x]);
                let end = [0, 1, 2].map(|a: usize| start[a] + shape[a]);
                let all = Window { first: [0; 3], count: range.count };
                let window = if list.is_empty() { Some(all) } else { met(job, start, shape) };
                if let Some(window) = window {
                    push(&mut list, Block { start, fresh, end, shape, window })?;
                }
            }
        }
    }
    Ok(list)
}

/// The positions at which a block of a template may meet the source; `None` if there are none.
fn met(job: &Job<'_>, start: [usize; 3], shape: [usize; 3]) -> Option<Window> {
    let mut window = Window { first: [0; 3], count: job.range.count };
    for a in (0..3).filter(|&a| !job.range.wraps[a]) {
        // Position `i` puts the block on source samples `first + i + start ..`, of which some must be in `0..N`.
        let begin = job.range.first[a] + start[a] as isize;
        let end = usize::try_from(job.source.shape[a] as isize - begin).unwrap_or(0).min(job.range.count[a]);
        window.first[a] = usize::try_from(1 - begin - shape[a] as isize).unwrap_or(0);
        window.count[a] = end.checked_sub(window.first[a]).filter(|&n| n != 0)?;
    }
    Some(window)
}

/// The rounding bound of a block.
fn rounding(job: &Job<'_>, terms: &[Term], tiled: &Tiled<'_>, scratch: &mut FftScratch) -> Result<f64, Error> {
    let Tiled { block, spectra, .. } = tiled;
    let mut norms = Vec::new();
    let n: usize = spectra.tiling.size.iter().product();
    for &term in terms {
        let source = match tiled.kept {
            true => spectra.get(term.signal(), &signals(job), &mut scratch.workers)?.norm,
            false => largest(job, term.signal()) * (n as f64).sqrt(),
        };
        for plane in 0..term.planes(job) {
            let (mut sum, mut squares) = (0.0, 0.0);
            block.each(job.template, |index| {
                let value = term.value(job, plane, index);
                sum += value.abs();
                squares += value * value;
            });
            norms.push(Norms { sum, template: squares.sqrt(), source });
        }
    }
    Ok(bound::bound(n, norms.into_iter()))
}

/// No sample of a signal is larger.
fn largest(job: &Job<'_>, signal: Signal) -> f64 {
    match signal {
        Signal::Features => 128.0,
        Signal::Squares => 16_384.0 * job.weights.iter().map(|&w| f64::from(w)).sum::<f64>(),
        Signal::Valid => 1.0,
    }
}

fn signals<'a>(job: &Job<'a>) -> Signals<'a> {
    Signals { source: job.source, weights: job.weights, extension: &job.prepared.extension }
}

#[cfg(test)]
mod tests;
