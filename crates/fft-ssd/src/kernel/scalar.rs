//! The definition of the kernels, in plain loops.

use super::{Block, Row};
use crate::taps::{Phase, Tap};
use crate::word::Word;
use rustfft::num_complex::Complex;

type C64 = Complex<f64>;

/// Sums of products of 16-bit pairs.
pub(super) fn correlate(image: &[u32], phases: &[Phase], taps: &[Tap], width: usize, sums: &mut Block) {
    *sums = [[0; super::CHUNK]; crate::taps::ROWS];
    for phase in phases {
        for tap in &taps[phase.taps.clone()] {
            let image = &image[tap.offset as usize..][..width];
            for (sums, &word) in sums[phase.first..][..phase.rows].iter_mut().zip(&tap.words) {
                let (low, high) = (i32::from(word as i16), i32::from((word >> 16) as i16));
                for (sum, &i) in sums.iter_mut().zip(image) {
                    let product = i32::from(i as i16) * low + i32::from((i >> 16) as i16) * high;
                    *sum = sum.wrapping_add(product);
                }
            }
        }
    }
}

/// See [`super::Kernel::finish`]. Compiled once for each level.
#[inline(always)]
pub(super) fn finish<W: Word>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    let n = out.len();
    for (out, &product) in out.iter_mut().zip(products) {
        *out = constant.plus(product);
    }
    for &at in corners.plus {
        for (out, &sum) in out.iter_mut().zip(&corners.table[at..at + n]) {
            *out = out.plus(sum);
        }
    }
    for &at in corners.minus {
        for (out, &sum) in out.iter_mut().zip(&corners.table[at..at + n]) {
            *out = out.minus(sum);
        }
    }
}

/// See [`super::Kernel::multiply`]. Compiled once for each level.
#[inline(always)]
pub(super) fn multiply(to: &mut [C64], a: &[C64], b: &[C64], first: bool) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        let product = C64::new(a.re * b.re + a.im * b.im, a.re * b.im - a.im * b.re);
        *to = if first { product } else { *to + product };
    }
}

/// See [`super::Kernel::round`]. Compiled once for each level.
#[inline(always)]
pub(super) fn round<W: Word>(z: &[C64], scale: f64, to: &mut [[W; super::CHUNK]; 2]) -> f64 {
    // Adding 1.5 * 2^52 leaves no bits for a fraction: the sum is rounded, and its last bits are the integer.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    let mut worst = [0.0_f64; 2];
    let [re, im] = to;
    for ((z, re), im) in z.iter().zip(re).zip(im) {
        for ((value, to), worst) in [z.re, z.im].into_iter().zip([re, im]).zip(&mut worst) {
            let value = value * scale;
            let shifted = value + SHIFT;
            let off = (value - (shifted - SHIFT)).abs();
            *worst = if *worst < off { off } else { *worst };
            *to = W::wrapping(shifted.to_bits().wrapping_sub(SHIFT.to_bits()) as i64);
        }
    }
    worst[0].max(worst[1])
}
