//! How much memory a run needs.

use selvedge_core::Domain;
use selvedge_fft_ssd::{Cover, Engine, Placement as Positions, Positions as Where, Sizes};

use crate::options::{Options, Placement};

/// Bytes for each position where a patch may lie: its cost, and twice itself while it is drawn.
const A_CANDIDATE: u64 = 64;
/// Bytes of a frame, its graph and its cut for each sample that a patch may show.
const A_NODE: u64 = 96;

/// An upper bound of the bytes that a run holds besides the exemplars themselves, known before anything is read: from the
/// domains of all sources, their feature channels, and the output's domain.
pub fn estimate<const D: usize>(sources: &[Domain<D>], channels: usize, output: Domain<D>, options: &Options) -> u64 {
    let samples = sources.iter().map(|s| len(s.shape)).fold(0, u64::saturating_add);
    let shortest = sources.iter().map(|s| s.shape.into_iter().min().unwrap_or(0)).max().unwrap_or(0);
    // As the run chooses them.
    let side = options.region.unwrap_or((shortest / 4).clamp(shortest.min(8), 64).max(1));
    let region = output.shape.map(|n| n.min(side).max(1));
    // The map, and the costs of its seams by cells.
    let map = len(output.shape).saturating_mul(5);
    let seams = samples.saturating_mul(channels as u64 + 1 + 2 * D as u64 + A_CANDIDATE);
    let reach = options.reach.unwrap_or(side * 2 / 3).saturating_mul(2);
    let window = |s: &Domain<D>| len::<D>(std::array::from_fn(|a| s.shape[a].min(region[a].saturating_add(reach))));
    let nodes = sources.iter().map(window).max().unwrap_or(0);
    let cuts = nodes.saturating_mul(A_NODE).saturating_mul(u64::from(options.tries));
    let weights = vec![1; channels];
    let search = match options.placement {
        Placement::Random => 0,
        Placement::Sub => sub(sources, &weights, region),
        Placement::Entire => entire(sources, &weights, region),
        Placement::Auto => sub(sources, &weights, region).max(entire(sources, &weights, region)),
    };
    [map, seams, cuts, search].into_iter().fold(0, u64::saturating_add)
}

/// A search for the region in all sources.
fn sub<const D: usize>(sources: &[Domain<D>], weights: &[u8], region: [u32; D]) -> u64 {
    let sizes = Sizes { sources, weights, template: region, noisy_masks: true };
    let placement = Positions { positions: Where::Inside, cover: Cover::Box };
    selvedge_fft_ssd::estimate(&sizes, placement, &selvedge_fft_ssd::Options::default()).unwrap_or(u64::MAX)
}

/// A search for each source in a box of the output.
fn entire<const D: usize>(sources: &[Domain<D>], weights: &[u8], region: [u32; D]) -> u64 {
    let options = selvedge_fft_ssd::Options { engine: Engine::Fft, ..selvedge_fft_ssd::Options::default() };
    let placement = Positions { positions: Where::Inside, cover: Cover::AtLeast(1) };
    let slide = |source: &Domain<D>| {
        let shape = std::array::from_fn(|a| source.shape[a].saturating_mul(2).saturating_sub(region[a]).max(1));
        let sizes = Sizes { sources: &[Domain::open(shape)], weights, template: source.shape, noisy_masks: true };
        let search = selvedge_fft_ssd::estimate(&sizes, placement, &options).unwrap_or(u64::MAX);
        // What is seen of the output, as features and as an exemplar.
        search.saturating_add(len(shape).saturating_mul(2 * weights.len() as u64 + 3))
    };
    sources.iter().map(slide).max().unwrap_or(0)
}

fn len<const D: usize>(shape: [u32; D]) -> u64 {
    shape.into_iter().fold(1, |n, side| n.saturating_mul(side.into()))
}
