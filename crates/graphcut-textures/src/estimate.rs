//! How much memory a run needs.

use selvedge_core::{Domain, Exemplars};

use crate::Options;

/// Bytes that a run holds at its fullest, about.
pub fn estimate<const D: usize>(exemplars: &Exemplars<D>, output: Domain<D>, options: &Options) -> u64 {
    let bytes = |n: usize, each: u64| (n as u64).saturating_mul(each);
    let map = bytes(output.checked_len().unwrap_or(usize::MAX), 4 + 4);
    let channels = exemplars.channels() as u64;
    let samples = bytes(exemplars.table().len() as usize, channels + 1 + 2 * D as u64);
    let largest = exemplars.sources().iter().map(|s| s.domain().len()).max().unwrap_or(0);
    // A frame and a graph for each candidate that is tried; transforms of a box twice the exemplar's size.
    let cuts = bytes(largest, 100).saturating_mul(u64::from(options.tries));
    let search = bytes(largest, (16 * (channels + 3)) << D);
    [map, samples, cuts, search].into_iter().fold(0, u64::saturating_add)
}
