//! The kernels for x86-64: AVX2, AVX2 with VNNI, AVX-512 with VNNI. The only unsafe code of the workspace.
#![allow(unsafe_code, reason = "instructions beyond the baseline are called through unsafe functions")]

mod squares;
mod windows;

pub(super) use squares::squares;
pub(super) use windows::{cells, count, lower, lower_places, lower_scaled, slide};

use super::{Block, CHUNK, Level, Row, scalar};
use crate::taps::{Phase, Tap};
use crate::word::Word;
use rustfft::num_complex::Complex;
use std::arch::x86_64::*;

type C64 = Complex<f64>;

pub(super) fn correlate(level: Level, image: &[u32], phases: &[Phase], taps: &[Tap], width: usize, sums: &mut Block) {
    // SAFETY: a level is only made where its features were detected, and the caller has checked that each tap leaves
    // `CHUNK` words of the image to read.
    unsafe {
        match level {
            Level::Scalar => scalar::correlate(image, phases, taps, width, sums),
            Level::Avx2 => avx2::correlate(image, phases, taps, width, sums),
            Level::AvxVnni => avx_vnni::correlate(image, phases, taps, width, sums),
            Level::Avx512 => avx512::correlate(image, phases, taps, width, sums),
        }
    }
}

pub(super) fn finish<W: Word>(level: Level, out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::finish(out, constant, corners, products),
            Level::Avx2 | Level::AvxVnni => finish_avx2(out, constant, corners, products),
            Level::Avx512 => finish_avx512(out, constant, corners, products),
        }
    }
}

#[target_feature(enable = "avx2")]
fn finish_avx2<W: Word>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    scalar::finish(out, constant, corners, products);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn finish_avx512<W: Word>(out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
    scalar::finish(out, constant, corners, products);
}

pub(super) fn scale<W: Word>(level: Level, to: &mut [W], sums: &[i32], factor: W, more: bool) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match (level, more) {
            (Level::Scalar, false) => scalar::scale(to, sums, factor),
            (Level::Scalar, true) => scalar::scale_more(to, sums, factor),
            (Level::Avx2 | Level::AvxVnni, _) => scale_avx2(to, sums, factor, more),
            (Level::Avx512, _) => scale_avx512(to, sums, factor, more),
        }
    }
}

#[target_feature(enable = "avx2")]
fn scale_avx2<W: Word>(to: &mut [W], sums: &[i32], factor: W, more: bool) {
    if more { scalar::scale_more(to, sums, factor) } else { scalar::scale(to, sums, factor) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn scale_avx512<W: Word>(to: &mut [W], sums: &[i32], factor: W, more: bool) {
    if more { scalar::scale_more(to, sums, factor) } else { scalar::scale(to, sums, factor) }
}

pub(super) fn multiply(level: Level, to: &mut [C64], a: &[C64], b: &[C64]) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::multiply(to, a, b),
            Level::Avx2 | Level::AvxVnni => multiply_avx2(to, a, b),
            Level::Avx512 => multiply_avx512(to, a, b),
        }
    }
}

pub(super) fn round<W: Word>(level: Level, z: &[C64], scale: f64, to: &mut [[W; CHUNK]; 2]) -> f64 {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::round(z, scale, to),
            Level::Avx2 | Level::AvxVnni => round_avx2(z, scale, to),
            Level::Avx512 => round_avx512(z, scale, to),
        }
    }
}

pub(super) fn least<W: Word>(level: Level, values: &[W]) -> W {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::least(values),
            Level::Avx2 | Level::AvxVnni => least_avx2(values),
            Level::Avx512 => least_avx512(values),
        }
    }
}

#[target_feature(enable = "avx2")]
fn least_avx2<W: Word>(values: &[W]) -> W {
    scalar::least(values)
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn least_avx512<W: Word>(values: &[W]) -> W {
    scalar::least(values)
}

pub(super) fn weigh(level: Level, to: &mut [u64], from: &[u32], weight: u32) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::weigh(to, from, weight),
            Level::Avx2 | Level::AvxVnni => weigh_avx2(to, from, weight),
            Level::Avx512 => weigh_avx512(to, from, weight),
        }
    }
}

#[target_feature(enable = "avx2")]
fn weigh_avx2(to: &mut [u64], from: &[u32], weight: u32) {
    scalar::weigh(to, from, weight);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn weigh_avx512(to: &mut [u64], from: &[u32], weight: u32) {
    scalar::weigh(to, from, weight);
}

pub(super) fn add(level: Level, to: &mut [u64], from: &[u32], weight: u32) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::add(to, from, weight),
            Level::Avx2 | Level::AvxVnni => add_avx2(to, from, weight),
            Level::Avx512 => add_avx512(to, from, weight),
        }
    }
}

#[target_feature(enable = "avx2")]
fn add_avx2(to: &mut [u64], from: &[u32], weight: u32) {
    scalar::add(to, from, weight);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn add_avx512(to: &mut [u64], from: &[u32], weight: u32) {
    scalar::add(to, from, weight);
}

/// `sum of conj(a) * b`: with `a = ar + i ai`, real and imaginary parts of all signals are summed as `ar * (br, bi)`
/// and `ai * (bi, br)`, and joined at the end.
macro_rules! multiply {
    (
        $name:ident, $features:literal, $lanes:literal,
        $load:ident, $store:ident, $zero:ident, $fma:ident,
        $real:expr, $imaginary:expr, $swap:expr, $join:expr
    ) => {
        #[target_feature(enable = $features)]
        fn $name(to: &mut [C64], a: &[C64], b: &[C64]) {
            let n = to.len();
            assert!(n != 0 && a.len() == b.len(), "signals of the template and of the source");
            let (signals, whole) = (a.len() / n, n - n % $lanes);
            for i in (0..whole).step_by($lanes) {
                let (mut first, mut second) = ($zero(), $zero());
                for s in 0..signals {
                    // SAFETY: `i + lanes <= n` and `s < a.len() / n`, and `b` is as long as `a`. Prefetching beyond the
                    // end is allowed.
                    let (x, y) = unsafe {
                        let at = b.as_ptr().add(s * n + i);
                        _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(signals * n).cast());
                        ($load(a.as_ptr().add(s * n + i).cast()), $load(at.cast()))
                    };
                    first = $fma(($real)(x), y, first);
                    second = $fma(($imaginary)(x), ($swap)(y), second);
                }
                // SAFETY: `i + lanes <= n`, the length of `to`.
                unsafe { $store(to.as_mut_ptr().add(i).cast(), ($join)(first, second)) };
            }
            for i in whole..n {
                to[i] = (0..signals).map(|s| a[s * n + i].conj() * b[s * n + i]).sum();
            }
        }
    };
}

multiply!(
    multiply_avx2,
    "avx2,fma",
    2,
    _mm256_loadu_pd,
    _mm256_storeu_pd,
    _mm256_setzero_pd,
    _mm256_fmadd_pd,
    |x| _mm256_movedup_pd(x),
    |x| _mm256_permute_pd::<0b1111>(x),
    |y| _mm256_permute_pd::<0b0101>(y),
    |first, second| _mm256_fmsubadd_pd(first, _mm256_set1_pd(1.0), second)
);
multiply!(
    multiply_avx512,
    "avx512f,fma",
    4,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_setzero_pd,
    _mm512_fmadd_pd,
    |x| _mm512_movedup_pd(x),
    |x| _mm512_permute_pd::<0b1111_1111>(x),
    |y| _mm512_permute_pd::<0b0101_0101>(y),
    |first, second| _mm512_fmsubadd_pd(first, _mm512_set1_pd(1.0), second)
);

#[target_feature(enable = "avx2")]
fn round_avx2<W: Word>(z: &[C64], scale: f64, to: &mut [[W; CHUNK]; 2]) -> f64 {
    scalar::round(z, scale, to)
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn round_avx512<W: Word>(z: &[C64], scale: f64, to: &mut [[W; CHUNK]; 2]) -> f64 {
    scalar::round(z, scale, to)
}

/// One level: `$vectors` accumulators a row are what its registers hold.
macro_rules! level {
    (
        $name:ident, $features:literal, $vector:ty, $vectors:literal: $($v:literal)*,
        $load:ident, $store:ident, $broadcast:ident, $dot:expr
    ) => {
        mod $name {
            use super::*;

            const LANES: usize = size_of::<$vector>() / 4;

            /// Sums of all phases at `width` positions.
            ///
            /// # Safety
            /// The machine has the features, and each tap's offset leaves `CHUNK` words of the image.
            #[target_feature(enable = $features)]
            pub(super) unsafe fn correlate(
                image: &[u32],
                phases: &[Phase],
                taps: &[Tap],
                width: usize,
                sums: &mut Block,
            ) {
                let all = width.div_ceil(LANES);
                for row in sums.iter_mut() {
                    row[..all * LANES].fill(0);
                }
                // Parts of nearly equal width: a narrow last one would leave multipliers idle.
                let parts = all.div_ceil($vectors).max(1);
                for part in 0..parts {
                    let (first, end) = (part * all / parts, (part + 1) * all / parts);
                    for phase in phases {
                        let taps = &taps[phase.taps.clone()];
                        let rows = &mut sums[phase.first..phase.first + phase.rows];
                        // SAFETY: `end * LANES <= CHUNK`, because `CHUNK` is a multiple of `LANES`.
                        unsafe {
                            match end - first {
                                $($v => by_rows::<$v>(image, taps, first * LANES, rows),)*
                                _ => {}
                            }
                        }
                    }
                }
            }

            /// # Safety
            /// As [`correlate`], and `at + V * LANES <= CHUNK`.
            #[target_feature(enable = $features)]
            unsafe fn by_rows<const V: usize>(image: &[u32], taps: &[Tap], at: usize, rows: &mut [[i32; CHUNK]]) {
                // SAFETY: the caller's.
                unsafe {
                    match rows.len() {
                        1 => accumulate::<1, V>(image, taps, at, rows),
                        2 => accumulate::<2, V>(image, taps, at, rows),
                        3 => accumulate::<3, V>(image, taps, at, rows),
                        _ => accumulate::<4, V>(image, taps, at, rows),
                    }
                }
            }

            /// Adds the taps to `R` rows of `V` vectors, which stay in registers.
            ///
            /// # Safety
            /// As [`by_rows`].
            #[target_feature(enable = $features)]
            unsafe fn accumulate<const R: usize, const V: usize>(
                image: &[u32],
                taps: &[Tap],
                at: usize,
                rows: &mut [[i32; CHUNK]],
            ) {
                debug_assert!(rows.len() == R && at + V * LANES <= CHUNK);
                // SAFETY: rows hold `CHUNK` sums, of which those from `at` on are `V` vectors; images are read at
                // `offset + at .. offset + at + V * LANES`, which the caller has checked to lie inside.
                unsafe {
                    let mut sums = [[$broadcast(0); V]; R];
                    for r in 0..R {
                        for v in 0..V {
                            sums[r][v] = $load(rows[r].as_ptr().add(at + v * LANES).cast());
                        }
                    }
                    for tap in taps {
                        let image = image.as_ptr().add(tap.offset + at);
                        let mut words = [$broadcast(0); R];
                        for r in 0..R {
                            words[r] = $broadcast(tap.words[r] as i32);
                        }
                        for v in 0..V {
                            let pixels = $load(image.add(v * LANES).cast());
                            for r in 0..R {
                                sums[r][v] = ($dot)(sums[r][v], pixels, words[r]);
                            }
                        }
                    }
                    for r in 0..R {
                        for v in 0..V {
                            $store(rows[r].as_mut_ptr().add(at + v * LANES).cast(), sums[r][v]);
                        }
                    }
                }
            }
        }
    };
}

level!(
    avx2, "avx2", __m256i, 2: 1 2,
    _mm256_loadu_si256, _mm256_storeu_si256, _mm256_set1_epi32,
    |sum, pixels, words| _mm256_add_epi32(sum, _mm256_madd_epi16(pixels, words))
);
level!(
    avx_vnni, "avx2,avxvnni", __m256i, 3: 1 2 3,
    _mm256_loadu_si256, _mm256_storeu_si256, _mm256_set1_epi32, _mm256_dpbusd_avx_epi32
);
level!(
    avx512, "avx512f,avx512bw,avx512vl,avx512vnni", __m512i, 6: 1 2 3 4 5 6,
    _mm512_loadu_si512, _mm512_storeu_si512, _mm512_set1_epi32, _mm512_dpbusd_epi32
);
