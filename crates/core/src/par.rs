//! The one place that names rayon: maps over indices, in the caller's pool, with results in order.
//!
//! Without the `rayon` feature the same functions run one after the other. No result depends on the number of threads.

use std::sync::atomic::{AtomicUsize, Ordering};

/// `[f(0), f(1), ..]`, computed in any order.
#[cfg(feature = "rayon")]
pub fn map_indexed<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    use rayon::prelude::*;
    (0..n).into_par_iter().map(f).collect()
}

/// `[f(0), f(1), ..]`.
#[cfg(not(feature = "rayon"))]
pub fn map_indexed<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..n).map(f).collect()
}

/// Calls `f(i, row)` for each row of `len` items (the last may be shorter), in any order.
///
/// # Panics
/// If `len` is 0.
#[cfg(feature = "rayon")]
pub fn for_rows<T: Send>(items: &mut [T], len: usize, f: impl Fn(usize, &mut [T]) + Sync + Send) {
    use rayon::prelude::*;
    items.par_chunks_mut(len).enumerate().for_each(|(i, row)| f(i, row));
}

/// Calls `f(i, row)` for each row of `len` items (the last may be shorter).
///
/// # Panics
/// If `len` is 0.
#[cfg(not(feature = "rayon"))]
pub fn for_rows<T: Send>(items: &mut [T], len: usize, f: impl Fn(usize, &mut [T]) + Sync + Send) {
    items.chunks_mut(len).enumerate().for_each(|(i, row)| f(i, row));
}

/// Places of exemplars whose answers are held at once by searches that run beside each other, unless one search has
/// more: each takes memory for all of its places, and one of many places keeps all threads busy by itself.
const AT_ONCE: u64 = 1 << 18;

/// Searches that may run at once, each over so many places, on as many threads as there may be. At least one.
pub fn at_once(places: u64) -> u64 {
    (AT_ONCE / places.max(1)).max(1)
}

/// `[f(state, 0), f(state, 1), ..]`, computed in any order, where each call has one of the states to itself: no more
/// calls run at once than there are states. What a state holds must not matter to what `f` answers, only to how fast.
///
/// # Panics
/// If there are no states, but calls to make.
pub fn map_with<S: Send, T: Send>(states: &mut [S], n: usize, f: impl Fn(&mut S, usize) -> T + Sync + Send) -> Vec<T> {
    assert!(n == 0 || !states.is_empty(), "{n} calls have no state");
    if let ([state], _) | ([state, ..], 1) = (&mut *states, n) {
        return (0..n).map(|i| f(state, i)).collect();
    }
    let next = AtomicUsize::new(0);
    let mut shares: Vec<(&mut S, Vec<(usize, T)>)> = states.iter_mut().take(n).map(|s| (s, Vec::new())).collect();
    for_rows(&mut shares, 1, |_, share| {
        let (state, done) = &mut share[0];
        // Whoever is free takes the next one.
        let claimed = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < n);
        done.extend(std::iter::from_fn(claimed).map(|i| (i, f(state, i))));
    });
    let mut all: Vec<(usize, T)> = shares.into_iter().flat_map(|(_, done)| done).collect();
    all.sort_unstable_by_key(|&(i, _)| i);
    all.into_iter().map(|(_, result)| result).collect()
}

/// Folds `0..n` in blocks of `block` indices; the blocks' results are merged in order, so that even a
/// rounding `merge` gives the same result on any number of threads.
///
/// # Panics
/// If `block` is 0.
pub fn fold_blocks<T: Send>(
    n: usize,
    block: usize,
    fold: impl Fn(std::ops::Range<usize>) -> T + Sync + Send,
    merge: impl FnMut(T, T) -> T,
) -> Option<T> {
    let blocks = n.div_ceil(block);
    map_indexed(blocks, |b| fold(b * block..n.min((b + 1) * block))).into_iter().reduce(merge)
}

/// Threads of the pool that this is called in.
pub fn threads() -> usize {
    #[cfg(feature = "rayon")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order() {
        assert_eq!(map_indexed(100, |i| i * i), (0..100).map(|i| i * i).collect::<Vec<_>>());
        let joined = fold_blocks(10, 3, |r| format!("{r:?}"), |a, b| a + " " + &b);
        assert_eq!(joined.as_deref(), Some("0..3 3..6 6..9 9..10"));
        assert_eq!(fold_blocks(0, 3, |_| 0, |a, _| a), None);
        let mut rows = [0; 7];
        for_rows(&mut rows, 3, |i, row| row.fill(i));
        assert_eq!(rows, [0, 0, 0, 1, 1, 1, 2]);
    }

    #[test]
    fn states_are_shared_out_and_results_come_in_order() {
        for states in 1..5 {
            let mut calls = vec![0; states];
            let squares = map_with(&mut calls, 40, |calls, i| {
                *calls += 1;
                i * i
            });
            assert_eq!(squares, (0..40).map(|i| i * i).collect::<Vec<_>>());
            assert_eq!(calls.iter().sum::<i32>(), 40);
        }
        assert!(map_with(&mut Vec::<()>::new(), 0, |(), i| i).is_empty());
    }
}
