//! One share of the work, with working memory of its own.

use rustfft::num_complex::Complex;
use selvedge_core::par;

pub(crate) type C64 = Complex<f64>;

/// Working memory of one task.
#[derive(Debug, Default)]
pub(crate) struct Worker {
    pub(crate) line: Vec<C64>,
    pub(crate) second: Vec<C64>,
    pub(crate) real: Vec<f64>,
    pub(crate) scratch: Vec<C64>,
    /// Largest distance from an integer seen.
    pub(crate) residual: f64,
}

/// Calls `f(number, unit, worker)` for each unit of `len` items; each worker has a share of neighbouring units.
pub(crate) fn deal<T: Send>(
    items: &mut [T],
    len: usize,
    workers: &mut [Worker],
    f: impl Fn(usize, &mut [T], &mut Worker) + Sync + Send,
) {
    let units = items.len() / len;
    let share = units.div_ceil(workers.len()).max(1);
    let mut shares: Vec<_> = items.chunks_mut(share * len).zip(workers).collect();
    par::for_rows(&mut shares, 1, |number, shares| {
        let (items, worker) = &mut shares[0];
        for (i, unit) in items.chunks_mut(len).enumerate() {
            f(number * share + i, unit, worker);
        }
    });
}
