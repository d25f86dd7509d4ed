//! How much memory a run will need.

use selvedge_core::Domain;
use selvedge_fft_ssd::{Placement, Sizes};

use crate::quilter::at_once;
use crate::{Options, TransferOptions};

/// Bytes of a candidate in the lists that it goes through; of a flat exemplar every place is one.
const A_CANDIDATE: u64 = 40;
/// Bytes of the error of a place.
const AN_ERROR: u64 = 8;
/// Bytes of the errors of a place where several searches are summed: of each of three, and of the sum.
const A_SUM: u64 = 3 * 4 + 8;
/// Bytes for each sample of the largest picture while a correspondence map is made of it.
const A_MAP: u64 = 64;
/// Bytes that are kept for each block laid.
const A_BLOCK: u64 = 48;

/// An upper bound of the bytes that [`quilt`](crate::quilt()) holds beside the exemplars' features, known before anything is read:
/// shapes of the exemplars, feature channels, the output. For exemplars of noise it is up to several times what is held,
/// as flat ones hold so much.
pub fn estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options) -> u64 {
    let block = options.block.unwrap_or_else(|| largest(exemplars));
    // Blocks of the automatic size hold at least 8 by 8 samples where the exemplar does.
    let step = u64::from(options.block.unwrap_or(8)).div_ceil(2).pow(2);
    let blocks = (len(&output) / step.max(1)).saturating_add(1);
    let places = exemplars.iter().map(len).fold(0, u64::saturating_add);
    // On as many threads as there may be. One of the blocks is counted with the searcher.
    let beside = (at_once(places) - 1).saturating_mul(places.saturating_mul(A_CANDIDATE + AN_ERROR));
    [
        // Blocks at the output's border have other shapes, which may need spectra of their own.
        searched(exemplars, channels, block).saturating_mul(2),
        places.saturating_mul(A_CANDIDATE),
        beside,
        blocks.saturating_mul(A_BLOCK),
        // The map, and where the blocks of a wave show.
        len(&output).saturating_mul(4 + 1),
    ]
    .into_iter()
    .fold(0, u64::saturating_add)
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
    let first = options.block.unwrap_or_else(|| largest(exemplars).min(36));
    // The smallest blocks of the last pass are the most: their step is at least half of 4.
    let smallest = Options { block: Some(first.min(4)), ..Options::default() };
    let texture = estimate(exemplars, channels, output, &smallest);
    let larger = [channels, guide_channels].map(|c| searched(exemplars, c, first).saturating_mul(2));
    let guide = searched(exemplars, guide_channels, first.min(4));
    let pictures = || exemplars.iter().map(len).chain([len(&output)]);
    let samples = pictures().fold(0, u64::saturating_add);
    let maps = pictures().max().unwrap_or(0).saturating_mul(A_MAP);
    // Colours, luminance, and the guide's own channels before and after they are joined; two maps of the output.
    let features = samples.saturating_mul(4 + 2 * guide_channels as u64);
    let sums = samples.saturating_mul(A_SUM);
    [texture, larger[0], larger[1], guide, maps, features, sums, len(&output).saturating_mul(4)]
        .into_iter()
        .fold(0, u64::saturating_add)
}

/// What a searcher and its answer hold for blocks of that side.
fn searched(exemplars: &[Domain<2>], channels: usize, block: u32) -> u64 {
    let (weights, block) = (vec![1; channels], block.max(1));
    // Neither masks nor overlaps are known; what they do to a search fits into what is added for borders.
    let (holes, template, samples) = (false, [block; 2], u64::from(block).pow(2));
    let sizes = Sizes { sources: exemplars, weights: &weights, holes, template, samples, noisy_masks: false };
    selvedge_fft_ssd::estimate(&sizes, Placement::INSIDE, &selvedge_fft_ssd::Options::default()).unwrap_or(u64::MAX)
}

/// The largest block that is chosen for exemplars of these shapes.
fn largest(exemplars: &[Domain<2>]) -> u32 {
    let shorter = exemplars.iter().flat_map(|e| e.shape).min().unwrap_or(1);
    (shorter * 2 / 5).clamp(shorter.min(4), 128)
}

fn len(domain: &Domain<2>) -> u64 {
    domain.shape.iter().fold(1, |n, &side| u64::saturating_mul(n, side.into()))
}
