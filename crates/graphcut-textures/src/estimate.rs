//! How much memory a run needs.

use selvedge_core::Domain;
use selvedge_fft_ssd::{Cover, Placement as Positions, Positions as Where, Sizes};

use crate::error_cells::CELLS_A_REGION;
use crate::options::{Options, Placement};
use crate::weaver::largest_region;

/// Bytes for each position where a patch may lie: its cost, and twice itself while it is drawn.
const A_CANDIDATE: u64 = 64;
/// Bytes of a frame, its graph and its cut for each sample that a patch may show.
const A_NODE: u64 = 96;

/// An upper bound of the bytes that a run holds besides the exemplars themselves, known before anything is read: from the
/// domains of all sources, their feature channels, and the output's domain.
pub fn estimate<const D: usize>(sources: &[Domain<D>], channels: usize, output: Domain<D>, options: &Options) -> u64 {
    let samples = sources.iter().map(|s| len(s.shape)).fold(0, u64::saturating_add);
    let shortest = sources.iter().map(|s| s.shape.into_iter().min().unwrap_or(0)).max().unwrap_or(0);
    // No less than what the run may choose.
    let side = options.region.unwrap_or_else(|| largest_region(shortest));
    let reach = options.reach.unwrap_or(side.div_ceil(2));
    let region = output.shape.map(|n| n.min(side).max(1));
    let window: [u32; D] =
        std::array::from_fn(|a| region[a].saturating_add(reach.min(output.shape[a]).saturating_mul(2)));
    // The map, and the costs of its seams by cells.
    let cell = u64::from(side / CELLS_A_REGION).max(1).saturating_pow(D as u32);
    let map = len(output.shape).saturating_mul(5).saturating_add(len(output.shape) / cell * 42);
    let seams = samples.saturating_mul(channels as u64 + 1 + 4 * D as u64 + A_CANDIDATE);
    let shown = |s: &Domain<D>| len::<D>(std::array::from_fn(|a| s.shape[a].min(window[a])));
    let nodes = sources.iter().map(shown).max().unwrap_or(0);
    let cuts = nodes.saturating_mul(A_NODE).saturating_mul(u64::from(options.tries));
    let weights = vec![1; channels];
    let sub = || search(sources, &weights, region, Positions { positions: Where::Inside, cover: Cover::Box });
    let entire = || search(sources, &weights, window, Positions::overlapping(1));
    let search = match options.placement {
        Placement::Random => 0,
        Placement::Sub => sub(),
        Placement::Entire => entire(),
        Placement::Auto => sub().max(entire()),
    };
    [map, seams, cuts, search].into_iter().fold(0, u64::saturating_add)
}

/// A search for a box in all sources.
fn search<const D: usize>(sources: &[Domain<D>], weights: &[u8], template: [u32; D], placement: Positions) -> u64 {
    let samples = len(template);
    let sizes = Sizes { sources, weights, holes: true, template, samples, noisy_masks: true };
    selvedge_fft_ssd::estimate(&sizes, placement, &selvedge_fft_ssd::Options::default()).unwrap_or(u64::MAX)
}

fn len<const D: usize>(shape: [u32; D]) -> u64 {
    shape.into_iter().fold(1, |n, side| n.saturating_mul(side.into()))
}
