//! Sums of squares of windows, for [`nearest`](crate::nearest()).

use super::super::{Cells, Lanes, Level, SHIFTS, Windows, scalar};
use std::arch::x86_64::*;

pub(in crate::kernel) fn cells(level: Level, cells: &Cells<'_>, to: &mut [Lanes]) {
    // SAFETY: a level is only made where its features were detected, and the caller has checked that each tap of each cell
    // leaves `SHIFTS` words of the source to read, and has a word and, if any has, a mask.
    unsafe {
        match level {
            Level::Scalar => scalar::cells(cells, to),
            Level::Avx2 => cells_avx2(cells, to),
            Level::AvxVnni => cells_avx_vnni(cells, to),
            Level::Avx512 => cells_avx512(cells, to),
        }
    }
}

/// Squares of differences of 16-bit pairs: `V` vectors of displacements stay in registers while a cell is summed.
macro_rules! cells {
    ($name:ident, $features:literal, $vectors:literal, $load:ident, $store:ident, $broadcast:ident, $sub:ident, $and:ident, $add:ident, $times:ident, $square:expr) => {
        /// # Safety
        /// The processor has the features, and each tap of each cell leaves [`SHIFTS`] words of the source to read.
        #[target_feature(enable = $features)]
        unsafe fn $name(cells: &Cells<'_>, to: &mut [Lanes]) {
            const WIDTH: usize = SHIFTS / $vectors;
            let (taps, masked) = (cells.offsets.len(), !cells.masks.is_empty());
            let weight = $broadcast(cells.weight as i32);
            for (i, to) in to.iter_mut().enumerate() {
                let mut sums = [$broadcast(0); $vectors];
                // SAFETY: the caller's; `to` holds `SHIFTS` sums.
                unsafe {
                    let source = cells.source.as_ptr().add(i * cells.step);
                    let words = cells.words.get_unchecked(i * taps..(i + 1) * taps);
                    for (t, (&offset, &word)) in cells.offsets.iter().zip(words).enumerate() {
                        let word = $broadcast(word as i32);
                        for v in 0..$vectors {
                            let mut difference = $sub($load(source.add(offset + v * WIDTH).cast()), word);
                            if masked {
                                let mask = *cells.masks.get_unchecked(i * taps + t);
                                difference = $and(difference, $broadcast(mask as i32));
                            }
                            sums[v] = ($square)(sums[v], difference);
                        }
                    }
                    for v in 0..$vectors {
                        let to: *mut u32 = to.as_mut_ptr().add(v * WIDTH);
                        let before = if cells.more { $load(to.cast()) } else { $broadcast(0) };
                        $store(to.cast(), $add(before, $times(sums[v], weight)));
                    }
                }
            }
        }
    };
}

cells!(
    cells_avx2,
    "avx2",
    2,
    _mm256_loadu_si256,
    _mm256_storeu_si256,
    _mm256_set1_epi32,
    _mm256_sub_epi16,
    _mm256_and_si256,
    _mm256_add_epi32,
    _mm256_mullo_epi32,
    |sum, d| _mm256_add_epi32(sum, _mm256_madd_epi16(d, d))
);
cells!(
    cells_avx_vnni,
    "avx2,avxvnni",
    2,
    _mm256_loadu_si256,
    _mm256_storeu_si256,
    _mm256_set1_epi32,
    _mm256_sub_epi16,
    _mm256_and_si256,
    _mm256_add_epi32,
    _mm256_mullo_epi32,
    |sum, d| _mm256_dpwssd_avx_epi32(sum, d, d)
);
cells!(
    cells_avx512,
    "avx512f,avx512bw,avx512vl,avx512vnni",
    1,
    _mm512_loadu_si512,
    _mm512_storeu_si512,
    _mm512_set1_epi32,
    _mm512_sub_epi16,
    _mm512_and_si512,
    _mm512_add_epi32,
    _mm512_mullo_epi32,
    |sum, d| _mm512_dpwssd_epi32(sum, d, d)
);

pub(in crate::kernel) fn slide(level: Level, sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::slide(sums, row, old),
            Level::Avx2 | Level::AvxVnni => slide_avx2(sums, row, old),
            Level::Avx512 => slide_avx512(sums, row, old),
        }
    }
}

#[target_feature(enable = "avx2")]
fn slide_avx2(sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]) {
    scalar::slide(sums, row, old);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn slide_avx512(sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]) {
    scalar::slide(sums, row, old);
}

pub(in crate::kernel) fn lower(
    level: Level,
    windows: &Windows<'_>,
    code: u32,
    best: &mut [Lanes],
    codes: &mut [Lanes],
) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::lower(windows, code, best, codes),
            Level::Avx2 | Level::AvxVnni => lower_avx2(windows, code, best, codes),
            Level::Avx512 => lower_avx512(windows, code, best, codes),
        }
    }
}

#[target_feature(enable = "avx2")]
fn lower_avx2(windows: &Windows<'_>, code: u32, best: &mut [Lanes], codes: &mut [Lanes]) {
    scalar::lower(windows, code, best, codes);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn lower_avx512(windows: &Windows<'_>, code: u32, best: &mut [Lanes], codes: &mut [Lanes]) {
    scalar::lower(windows, code, best, codes);
}

pub(in crate::kernel) fn count(level: Level, windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::count(windows, skip, most, counts),
            Level::Avx2 | Level::AvxVnni => count_avx2(windows, skip, most, counts),
            Level::Avx512 => count_avx512(windows, skip, most, counts),
        }
    }
}

#[target_feature(enable = "avx2")]
fn count_avx2(windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]) {
    scalar::count(windows, skip, most, counts);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn count_avx512(windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]) {
    scalar::count(windows, skip, most, counts);
}

pub(in crate::kernel) fn lower_places(level: Level, windows: &Windows<'_>, n: usize, least: &mut [u32]) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::lower_places(windows, n, least),
            Level::Avx2 | Level::AvxVnni => lower_places_avx2(windows, n, least),
            Level::Avx512 => lower_places_avx512(windows, n, least),
        }
    }
}

#[target_feature(enable = "avx2")]
fn lower_places_avx2(windows: &Windows<'_>, n: usize, least: &mut [u32]) {
    scalar::lower_places(windows, n, least);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn lower_places_avx512(windows: &Windows<'_>, n: usize, least: &mut [u32]) {
    scalar::lower_places(windows, n, least);
}

pub(in crate::kernel) fn lower_scaled(
    level: Level,
    windows: &Windows<'_>,
    factors: &[f32],
    code: u32,
    best: &mut [[f32; SHIFTS]],
    codes: &mut [Lanes],
) {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::lower_scaled(windows, factors, code, best, codes),
            Level::Avx2 | Level::AvxVnni => lower_scaled_avx2(windows, factors, code, best, codes),
            Level::Avx512 => lower_scaled_avx512(windows, factors, code, best, codes),
        }
    }
}

#[target_feature(enable = "avx2")]
fn lower_scaled_avx2(
    windows: &Windows<'_>,
    factors: &[f32],
    code: u32,
    best: &mut [[f32; SHIFTS]],
    codes: &mut [Lanes],
) {
    scalar::lower_scaled(windows, factors, code, best, codes);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
fn lower_scaled_avx512(
    windows: &Windows<'_>,
    factors: &[f32],
    code: u32,
    best: &mut [[f32; SHIFTS]],
    codes: &mut [Lanes],
) {
    scalar::lower_scaled(windows, factors, code, best, codes);
}
