//! The best positions that are apart from each other.

use crate::candidates::candidate;
use crate::memory::push;
use crate::pick::Pick;
use crate::{Candidate, Costs, Error, PositionGrid};
use selvedge_core::try_vec;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

impl<const D: usize> Costs<D> {
    /// The best, then the best of those at least `distance` samples away from it in the same source (as the crow flies,
    /// the shorter way round along periodic axes), and so on: up to `k`, best first. With a distance of 0 any may
    /// follow.
    ///
    /// Takes `O(2^D positions + k distance log positions)` time and a bit over one byte a position: discs of half the
    /// distance about the picks do not overlap, so all discs about them cover every position at most `2^D` times.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn best_k(&self, k: usize, distance: u32) -> Result<Vec<Candidate<D>>, Error> {
        let mut taken: Vec<bool> = try_vec(self.len(), false)?;
        let mut chosen = Vec::new();
        // The best of each run. A run whose best was taken since is looked at again. Where errors alone tell the best,
        // no place of a run is better than its first one with its least error: most are never looked at.
        let mut heap = Vec::new();
        for run in self.runs() {
            let least = Pick { error: run.least, count: self.samples as u32, flat: run.start };
            let best = if self.counts.is_empty() { Some(least) } else { self.best_of(run.places(), &taken) };
            if let Some(best) = best {
                push(&mut heap, Reverse(Entry { best, run, is_seen: !self.counts.is_empty() }))?;
            }
        }
        let mut heap = BinaryHeap::from(heap);
        while chosen.len() < k
            && let Some(Reverse(entry)) = heap.pop()
        {
            let flat = entry.best.flat as usize;
            if entry.is_seen && !taken[flat] {
                push(&mut chosen, candidate(&self.sources, entry.best))?;
                let source = &self.sources[entry.run.source as usize];
                take(source, flat - source.start, distance, &mut taken[source.start..source.start + source.len()]);
            }
            // One left, so there is room for one.
            let next = self.best_of(entry.run.places(), &taken);
            heap.extend(next.map(|best| Reverse(Entry { best, is_seen: true, ..entry })));
        }
        Ok(chosen)
    }

    fn best_of(&self, places: std::ops::Range<usize>, taken: &[bool]) -> Option<Pick> {
        let free = places.filter(|&flat| !taken[flat]);
        free.filter_map(|flat| self.pick(flat)).min_by(Pick::order)
    }
}

/// A run of positions in the queue.
#[derive(Clone, Copy)]
struct Entry {
    best: Pick,
    run: crate::pick::Run,
    /// False for one that stands for a run that was not looked at.
    is_seen: bool,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.best.order(&other.best)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

/// Marks the positions of a source that are less than `distance` away from one of them, and that one.
fn take<const D: usize>(source: &PositionGrid<D>, center: usize, distance: u32, taken: &mut [bool]) {
    taken[center] = true;
    let left = u64::from(distance).pow(2);
    let place: [i32; D] = std::array::from_fn(|a| source.position(center)[a] - source.first[a]);
    take_from(source, &place, 0, 0, left, taken);
}

/// Marks what is nearer than the root of `left` on the axes from `axis` on; `index` tells the place on those before.
fn take_from<const D: usize>(
    source: &PositionGrid<D>,
    place: &[i32; D],
    axis: usize,
    index: usize,
    left: u64,
    taken: &mut [bool],
) {
    if axis == D {
        taken[index] = true;
        return;
    }
    // The largest step whose square is less than `left`.
    let Some(reach) = left.checked_sub(1).map(u64::isqrt) else { return };
    let (n, reach) = (i64::from(source.shape[axis]), reach as i64);
    let at = i64::from(place[axis]);
    let (low, high) = if source.wraps[axis] {
        // The shorter way round: no step is longer than half of it.
        (-reach.min((n - 1) / 2), reach.min(n / 2))
    } else {
        (-reach.min(at), reach.min(n - 1 - at))
    };
    for by in low..=high {
        let to = (at + by).rem_euclid(n) as usize;
        take_from(source, place, axis + 1, index * n as usize + to, left - by.unsigned_abs().pow(2), taken);
    }
}
