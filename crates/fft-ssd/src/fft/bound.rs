//! How far a computed correlation can be from the integer that it stands for.
//!
//! Let `u = 2^-53`. A transform of `n = 2^k` samples with twiddles correct to `u` satisfies
//! `|F computed - F|_2 <= tau |F|_2` with `tau <= k (6.7 u) + O(u^2)` (Higham 2002, theorem 24.2); `tau` below allows 8 u a
//! factor of two, which covers the radices 3 and 5 too, and 16 u for what is added around: parting two rows, scaling.
//! Passing two real rows through one complex row loses nothing: the two errors together are the complex row's.
//!
//! For one pair of signals `a` (template) and `b` (tile of the source), with `A`, `B` their spectra, `|A|_2 = sqrt(n) |a|_2`:
//! the product of the computed spectra differs from `conj(A) B` by at most `(2 tau + 4 u) |A_k| |B_k|` in the sense of
//! Cauchy and Schwarz over `k`, so what it adds to a sample of the inverse is at most `(2 tau + 4 u) |a|_2 |b|_2`.
//! The inverse adds at most `tau |r|_2` to any sample of the result `r`, and `|r|_2 <= |a|_1 |b|_2` (Young). Signals are
//! summed in the spectrum, so their bounds add, with one `u` more for each sum. In all
//!
//! `error <= sum over signals of ((2 tau + (4 + s) u) |a|_2 |b|_2 + tau |a|_1 |b|_2)`.
//!
//! Rounding is exact if this is below 1/2. Blocks of the template are made so small that it is below [`LIMIT`]; and every
//! value that is rounded is looked at: one farther than that from an integer would discredit the derivation, and the
//! search is repeated by the direct engine.

/// Largest accepted bound; half of what rounding would forgive.
pub(crate) const LIMIT: f64 = 0.25;

const U: f64 = f64::EPSILON / 2.0;

/// Norms of one signal of a template and of the source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms {
    /// `|a|_1`.
    pub(crate) sum: f64,
    /// `|a|_2`.
    pub(crate) template: f64,
    /// `|b|_2` of the worst tile.
    pub(crate) source: f64,
}

/// No sample of a correlation of transforms with `n` samples is farther from its true value.
pub(crate) fn bound(n: usize, signals: impl ExactSizeIterator<Item = Norms>) -> f64 {
    let tau = (8.0 * f64::from(usize::BITS - n.leading_zeros()) + 16.0) * U;
    let first = 2.0 * tau + (4.0 + signals.len() as f64) * U;
    signals.map(|s| (first * s.template + tau * s.sum) * s.source).sum()
}
