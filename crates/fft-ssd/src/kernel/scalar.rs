//! The definition of the kernels, in plain loops.

use super::{Block, Row};
use crate::taps::{Phase, Tap};
use crate::word::Word;

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
        *out = constant.minus(product).minus(product);
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
