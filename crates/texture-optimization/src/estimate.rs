//! How much memory a run will need.

use selvedge_core::{Bytes, Domain};

use crate::neighborhoods::CELLS;
use crate::{Level, Options, Search};

/// Bytes of a channel of a sample of the output: the average twice while it is brought into order, and rounded twice.
const A_VALUE: u64 = 2 * 8 + 2;
/// Bytes that the search needs for each channel of a sample, of output and exemplars alike: words of pairs, padded.
const A_WORD: u64 = 8;
/// Bytes for each place of an exemplar where a neighborhood may lie: in a list that grows, and how well it is covered,
/// twice, while that is made.
const A_PLACE: u64 = 2 * 12 + 2 * 8 + 40;
/// Bytes of a vote with its part of a list that grows.
const A_VOTE: u64 = 2 * 8;
/// Bytes for each neighborhood: its places before and now, distances, weights, answers.
const A_NEIGHBORHOOD: u64 = 160;

/// Means of a tree at most: of a hundred leaves four times as many for clusters of uneven sizes, and their parents.
const NODES: u64 = 600;

/// An upper bound of the bytes that [`optimize`](crate::optimize()) holds beside the exemplars' features: from shapes
/// of the exemplars, feature channels, and the output.
pub fn estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options) -> Bytes {
    let channels = channels as u64;
    // Differences down and across are channels of the search; sums of them and of their weights, and what is solved.
    let (searched, solved) =
        if options.gradient == 0.0 { (channels, 0) } else { (3 * channels, 16 * (2 * channels + 2) + 96) };
    let (samples, offered): (Bytes, Bytes) =
        (Bytes::of_samples(output, 1), exemplars.iter().map(|&e| Bytes::of_samples(e, 1)).sum());
    // Halved exemplars together are a third of them.
    // What counts by use, and uses.
    let place = A_PLACE + if options.spread == 0.0 { 0 } else { 8 + 4 };
    let sources = offered * (A_WORD * searched + 4 + channels + 2 * (searched - channels) + place);
    let votes = samples * u64::from(CELLS * CELLS) * A_VOTE + samples * 8;
    let x = samples * (A_VALUE * channels + A_WORD * searched + 2 * (searched - channels) + solved);
    let all: Bytes = options.schedule.iter().map(|level| windows(output, *level)).max().unwrap_or_default();
    let largest = options.schedule.iter().map(|level| level.size).max().unwrap_or_default();
    let tree = match options.search {
        Search::Tree => offered * 32 + Bytes(NODES * 4 * searched) * u64::from(largest).pow(2),
        _ => Bytes(0),
    };
    sources + votes + x + all * A_NEIGHBORHOOD + tree
}

/// Neighborhoods of a level at most.
fn windows(output: Domain<2>, level: Level) -> Bytes {
    let step = (level.scale.saturating_mul(level.size) / CELLS).max(1);
    let along = |n: u32| u64::from(n.div_ceil(step)) + 1;
    Bytes(along(output.shape[0])) * along(output.shape[1])
}
