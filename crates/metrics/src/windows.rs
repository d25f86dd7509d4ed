//! Columns of nearest windows: coherence, completeness, use, repeats.

use crate::Error;
use selvedge_core::{Exemplars, Grid, Seed, SimdLevel, par};
use selvedge_fft_ssd::{Costs, Field, Neighbor, Options, Placement, Scratch, SsdSearcher, Template, Windows, nearest};

/// Windows drawn at full size: their mean distance varies by some 2 % between draws, less than candidates differ.
const DRAWN: usize = 2000;
/// A window this close is a copy of its place, whatever phase the halving had: a copy laid at an odd offset is averaged
/// over other samples than its place was. The value is a guess.
const COPY: f64 = 0.4;

/// Exemplars at one size, with what distances are divided by.
pub(crate) struct Level {
    pub(crate) exemplars: Exemplars<2>,
    /// Root mean square difference of one sample and all channels to a contrast of 1.
    pub(crate) contrast: f64,
}

impl Level {
    pub(crate) fn new(exemplars: Exemplars<2>) -> Self {
        let contrast = crate::marginals::contrast(&exemplars);
        Self { exemplars, contrast }
    }

    /// Distance from a sum of squares.
    fn distance(&self, error: u64, side: u32) -> f64 {
        let weights: f64 = self.exemplars.weights().iter().map(|&w| f64::from(w)).sum();
        (error as f64 / (f64::from(side * side) * weights)).sqrt() / self.contrast
    }

    /// Each window of the output and the nearest of the exemplars.
    pub(crate) fn coherent(&self, output: &Grid<u8, 2>, windows: Windows, simd: SimdLevel) -> Result<Near<'_>, Error> {
        let fields = Field::all(&self.exemplars);
        let found = nearest(Field::new(output), &fields, self.exemplars.weights(), windows, simd)?;
        Ok(Near { level: self, found, windows })
    }

    /// Distances of the exemplars' windows to the nearest of the output.
    pub(crate) fn complete(&self, output: &Grid<u8, 2>, windows: Windows, simd: SimdLevel) -> Result<f64, Error> {
        let mut distances = Vec::new();
        for source in self.exemplars.firsts() {
            let weights = self.exemplars.weights();
            let found = nearest(Field::of(source), &[Field::new(output)], weights, windows, simd)?;
            let near = found.samples().iter().flatten();
            distances.extend(near.map(|n| self.distance(n.error, windows.side)));
        }
        Ok(mean(&distances))
    }

    /// Mean distance of windows drawn from the output.
    pub(crate) fn sampled(&self, output: &Grid<u8, 2>, side: u32, simd: SimdLevel) -> Result<f64, Error> {
        let over = Windows { side, step: 1 }.over(output.domain());
        if over.is_empty() {
            return Ok(0.0);
        }
        let searcher = SsdSearcher::with_options(&self.exemplars, Options { simd, ..Options::default() })?;
        let n = DRAWN.min(over.len());
        // Blocks of fifty: one scratch each, and sums in a fixed order.
        let block = |range: std::ops::Range<usize>| -> Result<(f64, usize), Error> {
            let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
            let (mut sum, mut count) = (0.0, 0);
            for i in range {
                let at = if n == over.len() { i } else { draw(i, over.len()) };
                let features = cut(output, over.position(at), side);
                let template = Template::new([side; 2], &features);
                searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs)?;
                if let Some(best) = costs.best() {
                    sum += self.distance(best.error, side);
                    count += 1;
                }
            }
            Ok((sum, count))
        };
        let add = |a: Result<(f64, usize), Error>, b: Result<(f64, usize), Error>| {
            let ((a, n), (b, m)) = (a?, b?);
            Ok((a + b, n + m))
        };
        let (sum, count) = par::fold_blocks(n, 50, block, add).unwrap_or(Ok((0.0, 0)))?;
        Ok(if count == 0 { 0.0 } else { sum / count as f64 })
    }
}

/// The windows of an output and their nearest places.
pub(crate) struct Near<'a> {
    level: &'a Level,
    found: Grid<Option<Neighbor>, 2>,
    windows: Windows,
}

impl Near<'_> {
    fn distances(&self) -> Vec<f64> {
        let near = self.found.samples().iter().flatten();
        near.map(|n| self.level.distance(n.error, self.windows.side)).collect()
    }

    pub(crate) fn mean(&self) -> f64 {
        mean(&self.distances())
    }

    /// Mean of the farthest twentieth.
    pub(crate) fn worst(&self) -> f64 {
        let mut all = self.distances();
        all.sort_unstable_by(f64::total_cmp);
        mean(&all[all.len() - all.len().div_ceil(20)..])
    }

    /// Divergence of the use of boxes of `side` samples from an even one, in bits.
    pub(crate) fn unevenness(&self, side: u32) -> f64 {
        let mut boxes = Vec::new();
        for (number, source) in self.level.exemplars.sources().iter().enumerate() {
            let [rows, columns] = Windows { step: side, ..self.windows }.over(source.domain()).shape;
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                boxes.push((number as u32, y, x));
            }
        }
        let mut counts = vec![0_u32; boxes.len()];
        for n in self.found.samples().iter().flatten() {
            let key = (n.source, n.position[0] / side, n.position[1] / side);
            let place = boxes.partition_point(|&b| b < key).min(boxes.len() - 1);
            counts[place] += 1;
        }
        let total: u32 = counts.iter().sum();
        let bits = |&n: &u32| {
            let share = f64::from(n) / f64::from(total.max(1));
            if n == 0 { 0.0 } else { share * libm::log2(share * counts.len() as f64) }
        };
        counts.iter().map(bits).sum()
    }

    /// Mean number of other windows, `apart` samples away or farther, at the same place within one sample.
    pub(crate) fn repeats(&self, apart: u32) -> f64 {
        let over = self.found.domain();
        let is_copy = |n: &Neighbor| self.level.distance(n.error, self.windows.side) <= COPY;
        let placed = |(i, n): (usize, &Option<Neighbor>)| {
            n.filter(is_copy).map(|n| ((n.source, n.position), over.position(i).map(|p| p * self.windows.step)))
        };
        let mut copies: Vec<_> = self.found.samples().iter().enumerate().filter_map(placed).collect();
        copies.sort_unstable();
        let mut pairs = 0_u64;
        for &((source, [y, x]), at) in &copies {
            for row in y.saturating_sub(1)..=y + 1 {
                let from = copies.partition_point(|&(p, _)| p < (source, [row, x.saturating_sub(1)]));
                let near = copies[from..].iter().take_while(|(p, _)| *p <= (source, [row, x + 1]));
                let far = |to: [u32; 2]| apart <= at[0].abs_diff(to[0]).max(at[1].abs_diff(to[1]));
                pairs += near.filter(|&&(_, to)| far(to)).count() as u64;
            }
        }
        pairs as f64 / over.len().max(1) as f64
    }
}

/// A keyed place among `n`.
fn draw(i: usize, n: usize) -> usize {
    Seed(0).derive("metrics/window", i as u64).rng().below_u64(n as u64) as usize
}

/// Features of a window, around periodic axes.
fn cut(from: &Grid<u8, 2>, at: [u32; 2], side: u32) -> Vec<u8> {
    let domain = from.domain();
    let mut features = Vec::with_capacity((side * side) as usize * from.channels());
    for c in 0..from.channels() {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            features.push(from.get(c, [(at[0] + y) % domain.shape[0], (at[1] + x) % domain.shape[1]]));
        }
    }
    features
}

/// 0 of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
