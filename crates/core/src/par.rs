//! The one place that names rayon: maps over indices, in the caller's pool, with results in order.
//!
//! Without the `rayon` feature the same functions run one after the other. No result depends on the number of threads.

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
}
