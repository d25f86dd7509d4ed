//! How much memory a run needs.

use selvedge_core::Domain;

use crate::Options;

/// Bytes that a run holds at its fullest, about, besides the exemplars themselves: from the domains of all sources, their
/// feature channels, and the output's domain.
pub fn estimate<const D: usize>(sources: &[Domain<D>], channels: usize, output: Domain<D>, options: &Options) -> u64 {
    let bytes = |n: u64, each: u64| n.saturating_mul(each);
    let len = |domain: &Domain<D>| domain.shape.iter().fold(1, |n: u64, &side| n.saturating_mul(side.into()));
    let channels = channels as u64;
    let map = bytes(len(&output), 4 + 4);
    let samples = bytes(sources.iter().map(len).fold(0, u64::saturating_add), channels + 1 + 2 * D as u64);
    let largest = sources.iter().map(len).max().unwrap_or(0);
    // A frame and a graph for each candidate that is tried; transforms of a box twice the exemplar's size.
    let cuts = bytes(largest, 100).saturating_mul(u64::from(options.tries));
    let search = bytes(largest, (16 * (channels + 3)) << D);
    [map, samples, cuts, search].into_iter().fold(0, u64::saturating_add)
}
