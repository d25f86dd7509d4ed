//! Memory of a run, from sizes alone.

use selvedge_core::Domain;
use selvedge_fft_ssd::{Options as SearchOptions, Placement, Sizes as SearchSizes};

use crate::error::Error;
use crate::options::Options;

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
}

/// Bytes that a run takes beside exemplars and constraints; the most there are where it cannot be done.
pub fn estimate(sizes: &Sizes<'_>, options: &Options) -> u64 {
    bytes(sizes, options).unwrap_or(u64::MAX)
}

pub(crate) fn bytes(sizes: &Sizes<'_>, options: &Options) -> Result<u64, Error> {
    let area = |d: &Domain<2>| u64::from(d.shape[0]) * u64::from(d.shape[1]);
    let (samples, output) = (sizes.sources.iter().map(area).sum::<u64>(), area(&sizes.output));
    let largest = sizes.sources.iter().map(area).max().unwrap_or(0);
    let window = largest.min(output);
    let own = std::iter::once((sizes.channels, 1));
    let searches = own.chain(sizes.constraints.iter().copied());
    let mut searching = 0;
    for (channels, ratio) in searches.filter(|_| options.random_labels.is_none()) {
        let side = options.neighborhood.saturating_mul(2).saturating_mul(ratio).saturating_add(1);
        let weights = vec![1; channels];
        let sizes = SearchSizes {
            sources: sizes.sources,
            weights: &weights,
            holes: true,
            template: [side; 2],
            samples: u64::from(2 * options.neighborhood + 1).pow(2),
            noisy_masks: 1 < ratio,
        };
        searching += selvedge_fft_ssd::estimate(&sizes, Placement::overlapping(1), &SearchOptions::default())?;
    }
    let constraints = sizes.constraints.len() as u64;
    // The map, twice; agreement; seams by axis; offers; match errors; what stands; by constraint its errors.
    let standing = output * (4 + 4 + 4 + 8 + 4 + 8 + 1 + 8 * constraints);
    // Sums over neighborhoods, and the frame of a cut.
    let moving = window * (3 * 8 + 8 + 4 + 1) + window * 80;
    Ok(searching + standing + moving + samples * (sizes.channels as u64 + 1 + 8) + output * 24)
}
