//! How much memory a run will need.

use selvedge_core::Domain;

use crate::Options;

/// Bytes that the search keeps for each sample of an exemplar beside spectra: packed features, tables of squares, errors,
/// and the list of candidates.
const A_SAMPLE: u64 = 64;
/// Bytes of spectra for each sample and channel: complex values at up to twice the size, in the four tilings that the
/// shapes of blocks at borders and inside lead to.
const A_SPECTRUM: u64 = 128;
/// What the search keeps of spectra at most.
const CACHE: u64 = 1 << 30;
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

fn len(domain: &Domain<2>) -> u64 {
    domain.shape.iter().fold(1, |n, &side| u64::saturating_mul(n, side.into()))
}
