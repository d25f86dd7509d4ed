//! The definition of the kernels, in plain loops.

use super::{Block, Cells, Lanes, Row, SHIFTS, Windows};
use crate::stretch::Stretch;
use crate::taps::{Phase, Tap};
use crate::word::Word;
use rustfft::num_complex::Complex;

type C64 = Complex<f64>;

/// Sums of products of 16-bit pairs.
pub(super) fn correlate(image: &[u32], phases: &[Phase], taps: &[Tap], width: usize, sums: &mut Block) {
    *sums = [[0; super::CHUNK]; crate::taps::ROWS];
    for phase in phases {
        for tap in &taps[phase.taps.clone()] {
            let image = &image[tap.offset..][..width];
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

/// Positions of a row that are summed together: a few vectors, which stay in registers.
const TOGETHER: usize = 32;

/// See [`super::Kernel::finish`]. Compiled once for each level.
#[inline(always)]
pub(super) fn finish<W: Word>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    if TOGETHER <= out.len() {
        finish_by::<W, TOGETHER>(out, constant, corners, products);
    } else {
        finish_by::<W, 1>(out, constant, corners, products);
    }
}

/// `N` positions at a time; the last ones may be computed twice.
#[inline(always)]
fn finish_by<W: Word, const N: usize>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    for x in (0..out.len()).step_by(N) {
        let x = x.min(out.len() - N);
        finish_some::<W, N>(&mut out[x..], constant, corners, &products[x..], x);
    }
}

/// `N` positions, the first of them `x` places from the row's.
#[inline(always)]
fn finish_some<W: Word, const N: usize>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W], x: usize) {
    // Plain loops: closures would be compiled for the baseline.
    let mut sums = [constant; N];
    for &at in corners.plus {
        let table = &corners.table[at + x..][..N];
        for i in 0..N {
            sums[i] = sums[i].plus(table[i]);
        }
    }
    for &at in corners.minus {
        let table = &corners.table[at + x..][..N];
        for i in 0..N {
            sums[i] = sums[i].minus(table[i]);
        }
    }
    let (out, products) = (&mut out[..N], &products[..N]);
    for i in 0..N {
        out[i] = sums[i].plus(products[i]);
    }
}

/// See [`super::Kernel::scale`]. Compiled once for each level.
#[inline(always)]
pub(super) fn scale<W: Word>(to: &mut [W], sums: &[i32], factor: W) {
    for (to, &sum) in to.iter_mut().zip(sums) {
        *to = W::wrapping(i64::from(sum)).times(factor);
    }
}

/// See [`super::Kernel::scale`]. Compiled once for each level.
#[inline(always)]
pub(super) fn scale_more<W: Word>(to: &mut [W], sums: &[i32], factor: W) {
    for (to, &sum) in to.iter_mut().zip(sums) {
        *to = to.plus(W::wrapping(i64::from(sum)).times(factor));
    }
}

/// See [`super::Kernel::multiply`].
pub(super) fn multiply(to: &mut [C64], a: &[C64], b: &[C64]) {
    to.fill(C64::default());
    for (a, b) in a.chunks_exact(to.len()).zip(b.chunks_exact(to.len())) {
        for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
            *to += C64::new(a.re * b.re + a.im * b.im, a.re * b.im - a.im * b.re);
        }
    }
}

/// See [`super::Kernel::round`]. Compiled once for each level.
#[inline(always)]
pub(super) fn round<W: Word>(z: &[C64], scale: f64, to: &mut [[W; super::CHUNK]; 2]) -> f64 {
    // Adding 1.5 * 2^52 leaves no bits for a fraction: the sum is rounded, and its last bits are the integer.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    // Distances are compared by their bits, which vectors can do in any order; what is no number is the largest.
    let mut worst = 0_u64;
    for (part, to) in to.iter_mut().enumerate() {
        for (z, to) in z.iter().zip(to) {
            let value = if part == 0 { z.re } else { z.im } * scale;
            let shifted = value + SHIFT;
            worst = worst.max((value - (shifted - SHIFT)).abs().to_bits());
            *to = W::wrapping(shifted.to_bits().wrapping_sub(SHIFT.to_bits()) as i64);
        }
    }
    f64::from_bits(worst)
}

/// See [`super::Kernel::least`]. Compiled once for each level.
#[inline(always)]
pub(super) fn least<W: Word>(values: &[W]) -> W {
    values.iter().fold(W::NONE, |least, &v| least.min(v))
}

/// See [`super::Kernel::squares`].
pub(super) fn squares(own: &[u8], source: &[u8], stride: usize, all: &[Stretch]) -> u64 {
    let of = |s: &Stretch| squares_of(&own[s.own..][..s.len], &source[s.at[0] * stride + s.at[1]..][..s.len]);
    all.iter().map(of).sum()
}

/// Of so few bytes that 32 bits hold the sum.
pub(super) fn squares_of(a: &[u8], b: &[u8]) -> u64 {
    let square = |(&a, &b): (&u8, &u8)| u32::from(a.abs_diff(b)).pow(2);
    a.iter().zip(b).map(square).sum::<u32>().into()
}

/// See [`super::Kernel::weigh`]. Compiled once for each level.
#[inline(always)]
pub(super) fn weigh(to: &mut [u64], from: &[u32], weight: u32) {
    for (to, &v) in to.iter_mut().zip(from) {
        *to = u64::from(v) * u64::from(weight);
    }
}

/// See [`super::Kernel::add`]. Compiled once for each level.
#[inline(always)]
pub(super) fn add(to: &mut [u64], from: &[u32], weight: u32) {
    for (to, &v) in to.iter_mut().zip(from) {
        *to = to.wrapping_add(u64::from(v) * u64::from(weight));
    }
}

/// See [`super::Kernel::cells`].
pub(super) fn cells(cells: &Cells<'_>, to: &mut [Lanes]) {
    let taps = cells.offsets.len();
    for (i, to) in to.iter_mut().enumerate() {
        let mut sums = [0_u32; SHIFTS];
        for (t, &offset) in cells.offsets.iter().enumerate() {
            let word = cells.words[i * taps + t];
            let mask = cells.masks.get(i * taps + t).copied().unwrap_or(u32::MAX);
            let source = &cells.source[i * cells.step + offset..][..SHIFTS];
            for (sum, &s) in sums.iter_mut().zip(source) {
                let half = |shift: u32| {
                    let difference = i32::from((s >> shift) as i16) - i32::from((word >> shift) as i16);
                    if mask >> shift & 1 == 0 { 0 } else { (difference * difference) as u32 }
                };
                *sum += half(0) + half(16);
            }
        }
        for (to, sum) in to.iter_mut().zip(sums) {
            *to = if cells.more { *to } else { 0 }.wrapping_add(sum.wrapping_mul(cells.weight));
        }
    }
}

/// See [`super::Kernel::slide`]. Compiled once for each level.
#[inline(always)]
pub(super) fn slide(sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]) {
    for ((sums, row), old) in sums.iter_mut().zip(row).zip(old) {
        for i in 0..SHIFTS {
            sums[i] = sums[i].wrapping_add(row[i]).wrapping_sub(old[i]);
        }
        *old = *row;
    }
}

/// Calls `each(i, sums)` for each window, marked ones with all ones. Compiled once for each level.
#[inline(always)]
fn each_window(windows: &Windows<'_>, n: usize, mut each: impl FnMut(usize, &Lanes)) {
    let mut sums = [0_u32; SHIFTS];
    for column in &windows.columns[..windows.cells - 1] {
        for i in 0..SHIFTS {
            sums[i] = sums[i].wrapping_add(column[i]);
        }
    }
    for w in 0..n {
        let (new, old) = (&windows.columns[w + windows.cells - 1], &windows.columns[w]);
        let marks = &windows.marks[w * windows.step..][..SHIFTS];
        let mut marked = [0_u32; SHIFTS];
        for i in 0..SHIFTS {
            let sum = sums[i].wrapping_add(new[i]);
            marked[i] = sum | marks[i];
            sums[i] = sum.wrapping_sub(old[i]);
        }
        each(w, &marked);
    }
}

/// See [`super::Kernel::lower`]. Compiled once for each level.
#[inline(always)]
pub(super) fn lower(windows: &Windows<'_>, code: u32, best: &mut [Lanes], codes: &mut [Lanes]) {
    assert_eq!(best.len(), codes.len());
    each_window(windows, best.len(), |w, sums| {
        let (best, codes) = (&mut best[w], &mut codes[w]);
        for i in 0..SHIFTS {
            let is_less = sums[i] < best[i];
            codes[i] = if is_less { code } else { codes[i] };
            best[i] = if is_less { sums[i] } else { best[i] };
        }
    });
}

/// See [`super::Kernel::count`]. Compiled once for each level.
#[inline(always)]
pub(super) fn count(windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]) {
    each_window(windows, counts.len(), |w, sums| {
        let counts = &mut counts[w];
        for i in 0..SHIFTS {
            counts[i] += u32::from((sums[i] | skip[i]) <= most);
        }
    });
}

/// See [`super::Kernel::lower_places`]. Compiled once for each level.
#[inline(always)]
pub(super) fn lower_places(windows: &Windows<'_>, n: usize, least: &mut [u32]) {
    each_window(windows, n, |w, sums| {
        let least = &mut least[w * windows.step..][..SHIFTS];
        for i in 0..SHIFTS {
            least[i] = least[i].min(sums[i]);
        }
    });
}

/// See [`super::Kernel::lower_scaled`]. Compiled once for each level.
#[inline(always)]
pub(super) fn lower_scaled(
    windows: &Windows<'_>,
    factors: &[f32],
    code: u32,
    best: &mut [[f32; SHIFTS]],
    codes: &mut [Lanes],
) {
    assert_eq!(best.len(), codes.len());
    each_window(windows, best.len(), |w, sums| {
        let (best, codes) = (&mut best[w], &mut codes[w]);
        let factors = &factors[w * windows.step..][..SHIFTS];
        for i in 0..SHIFTS {
            // Marked sums are far more than any other, and below infinity.
            let scaled = sums[i] as f32 * factors[i];
            let is_less = scaled < best[i];
            codes[i] = if is_less { code } else { codes[i] };
            best[i] = if is_less { scaled } else { best[i] };
        }
    });
}
