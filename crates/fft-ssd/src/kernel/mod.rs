//! The inner loops, for each set of instructions; the plain loops of [`scalar`] are their definition.
//!
//! Lanes are positions: a vector holds consecutive words of the packed source, and each tap multiplies it with one word
//! of the template. All levels give the same sums modulo 2^32.

mod scalar;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::pack::{self, Packing};
use crate::stretch::Stretch;
use crate::taps::{ROWS, Taps};
use crate::word::Word;
use rustfft::num_complex::Complex;
use selvedge_core::SimdLevel;

/// Positions along x that a block has at most: six vectors of 16, the widest that a kernel sums at once in registers.
pub(crate) const CHUNK: usize = 96;

/// Displacements that are compared at once: one vector of AVX-512, two of AVX2.
pub(crate) const SHIFTS: usize = 16;

/// One value for each of them.
pub(crate) type Lanes = [u32; SHIFTS];

/// The sums of a block: four rows of positions.
pub(crate) type Block = [[i32; CHUNK]; ROWS];

/// A set of instructions that this machine has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kernel(Level);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Level {
    #[default]
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    AvxVnni,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kernel {
    /// The best that the machine has and the caller allows.
    pub(crate) fn new(allowed: SimdLevel) -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vnni");
            if SimdLevel::Avx512 <= allowed && avx512 && avx2 {
                return Self(Level::Avx512);
            }
            if SimdLevel::AvxVnni <= allowed && is_x86_feature_detected!("avxvnni") && avx2 {
                return Self(Level::AvxVnni);
            }
            if SimdLevel::Avx2 <= allowed && avx2 {
                return Self(Level::Avx2);
            }
        }
        let _ = allowed;
        Self(Level::Scalar)
    }

    /// What it is.
    pub(crate) fn level(self) -> SimdLevel {
        match self.0 {
            Level::Scalar => SimdLevel::Scalar,
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => SimdLevel::Avx2,
            #[cfg(target_arch = "x86_64")]
            Level::AvxVnni => SimdLevel::AvxVnni,
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => SimdLevel::Avx512,
        }
    }

    /// True if only plain loops are allowed.
    pub(crate) fn is_scalar(self) -> bool {
        self.0 == Level::Scalar
    }

    /// `to = sum of conj(a) * b` over as many signals of `to.len()` values as `a` and `b` hold.
    ///
    /// # Panics
    /// If `a` and `b` differ in length.
    pub(crate) fn multiply(self, to: &mut [Complex<f64>], a: &[Complex<f64>], b: &[Complex<f64>]) {
        assert!(a.len() == b.len() && !to.is_empty(), "signals of the template and of the source");
        match self.0 {
            Level::Scalar => scalar::multiply(to, a, b),
            #[cfg(target_arch = "x86_64")]
            level => x86::multiply(level, to, a, b),
        }
    }

    /// Integers nearest to `scale * z`, real parts first, and their largest distance from it. Distances from 2^51 on
    /// are not seen.
    pub(crate) fn round<W: Word>(self, z: &[Complex<f64>], scale: f64, to: &mut [[W; CHUNK]; 2]) -> f64 {
        match self.0 {
            Level::Scalar => scalar::round(z, scale, to),
            #[cfg(target_arch = "x86_64")]
            level => x86::round(level, z, scale, to),
        }
    }

    /// About how many nanoseconds a sample of a template takes at a position. Measured on L-shaped overlaps of 36 by 6
    /// samples in 192^2, three channels, one thread.
    pub(crate) fn products(self, weights: &[u8]) -> f64 {
        let words: f64 = Packing::of(weights.len(), self.lanes()).map(|p| 1.0 / p.pixels as f64).sum();
        let heavy = weights.iter().any(|&w| 1 < w) && self.lanes() == pack::Lanes::Bytes;
        let parts = if heavy { 2.0 } else { 1.0 };
        match self.0 {
            Level::Scalar => words * parts / 1.6,
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => words * parts / 24.0,
            #[cfg(target_arch = "x86_64")]
            Level::AvxVnni => words * parts / 20.0,
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => words * parts / 50.0,
        }
    }

    /// How sources and templates must be packed for it.
    pub(crate) fn lanes(self) -> pack::Lanes {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::AvxVnni | Level::Avx512 => pack::Lanes::Bytes,
            _ => pack::Lanes::Pairs,
        }
    }

    /// Sums of one group of taps at `width` positions of four rows, the first of them at word `base` of the image.
    ///
    /// # Panics
    /// If a tap would read beyond the image.
    pub(crate) fn correlate(
        self,
        image: &[u32],
        base: usize,
        taps: &Taps,
        group: usize,
        width: usize,
        sums: &mut Block,
    ) {
        assert!(width <= CHUNK && base + taps.reach + CHUNK <= image.len(), "taps reach beyond the packed source");
        let phases = &taps.phases[taps.groups[group].phases.clone()];
        let image = &image[base..];
        match self.0 {
            Level::Scalar => scalar::correlate(image, phases, &taps.taps, width, sums),
            #[cfg(target_arch = "x86_64")]
            level => x86::correlate(level, image, phases, &taps.taps, width, sums),
        }
    }

    /// `out = constant + tables at plus - tables at minus + products`, position by position.
    pub(crate) fn finish<W: Word>(self, out: &mut [W], constant: W, corners: &Row<'_, W>, products: &[W]) {
        match self.0 {
            Level::Scalar => scalar::finish(out, constant, corners, products),
            #[cfg(target_arch = "x86_64")]
            level => x86::finish(level, out, constant, corners, products),
        }
    }

    /// `to = factor * sums`, or that added to what is there.
    pub(crate) fn scale<W: Word>(self, to: &mut [W], sums: &[i32], factor: W, more: bool) {
        match self.0 {
            Level::Scalar if more => scalar::scale_more(to, sums, factor),
            Level::Scalar => scalar::scale(to, sums, factor),
            #[cfg(target_arch = "x86_64")]
            level => x86::scale(level, to, sums, factor, more),
        }
    }

    /// The least value; [`Word::NONE`] of none.
    pub(crate) fn least<W: Word>(self, values: &[W]) -> W {
        match self.0 {
            Level::Scalar => scalar::least(values),
            #[cfg(target_arch = "x86_64")]
            level => x86::least(level, values),
        }
    }

    /// The sum of the squared differences of stretches of a template of a shape, of one channel: of its plane, and of
    /// the source's from the place on, whose rows are `stride` bytes.
    ///
    /// # Panics
    /// If the template reaches beyond either.
    pub(crate) fn squares(self, own: &[u8], source: &[u8], stride: usize, shape: [usize; 2], all: &[Stretch]) -> u64 {
        let [height, width] = shape;
        let inside = |s: &Stretch| s.at[0] < height && s.at[1] + s.len <= width && s.own == s.at[0] * width + s.at[1];
        debug_assert!(all.iter().all(inside), "stretches are rows of the template");
        assert!(height * width <= own.len() && width <= stride, "a template has a value a sample");
        assert!((height - 1) * stride + width <= source.len(), "templates lie inside of sources");
        match self.0 {
            Level::Scalar => scalar::squares(own, source, stride, all),
            #[cfg(target_arch = "x86_64")]
            level => x86::squares(level, own, source, stride, all),
        }
    }

    /// `to = weight * from`.
    pub(crate) fn weigh(self, to: &mut [u64], from: &[u32], weight: u32) {
        match self.0 {
            Level::Scalar => scalar::weigh(to, from, weight),
            #[cfg(target_arch = "x86_64")]
            level => x86::weigh(level, to, from, weight),
        }
    }

    /// Adds `weight * from`, modulo 2^64.
    pub(crate) fn add(self, to: &mut [u64], from: &[u32], weight: u32) {
        match self.0 {
            Level::Scalar => scalar::add(to, from, weight),
            #[cfg(target_arch = "x86_64")]
            level => x86::add(level, to, from, weight),
        }
    }

    /// `to = weight * squared differences of cells`, or that added to what is there, for `to.len()` cells side by side.
    ///
    /// # Panics
    /// If a cell would read beyond its words.
    pub(crate) fn cells(self, cells: &Cells<'_>, to: &mut [Lanes]) {
        let (n, taps) = (to.len(), cells.offsets.len());
        let reach = cells.offsets.iter().max().map_or(0, |o| o + SHIFTS);
        assert!(n == 0 || (n - 1) * cells.step + reach <= cells.source.len(), "cells reach beyond the source");
        assert!(n * taps <= cells.words.len(), "cells have words for each tap");
        assert!(cells.masks.is_empty() || n * taps <= cells.masks.len(), "cells have masks for each tap");
        match self.0 {
            Level::Scalar => scalar::cells(cells, to),
            #[cfg(target_arch = "x86_64")]
            level => x86::cells(level, cells, to),
        }
    }

    /// `sums += row - old`, and `old = row`: sums of the last rows, modulo 2^32.
    pub(crate) fn slide(self, sums: &mut [Lanes], row: &[Lanes], old: &mut [Lanes]) {
        match self.0 {
            Level::Scalar => scalar::slide(sums, row, old),
            #[cfg(target_arch = "x86_64")]
            level => x86::slide(level, sums, row, old),
        }
    }

    /// For window `i`, the sum of `cells` columns from `i` on: where it and `marks[step * i..]` together are less than
    /// `best[i]`, they become it, and its code is `code`.
    pub(crate) fn lower(self, windows: &Windows<'_>, code: u32, best: &mut [Lanes], codes: &mut [Lanes]) {
        match self.0 {
            Level::Scalar => scalar::lower(windows, code, best, codes),
            #[cfg(target_arch = "x86_64")]
            level => x86::lower(level, windows, code, best, codes),
        }
    }

    /// For window `i`, adds 1 to `counts[i]` where its sum and marks, and `skip`, are together at most `most`.
    pub(crate) fn count(self, windows: &Windows<'_>, skip: &Lanes, most: u32, counts: &mut [Lanes]) {
        match self.0 {
            Level::Scalar => scalar::count(windows, skip, most, counts),
            #[cfg(target_arch = "x86_64")]
            level => x86::count(level, windows, skip, most, counts),
        }
    }

    /// For window `i` of `n`, `least[step * i..]` becomes its sum and marks where these are less: what is nearest to
    /// each place.
    pub(crate) fn lower_places(self, windows: &Windows<'_>, n: usize, least: &mut [u32]) {
        match self.0 {
            Level::Scalar => scalar::lower_places(windows, n, least),
            #[cfg(target_arch = "x86_64")]
            level => x86::lower_places(level, windows, n, least),
        }
    }

    /// As [`lower`](Self::lower), of sums times `factors[step * i..]`, which are infinite where a window must not
    /// stand.
    pub(crate) fn lower_scaled(
        self,
        windows: &Windows<'_>,
        factors: &[f32],
        code: u32,
        best: &mut [[f32; SHIFTS]],
        codes: &mut [Lanes],
    ) {
        match self.0 {
            Level::Scalar => scalar::lower_scaled(windows, factors, code, best, codes),
            #[cfg(target_arch = "x86_64")]
            level => x86::lower_scaled(level, windows, factors, code, best, codes),
        }
    }
}

/// Cells of one picture, each against [`SHIFTS`] places of another.
#[derive(Clone, Copy)]
pub(crate) struct Cells<'a> {
    /// Pairs of 16-bit values, from the first cell's first place on.
    pub(crate) source: &'a [u32],
    /// Where in it each tap of a cell lies.
    pub(crate) offsets: &'a [usize],
    /// From one cell to the next.
    pub(crate) step: usize,
    /// A word a tap, cell by cell.
    pub(crate) words: &'a [u32],
    /// Which halves of it count; empty if all do.
    pub(crate) masks: &'a [u32],
    pub(crate) weight: u32,
    /// Whether to add to what is there.
    pub(crate) more: bool,
}

/// Windows side by side, each of some columns of cells.
#[derive(Clone, Copy)]
pub(crate) struct Windows<'a> {
    /// Sums of the columns.
    pub(crate) columns: &'a [Lanes],
    /// Columns a window.
    pub(crate) cells: usize,
    /// All ones where a window must not stand.
    pub(crate) marks: &'a [u32],
    /// From one window to the next.
    pub(crate) step: usize,
}

/// The corners of a mask in a table, for one row of positions.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a, W> {
    /// The table, from the row's first position.
    pub(crate) table: &'a [W],
    pub(crate) plus: &'a [usize],
    pub(crate) minus: &'a [usize],
}
