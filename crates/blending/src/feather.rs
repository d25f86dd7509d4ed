//! Feathering: near a seam, a weighted sum of all patches that meet there. `[Kwatra03 5]`

use selvedge_core::{Bytes, Domain, Error, Grid, Plane, Render, SourceMap, Window};

use crate::boxes::{Blend, Part, bytes, render};
use crate::map_view::MapView;
use crate::region::{Shown, grown, rows};

/// A source map whose seams are feathered with a Gaussian kernel.
///
/// Each patch that shows within reach of a position weighs as much there as the kernel's share of the positions that
/// it covers. Positions that only one patch reaches are copied bit for bit. Values are averaged as they are stored,
/// colours weighed by their alpha; normals keep their length.
#[derive(Clone, Debug)]
pub struct Feathered<'m, const D: usize> {
    laid: MapView<'m, D>,
    reach: u32,
    /// The kernel along each axis, `2 * reach + 1` weights.
    kernel: Vec<f64>,
}

impl<'m, const D: usize> Feathered<'m, D> {
    /// The greatest sigma: seams are then mixed over 64 samples, and patches keep little of their own.
    pub const MOST: f64 = 16.0;

    /// Feathers seams with a kernel of `sigma` samples, from 0 (no feathering) to 16; it ends at two sigma. Patches
    /// count where their source is `valid`: see [`Exemplars::validity`](selvedge_core::Exemplars::validity) and
    /// [`SourceTable::validity`](selvedge_core::SourceTable::validity).
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate), [`selvedge_core::Error::UnknownSample`] if the map names one,
    /// [`crate::Error::Shape`] for validity of other shapes than the sources.
    pub fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>, sigma: f64) -> Result<Self, crate::Error> {
        Self::validate(sigma)?;
        let reach = reach(sigma);
        Ok(Self { laid: MapView::new(map, valid)?, reach, kernel: gaussian(sigma, reach) })
    }

    /// Checks a sigma.
    ///
    /// # Errors
    /// [`Range`](Error::Range) unless it is from 0 to [`MOST`](Self::MOST).
    pub fn validate(sigma: f64) -> Result<(), crate::Error> {
        let in_range = (0.0..=Self::MOST).contains(&sigma);
        let wrong = || Error::range("feather", sigma, "0 to 16");
        if in_range { Ok(()) } else { Err(wrong().into()) }
    }

    /// The same, but positions where `kept` is true are copied, whatever is near.
    ///
    /// # Errors
    /// [`crate::Error::Shape`] if it has another shape than the map.
    pub fn keeping(self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        Ok(Self { laid: self.laid.keeping(kept)?, ..self })
    }

    /// An upper bound of what rendering takes besides the planes and the output, for planes of so many channels.
    pub fn bytes(output: Domain<D>, channels: usize, sigma: f64) -> Bytes {
        // Where nothing is in reach nothing is blended.
        if sigma == 0.0 { Bytes(0) } else { bytes(output, channels, reach(sigma), 32 + 16 * channels as u64) }
    }

    fn blend(&self, part: &Part<'_, D>) -> Blend {
        let len = part.wanted.len();
        let (mut sums, mut weights, mut patches) =
            (vec![vec![0.0; len]; part.channels()], vec![0.0; len], vec![0_u32; len]);
        let (mut own, mut mask, mut numbers) = (Vec::new(), Vec::new(), vec![Vec::new(); part.channels()]);
        for Shown { patch, around } in part.shown() {
            // Where it may be mixed in, and what that depends on.
            let Some(target) = grown(&around, self.reach, &part.wanted) else { continue };
            let Some(region) = grown(&target, self.reach, &part.window) else { continue };
            part.of_patch(&patch, &region, &mut own, &mut mask);
            let weight = convolved(&mask, &region, &target, &self.kernel);
            part.laid.samples_of(&patch, &target, &mut own);
            part.numbers(&own, &mut numbers);
            let places = rows(&part.wanted, &target).flatten();
            for (i, place) in places.enumerate().filter(|&(i, _)| own[i].is_assigned() && 0.0 < weight[i]) {
                patches[place] += 1;
                weights[place] += weight[i];
                for (sum, numbers) in sums.iter_mut().zip(&numbers) {
                    sum[place] += weight[i] * numbers[i];
                }
            }
        }
        for sum in &mut sums {
            sum.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight);
        }
        Blend { channels: sums, is_blended: patches.into_iter().map(|n| 1 < n).collect() }
    }
}

impl<const D: usize> Render<D> for Feathered<'_, D> {
    /// # Complexity
    /// Time `O(positions near seams * D * sigma)` for each patch in reach.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        render(&self.laid, planes, self.reach, |part| self.blend(part))
    }
}

/// Samples on each side that a kernel reaches: two sigma, beyond which lie 5 % of it.
fn reach(sigma: f64) -> u32 {
    (2.0 * sigma).ceil() as u32
}

/// A Gaussian, sampled, of weight 1 in the middle.
fn gaussian(sigma: f64, reach: u32) -> Vec<f64> {
    let weight = |d: i32| if d == 0 { 1.0 } else { libm::exp(-f64::from(d * d) / (2.0 * sigma * sigma)) };
    (-(reach as i32)..=reach as i32).map(weight).collect()
}

/// Values over a region, convolved with a kernel along each axis, in a target within it; beyond the region all is 0.
fn convolved<const D: usize>(values: &[f64], region: &Window<D>, target: &Window<D>, kernel: &[f64]) -> Vec<f64> {
    let (mut now, mut before) = (*region, values.to_vec());
    for axis in 0..D {
        let mut narrow = now;
        (narrow.start[axis], narrow.shape[axis]) = (target.start[axis], target.shape[axis]);
        let stride: usize = now.shape[axis + 1..].iter().map(|&n| n as usize).product();
        let (from, to) = (now.shape[axis] as usize * stride, narrow.shape[axis] as usize * stride);
        let mut after = vec![0.0; narrow.len()];
        for (after, before) in after.chunks_exact_mut(to).zip(before.chunks_exact(from)) {
            // Sample p of the target lies at p + skipped of the region.
            let skipped = (narrow.start[axis] - now.start[axis]) as usize;
            convolve(after, before, stride, skipped, kernel);
        }
        (now, before) = (narrow, after);
    }
    before
}

/// Along one axis of lines of `stride` samples.
fn convolve(to: &mut [f64], from: &[f64], stride: usize, skipped: usize, kernel: &[f64]) {
    let (reach, side, wanted) = (kernel.len() / 2, from.len() / stride, to.len() / stride);
    for (tap, weight) in kernel.iter().enumerate() {
        // Lines of the target whose tap lies in the region.
        let first = reach.saturating_sub(tap + skipped).min(wanted);
        let end = (side + reach).saturating_sub(tap + skipped).min(wanted);
        if first < end {
            let from = &from[(first + tap + skipped - reach) * stride..][..(end - first) * stride];
            let to = &mut to[first * stride..end * stride];
            to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        }
    }
}
