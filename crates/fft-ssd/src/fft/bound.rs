//! How far a computed correlation can be from the integer that it stands for.
//!
//! Let `u = 2^-53`. A computed transform satisfies `|F computed - F|_2 <= tau |F|_2`. What `tau` is follows from the
//! roots of unity and from the passes.
//!
//! *Roots.* The transform's library computes the angle of root `i` of `n` as `(2 pi / n) * i`: the quotient is wrong by
//! 2 u of itself (the rounded pi, the division), the product by one more, so an angle of at most `2 pi` is wrong by at
//! most `3 * 2 pi u < 19 u`, and so is the root; its two rounded parts add less than `3 u`. Every root is within
//! `22 u` of the true one.
//!
//! *Passes of two.* A pass multiplies by roots (22 u, and `sqrt(2) * 2 u` for the product, Higham 2002, lemma 3.5) and
//! adds pairs (u): less than 28 u by theorem 24.2 of the same. Passes of four, eight and sixteen are made of those,
//! with roots that are known better.
//!
//! *Passes of `r` = 3 and 5.* Besides the product with roots (25 u), each of `r` sums of `r` products with roots is
//! wrong by `(22 + 3 + r - 1) u` times the sum of the absolute values, which is at most `sqrt(r)` times their norm; of
//! `r` sums together that is `sqrt(r) (24 + r) u` of the norm of the result: 47 u for 3, 65 u for 5. In all 72 u for a
//! factor of 3 and 90 u for one of 5: for each factor of two that they hold 46 u and 39 u.
//!
//! So `tau <= 46 u log2(n)`, rounded up to whole factors; 16 u more are for what is added around: parting two rows,
//! scaling, and terms in `u^2`. Passing two real rows through one complex row loses nothing: the two errors together
//! are the complex row's.
//!
//! For one pair of signals `a` (template) and `b` (tile of the source), with `A`, `B` their spectra,
//! `|A|_2 = sqrt(n) |a|_2`: the product of the computed spectra differs from `conj(A) B` by at most
//! `(2 tau + 4 u) |A_k| |B_k|` in the sense of Cauchy and Schwarz over `k`, so what it adds to a sample of the inverse
//! is at most `(2 tau + 4 u) |a|_2 |b|_2`. The inverse adds at most `tau |r|_2` to any sample of the result `r`, and
//! `|r|_2 <= |a|_1 |b|_2` (Young). Signals are summed in the spectrum, so their bounds add, with one `u` more for each
//! sum. In all
//!
//! `error <= sum over signals of ((2 tau + (4 + s) u) |a|_2 |b|_2 + tau |a|_1 |b|_2)`.
//!
//! Rounding is exact if this is below 1/2. Blocks of the template, and parts of their samples, are made so small that
//! it is below [`LIMIT`]; and every value that is rounded is looked at: one farther than the bound from an integer
//! would discredit the derivation, and the search is repeated by the direct engine.

/// Largest accepted bound; half of what rounding would forgive.
pub(crate) const LIMIT: f64 = 0.25;

const U: f64 = f64::EPSILON / 2.0;

/// No root of unity is farther from the true one, in `u`.
#[cfg(test)]
const ROOT: f64 = 22.0;

/// Largest relative error of a pass, in `u`, for each factor of two of its size.
const PASS: f64 = 46.0;

/// Largest relative error of a transform of `n` samples.
fn tau(n: usize) -> f64 {
    (PASS * f64::from(usize::BITS - n.leading_zeros()) + 16.0) * U
}

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
    let tau = tau(n);
    let first = 2.0 * tau + (4.0 + signals.len() as f64) * U;
    signals.map(|s| (first * s.template + tau * s.sum) * s.source).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::{FftPlanner, FftPlannerScalar, num_complex::Complex};

    /// Root `i` of `n`, from an angle of at most an eighth turn, which is rounded least.
    #[expect(clippy::disallowed_methods, reason = "checks the library's own sines; nothing is decided by them")]
    fn root(i: usize, n: usize) -> Complex<f64> {
        let eighth = (8 * i + n / 2) / n;
        let angle = (8 * i) as f64 - (eighth * n) as f64;
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * angle / n as f64).sin_cos();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turned = [
            Complex::new(cos, sin),
            Complex::new((cos - sin) * half, (cos + sin) * half),
            Complex::new(-sin, cos),
            Complex::new((-cos - sin) * half, (cos - sin) * half),
        ];
        let root = turned[eighth % 4];
        if (eighth / 4).is_multiple_of(2) { root } else { -root }
    }

    #[test]
    fn transforms_of_a_point_are_roots_of_unity_within_the_bound() {
        for n in
            [2, 3, 4, 5, 8, 9, 15, 16, 25, 27, 30, 48, 60, 64, 125, 243, 256, 360, 625, 768, 1024, 1280, 2187, 4096]
        {
            let plans = [FftPlannerScalar::new().plan_fft_inverse(n), FftPlanner::new().plan_fft_inverse(n)];
            for plan in plans {
                let mut line = vec![Complex::new(0.0, 0.0); n];
                line[1] = Complex::new(1.0, 0.0);
                plan.process(&mut line);
                let error = |(i, z): (usize, &Complex<f64>)| (z - root(i, n)).norm();
                let worst = line.iter().enumerate().map(error).fold(0.0, f64::max);
                // One sample goes through one product a pass; what stands in for the truth is wrong by less than 4 u.
                let passes = f64::from(usize::BITS - n.leading_zeros());
                assert!(worst <= (passes * (ROOT + 3.0) + 4.0) * U, "{n}: {} u", worst / U);
                let squares: f64 = line.iter().enumerate().map(|(i, z)| (z - root(i, n)).norm_sqr()).sum();
                assert!((squares / n as f64).sqrt() <= tau(n), "{n}");
            }
        }
    }
}
