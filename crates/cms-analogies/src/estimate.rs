//! Memory of a run, from sizes alone.

use selvedge_core::{Bytes, Domain};
use selvedge_fft_ssd::{Options as SearchOptions, Placement, Sizes as SearchSizes};

use crate::error::Error;
use crate::options::Options;

/// Bytes of a place of the output: three maps (what a run begins with, its copy, what stands), agreement, seams along
/// both axes, offers and whether they could be taken, match errors and what they leave out, and those of a whole output
/// twice.
const OF_PLACE: u64 = 3 * 4 + 4 + 2 * 4 + 5 + (8 + 1 + 2) + 2 * 8;
/// Bytes of a sample that neighborhoods are summed over: its value, and sums along one axis and both.
const OF_SUMS: u64 = 3 * 8;
/// Bytes of a sample of a label's window besides its expansion: its scaled sum and price, and whether it may show.
const OF_WINDOW: u64 = 8 + 4 + 1;

/// The sizes of a run.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a> {
    /// Shape and topology of each source.
    pub sources: &'a [Domain<2>],
    /// Feature channels of the exemplars.
    pub channels: usize,
    /// Channels and ratio of each constraint.
    pub constraints: &'a [(usize, u32)],
    /// The output.
    pub output: Domain<2>,
    /// Whether some samples of the sources, or of what lies under them, are not valid: searches around these keep
    /// spectra of all sources.
    pub holes: bool,
}

/// Bytes that a run takes beside exemplars and constraints; the most there are where it cannot be done.
pub fn estimate(sizes: &Sizes<'_>, options: &Options) -> Bytes {
    bytes(sizes, options).unwrap_or(Bytes::MOST)
}

pub(crate) fn bytes(sizes: &Sizes<'_>, options: &Options) -> Result<Bytes, Error> {
    let sides = |d: &Domain<2>| d.shape.map(u64::from);
    let samples: Bytes = sizes.sources.iter().map(|d| Bytes::of_samples(*d, 1)).sum();
    // Neighborhoods reach beyond what they are summed for, on both sides.
    let ratio = sizes.constraints.iter().map(|c| c.1).max().unwrap_or(1).max(1);
    let reach = 2 * u64::from(options.neighborhood.max(1).saturating_mul(ratio));
    let summed = |shape: [u64; 2]| Bytes::of_box(shape.map(|n| n + reach), OF_SUMS);
    // A label shows as far as its source and the output reach.
    let windows = || sizes.sources.iter().map(|d| [0, 1].map(|a| sides(d)[a].min(sides(&sizes.output)[a])));
    let own = std::iter::once((sizes.channels, 1));
    let searches = own.chain(sizes.constraints.iter().copied());
    let mut searching = Bytes(0);
    for (channels, ratio) in searches.filter(|_| options.random_labels.is_none()) {
        let side = options.neighborhood.saturating_mul(2).saturating_mul(ratio).saturating_add(1);
        let weights = vec![1; channels];
        let sizes = SearchSizes {
            sources: sizes.sources,
            weights: &weights,
            holes: sizes.holes,
            template: [side; 2],
            samples: u64::from(2 * options.neighborhood + 1).pow(2),
            // What stands of an output, or is asked for, has any shape.
            noisy_masks: sizes.holes || 1 < ratio,
        };
        searching += selvedge_fft_ssd::estimate(&sizes, Placement::overlapping(1), &SearchOptions::default())?;
    }
    let constraints = sizes.constraints.len() as u64;
    let standing = Bytes::of_samples(sizes.output, OF_PLACE + 8 * constraints) + summed(sides(&sizes.output));
    let expanded = |shape: [u64; 2]| selvedge_expansion::estimate(shape.map(|n| n as u32));
    let moved = |shape| summed(shape) + Bytes::of_box(shape, OF_WINDOW) + expanded(shape);
    let moving = windows().map(moved).max().unwrap_or_default();
    // Features, masks, and the value of each label.
    let guided: u64 = sizes.constraints.iter().map(|c| c.0 as u64 + 1).sum();
    // Coarser ones of exemplars and constraints, a fourth each time, and the map that is carried up.
    let coarser = if options.levels == Some(1) || options.random_labels.is_some() {
        Bytes(0)
    } else {
        let all = samples * (sizes.channels as u64 + 1 + guided) + Bytes::of_samples(sizes.output, guided + 4);
        Bytes(all.0 / 3)
    };
    let uses = if options.spread == 0.0 { Bytes(0) } else { crate::uses::bytes(sizes.sources) };
    Ok(searching + standing + moving + uses + coarser + samples * (sizes.channels as u64 + 1 + 8))
}
