//! Squares of differences of bytes, for [`Pattern`](crate::Pattern).

use super::super::{Level, scalar};
use crate::stretch::Stretch;
use std::arch::x86_64::*;

pub(in crate::kernel) fn squares(level: Level, own: &[u8], source: &[u8], stride: usize, all: &[Stretch]) -> u64 {
    // SAFETY: a level is only made where its features were detected.
    unsafe {
        match level {
            Level::Scalar => scalar::squares(own, source, stride, all),
            Level::Avx2 | Level::AvxVnni => squares_avx2(own, source, stride, all),
            Level::Avx512 => squares_avx512(own, source, stride, all),
        }
    }
}

/// Steps after which a lane is taken: each adds at most `2 * 255^2`, and it holds 32 bits.
const STEPS: usize = 1 << 14;

/// # Safety
/// The machine has the features. Stretches that do not lie inside of both panic.
#[target_feature(enable = "avx2")]
unsafe fn squares_avx2(own: &[u8], source: &[u8], stride: usize, all: &[Stretch]) -> u64 {
    let (mut sum, mut lanes, mut steps) = (0_u64, _mm256_setzero_si256(), 0);
    for s in all {
        let (own, source) = (&own[s.own..][..s.len], &source[s.at[0] * stride + s.at[1]..][..s.len]);
        for i in (0..s.len / 16).map(|i| 16 * i) {
            // SAFETY: `i + 16 <= s.len`, and both hold `s.len` bytes.
            let [a, b] = unsafe { [own.as_ptr().add(i), source.as_ptr().add(i)].map(|p| _mm_loadu_si128(p.cast())) };
            let d = _mm256_sub_epi16(_mm256_cvtepu8_epi16(a), _mm256_cvtepu8_epi16(b));
            lanes = _mm256_add_epi32(lanes, _mm256_madd_epi16(d, d));
        }
        sum += scalar::squares_of(&own[s.len / 16 * 16..], &source[s.len / 16 * 16..]);
        steps += s.len / 16;
        if STEPS < steps {
            sum += total_avx2(lanes);
            (lanes, steps) = (_mm256_setzero_si256(), 0);
        }
    }
    sum + total_avx2(lanes)
}

#[target_feature(enable = "avx2")]
fn total_avx2(lanes: __m256i) -> u64 {
    let mut all = [0_u32; 8];
    // SAFETY: eight times four bytes.
    unsafe { _mm256_storeu_si256(all.as_mut_ptr().cast(), lanes) };
    all.iter().map(|&n| u64::from(n)).sum()
}

/// # Safety
/// The machine has the features. Stretches that do not lie inside of both panic.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vnni")]
unsafe fn squares_avx512(own: &[u8], source: &[u8], stride: usize, all: &[Stretch]) -> u64 {
    let (mut sum, mut lanes, mut steps) = (0_u64, _mm512_setzero_si512(), 0);
    for s in all {
        let (own, source) = (&own[s.own..][..s.len], &source[s.at[0] * stride + s.at[1]..][..s.len]);
        for i in (0..s.len).step_by(32) {
            let mask = u32::MAX >> 32_usize.saturating_sub(s.len - i);
            // SAFETY: no more than `s.len` bytes are read, which both hold.
            let [a, b] = unsafe {
                [own.as_ptr().add(i), source.as_ptr().add(i)].map(|p| _mm256_maskz_loadu_epi8(mask, p.cast()))
            };
            let d = _mm512_sub_epi16(_mm512_cvtepu8_epi16(a), _mm512_cvtepu8_epi16(b));
            lanes = _mm512_dpwssd_epi32(lanes, d, d);
        }
        steps += s.len / 32 + 1;
        if STEPS < steps {
            sum += total_avx512(lanes);
            (lanes, steps) = (_mm512_setzero_si512(), 0);
        }
    }
    sum + total_avx512(lanes)
}

#[target_feature(enable = "avx512f")]
fn total_avx512(lanes: __m512i) -> u64 {
    let mut all = [0_u32; 16];
    // SAFETY: sixteen times four bytes.
    unsafe { _mm512_storeu_si512(all.as_mut_ptr().cast(), lanes) };
    all.iter().map(|&n| u64::from(n)).sum()
}
