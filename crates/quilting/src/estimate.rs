//! How much memory a run will need.

use selvedge_core::Domain;

use crate::{Options, TransferOptions};

/// Bytes that the search keeps for each sample of an exemplar beside spectra: packed features, tables of squares, errors,
/// and the list of candidates.
const A_SAMPLE: u64 = 64;
/// Bytes of spectra for each sample and channel: complex values at up to twice the size, in the four tilings that the
/// shapes of blocks at borders and inside lead to.
const A_SPECTRUM: u64 = 128;
/// What the search keeps of spectra at most.
const CACHE: u64 = 1 << 30;
/// Bytes for each sample while a correspondence map is made.
const A_MAP: u64 = 64;
/// Bytes that are kept for each block laid.
const A_BLOCK: u64 = 128;

/// An upper bound of the bytes that [`quilt`](crate::quilt()) holds beside the exemplars' features, known before anything is read:
/// shapes of the exemplars, feature channels, the output.
pub fn estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options) -> u64 {
    let samples: u64 = exemplars.iter().map(len).fold(0, u64::saturating_add);
    let spectra = samples.saturating_mul(channels as u64).saturating_mul(A_SPECTRUM).min(CACHE);
    // Blocks of the automatic size hold at least 8 by 8 samples where the exemplar does.
    let step = u64::from(options.block.unwrap_or(8)).div_ceil(2).pow(2);
    let blocks = (len(&output) / step.max(1)).saturating_add(1);
    let map = len(&output).saturating_mul(4);
    samples
        .saturating_mul(A_SAMPLE)
        .saturating_add(spectra)
        .saturating_add(blocks.saturating_mul(A_BLOCK))
        .saturating_add(map)
}

/// An upper bound of the bytes that [`transfer`](crate::transfer) holds beside the exemplars' features, known before anything is
/// read: shapes of the exemplars, channels of features and of the guide, the output.
pub fn estimate_transfer(
    exemplars: &[Domain<2>],
    channels: usize,
    guide_channels: usize,
    output: Domain<2>,
    options: &TransferOptions,
) -> u64 {
    // Blocks shrink to 4 samples at least, where the exemplar has as many.
    let smallest = options.block.map_or(4, |block| block.min(4));
    let quilting = Options { block: Some(smallest), ..Options::default() };
    let texture = estimate(exemplars, channels, output, &quilting);
    // The guide is searched beside the texture; its maps are made from others in f64.
    let guide = estimate(exemplars, guide_channels, output, &quilting);
    let samples = exemplars.iter().map(len).fold(len(&output), u64::saturating_add);
    texture.saturating_add(guide).saturating_add(samples.saturating_mul(A_MAP + guide_channels as u64))
}

fn len(domain: &Domain<2>) -> u64 {
    domain.shape.iter().fold(1, |n, &side| u64::saturating_mul(n, side.into()))
}
