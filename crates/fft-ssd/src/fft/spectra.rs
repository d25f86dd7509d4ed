//! Spectra of the source's tiles, kept between searches.

use super::size::Tiling;
use super::transform::Transforms;
use super::workers::{C64, Worker};
use crate::Error;
use crate::extension::Extension;
use crate::source::SourceView;
use crate::sums::square;
use selvedge_core::try_vec;
use std::sync::OnceLock;

/// What of a source is transformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    /// Every channel less 128, 0 where not valid.
    Features,
    /// The weighted sum of the squares of those.
    Squares,
    /// 1 where valid.
    Valid,
}

impl Signal {
    /// Planes that it has.
    pub(crate) fn planes(self, channels: usize) -> usize {
        if self == Self::Features { channels } else { 1 }
    }
}

/// The spectra of one tiling of an extended source, made when first asked for.
#[derive(Debug)]
pub(crate) struct Spectra {
    pub(crate) tiling: Tiling,
    pub(crate) transforms: Transforms,
    signals: [OnceLock<Kept>; 3],
}

/// One signal of all tiles: tile by tile, column by column, plane by plane, so that a search reads it in one stream.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) spectra: Vec<C64>,
    /// Largest Euclidean norm of a tile's plane.
    pub(crate) norm: f64,
}

/// A source and what its signals need.
#[derive(Clone, Copy)]
pub(crate) struct Signals<'a> {
    pub(crate) source: &'a SourceView<'a>,
    pub(crate) weights: &'a [u8],
    pub(crate) extension: &'a Extension,
}

impl Spectra {
    pub(crate) fn new(tiling: Tiling, scalar: bool) -> Self {
        Self { tiling, transforms: Transforms::new(tiling.size, scalar), signals: Default::default() }
    }

    /// Bytes of the spectra of so many planes.
    pub(crate) fn expected(&self, planes: usize) -> u64 {
        (self.transforms.len() * self.tiling.n_tiles() * planes * size_of::<C64>()) as u64
    }

    /// The spectra of a signal, if they are kept.
    pub(crate) fn kept(&self, signal: Signal) -> Option<&[C64]> {
        self.signals[signal as usize].get().map(|k| k.spectra.as_slice())
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let kept = self.signals.iter().filter_map(OnceLock::get);
        kept.map(|k| (k.spectra.len() * size_of::<C64>()) as u64).sum()
    }

    /// The spectra of a signal.
    pub(crate) fn get(&self, signal: Signal, of: &Signals<'_>, workers: &mut Vec<Worker>) -> Result<&Kept, Error> {
        let slot = &self.signals[signal as usize];
        if let Some(kept) = slot.get() {
            return Ok(kept);
        }
        let len = self.transforms.len() * signal.planes(of.weights.len());
        let mut spectra = try_vec(len * self.tiling.n_tiles(), C64::default())?;
        let mut norm: f64 = 0.0;
        let mut rows = Vec::new();
        self.transforms.prepare(workers)?;
        for (tile, spectrum) in spectra.chunks_mut(len).enumerate() {
            norm = norm.max(self.tile(tile, signal, of, &mut rows, spectrum, workers)?);
        }
        Ok(slot.get_or_init(|| Kept { spectra, norm }))
    }

    /// The spectra of one tile of a signal; returns the largest Euclidean norm of its planes.
    pub(crate) fn tile(
        &self,
        tile: usize,
        signal: Signal,
        of: &Signals<'_>,
        rows: &mut Vec<C64>,
        spectra: &mut [C64],
        workers: &mut [Worker],
    ) -> Result<f64, Error> {
        let origin = self.tiling.origin(tile);
        let [frames, height, width] = self.tiling.size;
        let from = [0, 1, 2].map(|a: usize| origin[a] + self.tiling.start[a]);
        let load = |plane: usize, t: usize, y: usize, row: &mut [f64]| {
            of.load(signal, plane, [from[0] + t, from[1] + y, from[2]], &mut row[..width]);
        };
        let planes = signal.planes(of.weights.len());
        self.transforms.forward(planes, [frames, height], load, rows, spectra, workers)?;
        // Parseval: the norm from the half spectrum, in which inner columns stand for two.
        let mut squares = vec![0.0; planes];
        for (i, column) in spectra.chunks(self.transforms.column()).enumerate() {
            let (k, plane) = (i / planes, i % planes);
            let square: f64 = column.iter().map(|z| z.norm_sqr()).sum();
            squares[plane] += if 0 < k && 2 * k < width { 2.0 * square } else { square };
        }
        let n = (frames * height * width) as f64;
        Ok(squares.into_iter().fold(0.0, |norm: f64, s: f64| norm.max((s / n).sqrt())))
    }
}

impl Signals<'_> {
    /// A row of a signal from a coordinate of the extension on; what lies outside stays 0.
    fn load(&self, signal: Signal, plane: usize, at: [usize; 3], row: &mut [f64]) {
        let Some(from) = self.extension.row(self.source, at[0], at[1]) else { return };
        let (first, columns) = self.extension.columns();
        let (skip, to) = (at[2].saturating_sub(first), first.saturating_sub(at[2]));
        let Some(row) = row.get_mut(to..) else { return };
        for (value, &x) in row.iter_mut().zip(columns.get(skip..).unwrap_or(&[])) {
            let index = from + x as usize;
            if self.source.is_valid(index) {
                *value = match signal {
                    Signal::Features => f64::from(self.source.plane(plane)[index]) - 128.0,
                    Signal::Squares => square(self.source, self.weights, index) as f64,
                    Signal::Valid => 1.0,
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::size::Window;
    use super::*;
    use crate::Positions;
    use crate::placement::Range;
    use selvedge_core::Seed;

    /// The rounding bound rests on this norm; flat pictures, of which one column has all, do not tell how columns
    /// count.
    #[test]
    fn the_norm_from_half_a_spectrum_is_the_norm_of_the_samples() {
        for (number, (shape, template)) in
            [([1, 13, 17], [1, 4, 5]), ([3, 9, 22], [2, 3, 4]), ([1, 40, 6], [1, 7, 6])].into_iter().enumerate()
        {
            let mut rng = Seed(3).derive("norm", number as u64).rng();
            let n: usize = shape.iter().product();
            let features: Vec<u8> = (0..3 * n).map(|_| rng.below(256) as u8).collect();
            let source = SourceView { shape, periodic: [false; 3], features: &features, valid: None };
            let range = Range::new(Positions::Overlapping, shape, [false; 3], template);
            let extension = Extension::new(shape, &range, template).unwrap();
            let window = Window { first: [0; 3], count: range.count };
            let spectra = Spectra::new(Tiling::new(&extension, [0; 3], template, &window), false);
            let of = Signals { source: &source, weights: &[1, 2, 3], extension: &extension };
            for signal in [Signal::Features, Signal::Squares, Signal::Valid] {
                let kept = spectra.get(signal, &of, &mut Vec::new()).unwrap();
                let expected = norm(&spectra.tiling, signal, &of);
                assert!((kept.norm / expected - 1.0).abs() < 1e-12, "{shape:?} {signal:?}: {} {expected}", kept.norm);
            }
        }
    }

    /// The largest norm of a tile's plane, sample by sample.
    fn norm(tiling: &Tiling, signal: Signal, of: &Signals<'_>) -> f64 {
        let [frames, height, width] = tiling.size;
        let mut largest = 0.0_f64;
        for (tile, plane) in (0..tiling.n_tiles()).flat_map(|t| (0..signal.planes(3)).map(move |p| (t, p))) {
            let origin = tiling.origin(tile);
            let from = [0, 1, 2].map(|a: usize| origin[a] + tiling.start[a]);
            let mut sum = 0.0;
            for (t, y) in (0..frames).flat_map(|t| (0..height).map(move |y| (t, y))) {
                let mut row = vec![0.0; width];
                of.load(signal, plane, [from[0] + t, from[1] + y, from[2]], &mut row);
                sum += row.iter().map(|v| v * v).sum::<f64>();
            }
            largest = largest.max(sum.sqrt());
        }
        largest
    }
}
