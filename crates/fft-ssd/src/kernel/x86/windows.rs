//! Sums of squares of windows, for [`nearest`](crate::nearest()).

use super::super::{Cells, Lanes, Level, SHIFTS, Windows, scalar};
use std::arch::x86_64::*;

pub(in crate::kernel) fn cells(level: Level, cells: &Cells<'_>, to: &mut [Lanes]) {
    // SAFETY: a level is only made where its features were detected, and the caller has checked that each tap of each
    // cell leaves `SHIFTS` words of the source to read, and has a word and, if any has, a mask.
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
    (
        $name:ident, $features:literal, $vectors:literal,
        $load:ident, $store:ident, $broadcast:ident,
        $sub:ident, $and:ident, $add:ident, $times:ident, $square:expr
    ) => {
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

/// Plain loops, compiled for wider vectors.
macro_rules! compiled {
    ($($name:ident($($argument:ident: $of:ty),+);)+) => {$(
        pub(in crate::kernel) fn $name(level: Level, $($argument: $of),+) {
            #[target_feature(enable = "avx2")]
            fn avx2($($argument: $of),+) {
                scalar::$name($($argument),+);
            }
            #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
            fn avx512($($argument: $of),+) {
                scalar::$name($($argument),+);
            }
            // SAFETY: a level is only made where its features were detected.
            unsafe {
                match level {
                    Level::Scalar => scalar::$name($($argument),+),
                    Level::Avx2 | Level::AvxVnni => avx2($($argument),+),
                    Level::Avx512 => avx512($($argument),+),
                }
            }
        }
    )+};
}

compiled! {
    slide(sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]);
    lower(windows: &Windows<'_>, code: u32, best: &mut [Lanes], codes: &mut [Lanes]);
    count(windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]);
    lower_places(windows: &Windows<'_>, n: usize, least: &mut [u32]);
    lower_scaled(windows: &Windows<'_>, factors: &[f32], code: u32, best: &mut [[f32; SHIFTS]], codes: &mut [Lanes]);
}
