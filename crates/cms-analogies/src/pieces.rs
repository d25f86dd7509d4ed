//! The pieces of an output, each of which shows one label, and which of them can be settled beside each other.

use selvedge_core::{Domain, Patch, SourceMap, Window, reserve, try_vec};

use crate::error::Error;

/// How far from what a label shows it may be taken when it is moved: twice what a sample of the coarser level is here.
/// A weave, rice, an arch and bricks end at 972, 67.0, 387 and 89.8e6 with 2, at 717, 64.5, 369 and 79.5e6 with 4; with
/// 6 rice and bricks at 61.7 and 75.3, the arch at 376, in a quarter to a half more time.
const WIDTH: u32 = 4;

/// Pieces of fewer samples are not moved: there are as many as there are of all others.
pub(crate) const LEAST_MOVED: usize = 4;

/// Pieces whose windows have more than such a part of the samples that a label may have, or of the output's rows, are
/// settled alone: each thread keeps the memory of the largest that it has settled.
const PARTS: usize = 32;
const MOST_ROWS: u32 = 8;

/// A piece of an output that shows one label.
pub(crate) struct Piece {
    /// In the turn that the window is in.
    pub(crate) patch: Patch<2>,
    /// The box around it and a little more, once around an axis at most.
    pub(crate) window: Window<2>,
    /// How many samples it has.
    pub(crate) samples: usize,
}

/// The connected pieces of a map, in the order of their first samples. A box around all that shows a label holds mostly
/// others, which would be offered it in vain: of the rock's arch that took three quarters of a run.
pub(crate) fn of(map: &SourceMap<2>) -> Result<Vec<Piece>, Error> {
    let output = map.domain();
    // In a turn of the output: an exemplar that is longer than what goes around shows other samples in each.
    let patch_at = |at: [u32; 2], turn: [i32; 2]| {
        let (source, from) = map.locate(at)?;
        let patch = Patch { source, offset: [0, 1].map(|a| turn[a] - from[a] as i32) };
        Some(patch.wrapped(map.table.sources()[source].1, Domain::open(output.shape)))
    };
    let (mut reached, mut pieces, mut stack) = (try_vec(output.len(), false)?, Vec::new(), Vec::new());
    for first in output.positions() {
        let begun = first.map(|p| p as i32);
        let Some(patch) = patch_at(first, begun).filter(|_| !reached[output.index(first)]) else { continue };
        let (mut low, mut high, mut samples) = (begun, begun, 0);
        reached[output.index(first)] = true;
        stack.push((first, begun));
        while let Some((at, turn)) = stack.pop() {
            samples += 1;
            (low, high) = ([0, 1].map(|a| low[a].min(turn[a])), [0, 1].map(|a| high[a].max(turn[a])));
            for by in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
                let Some(next) = output.step(at, by) else { continue };
                let turn = [0, 1].map(|a| turn[a] + by[a]);
                if !reached[output.index(next)] && patch_at(next, turn) == Some(patch) {
                    reached[output.index(next)] = true;
                    reserve(&mut stack, 1)?;
                    stack.push((next, turn));
                }
            }
        }
        // Where a source goes around as well, some go around more than once.
        let of = Window { start: low, shape: [0, 1].map(|a| output.shape[a].min((high[a] - low[a] + 1) as u32)) };
        reserve(&mut pieces, 1)?;
        pieces.push(Piece { patch, window: of.grown(output, [WIDTH; 2], [WIDTH; 2]), samples });
    }
    Ok(pieces)
}

/// Pieces that can be settled beside each other, by their numbers, group after group: none of a group may change what
/// another looks at, so all end as if one was settled after the other. Of a group no more are taken together than fit
/// beside a label over `room` samples.
///
/// Each piece joins the first group that has nothing near it, which takes some ten groups. In the order of the pieces
/// they would be as many as the longest chain of neighbours has: 206 of rice's 742 pieces, too few in each for threads.
pub(crate) fn groups(pieces: &[Piece], output: Domain<2>, room: usize) -> Result<Vec<Vec<usize>>, Error> {
    // By place, a bit for each group that may change it.
    let mut changed_by = try_vec(output.len(), 0_u64)?;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        let seen = piece.window.grown(output, [1; 2], [1; 2]);
        let near = seen.places(output).flatten().fold(0, |near, place| near | changed_by[place]);
        // What has all of them near it is a group of its own, behind them.
        let group = if near == u64::MAX { groups.len() } else { near.trailing_ones() as usize };
        if let Some(bit) = 1_u64.checked_shl(group as u32) {
            piece.window.places(output).flatten().for_each(|place| changed_by[place] |= bit);
        }
        if groups.len() == group {
            reserve(&mut groups, 1)?;
            groups.push(Vec::new());
        }
        reserve(&mut groups[group], 1)?;
        groups[group].push(number);
    }
    let mut parts = Vec::new();
    groups.iter().for_each(|group| divide(group, pieces, output, room, &mut parts));
    Ok(parts)
}

/// Parts of a group: what is large is settled alone, and all of a part takes half of the memory of what is largest.
fn divide(group: &[usize], pieces: &[Piece], output: Domain<2>, room: usize, parts: &mut Vec<Vec<usize>>) {
    let (mut left, mut some) = (0, Vec::new());
    for &number in group {
        let Window { shape: [rows, _], .. } = pieces[number].window;
        let samples = pieces[number].window.len();
        if room < samples.saturating_mul(PARTS) || output.shape[0] < rows.saturating_mul(MOST_ROWS) {
            parts.push(vec![number]);
            continue;
        }
        if left < samples {
            parts.push(std::mem::take(&mut some));
            left = room / 2;
        }
        left -= samples;
        some.push(number);
    }
    parts.push(some);
    parts.retain(|part| !part.is_empty());
}
