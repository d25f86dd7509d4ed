//! What a synthesised texture is worth beside its exemplar: [`Columns`] with units, each of a documented formula, and
//! one number, [`preference`], which follows how people ranked outputs side by side.
//!
//! A [`Judge`] prepares exemplars once and is asked about many outputs. Everything is deterministic: the same on any
//! number of threads and with any instructions. 512^2 px from 192^2 take some 0.3 s on one thread. All windows are
//! compared up to 1024^2 px from 256^2; of larger pictures, whose pairs of windows grow with the fourth power of their
//! sides, keyed tiles are.
//!
//! The columns say *why*; the preference decides between candidates of one exemplar and one size. It is not a mark that
//! could be compared between exemplars.
//!
//! ```
//! use selvedge_core::{Exemplars, Grid, Domain, Plane, Role, SimdLevel};
//! use selvedge_metrics::{Judge, preference};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of four samples; more of it, and as many light and dark samples in rows.
//! let board = |[y, x]: [u32; 2]| if (y / 4 + x / 4) % 2 == 0 { 200 } else { 40 };
//! let rows = |[y, _]: [u32; 2]| if y % 2 == 0 { 200 } else { 40 };
//! let bytes: Vec<u8> = Domain::open([40, 40]).positions().map(board).collect();
//! let judge = Judge::new(&Exemplars::of(&[&[Plane::of_bytes(Role::Color, [40, 40], 1, &bytes)?]])?, SimdLevel::Auto)?;
//! let output = Domain::open([64, 64]);
//! let good = judge.columns(&Grid::from_vec(output, 1, output.positions().map(board).collect())?, None)?;
//! let bad = judge.columns(&Grid::from_vec(output, 1, output.positions().map(rows).collect())?, None)?;
//! assert!(preference(&good) > preference(&bad));
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! `rayon` (default): windows are compared on the caller's pool; the result is the same without it.
#![forbid(unsafe_code)]

mod columns;
mod error;
mod fit;
mod lattice;
mod marginals;
mod preference;
mod scaled;
mod seams;
mod windows;

pub use columns::{Columns, Seams};
pub use error::Error;
pub use fit::{Fit, fit};
pub use preference::{MAPPED, Model, PICTURE, TERMS, preference, terms};

use lattice::Kept;
use seams::Prices;
use selvedge_core::{Exemplars, Grid, SimdLevel, SourceMap};
use selvedge_fft_ssd::Windows;
use windows::Level;

/// Sides of windows at half and at a quarter of the size, and of large ones there: 16, 32 and 64 px of the output, from
/// a detail to how details are arranged.
const WINDOW: u32 = 8;
const LARGE: u32 = 16;
/// Least side of exemplars and outputs that can be compared, in samples.
pub const LEAST: u32 = 4 * WINDOW;

/// Exemplars, prepared to be compared with outputs.
pub struct Judge {
    full: Level,
    half: Level,
    quarter: Level,
    prices: Prices,
    lattice: Vec<Kept>,
    variances: Vec<f64>,
    sharpness: f64,
    shade: Option<f64>,
    simd: SimdLevel,
}

impl Judge {
    /// Prepares exemplars: takes about as long as a search at each position of them.
    ///
    /// # Errors
    /// [`Error::TooSmall`] for an exemplar of less than 32 samples a side, [`Error::Core`] and [`Error::Search`] if
    /// memory is short.
    pub fn new(exemplars: &Exemplars<2>, simd: SimdLevel) -> Result<Self, Error> {
        exemplars.sources().iter().try_for_each(|s| large_enough(s.domain().shape))?;
        let half = scaled::halved_exemplars(exemplars)?;
        let quarter = scaled::halved_exemplars(&half)?;
        let first = exemplars.firsts().next().map(|s| marginals::shade(&s.features, SHADE)).transpose()?.flatten();
        Ok(Self {
            prices: Prices::new(exemplars)?,
            lattice: lattice::lattice(exemplars)?,
            variances: marginals::variances(&marginals::pictures(&half), WINDOW as usize),
            sharpness: marginals::sharpness(&marginals::pictures(exemplars)),
            shade: first,
            full: Level::new(exemplars.clone()),
            half: Level::new(half),
            quarter: Level::new(quarter),
            simd,
        })
    }

    /// The columns of an output, in features of the exemplars' encoder; those of seams where there is a map.
    ///
    /// # Errors
    /// [`Error::Channels`], [`Error::Map`], [`Error::TooSmall`] if they do not fit each other; [`Error::Core`] and
    /// [`Error::Search`] if memory is short.
    pub fn columns(&self, output: &Grid<u8, 2>, map: Option<&SourceMap<2>>) -> Result<Columns, Error> {
        self.check(output, map)?;
        let simd = self.simd;
        let half = scaled::halved(output)?;
        let quarter = scaled::halved(&half)?;
        // Steps of half a window: finer ones find the same means, and take longer.
        let windows = Windows { side: WINDOW, step: WINDOW / 2 };
        let fine = Windows { side: WINDOW, step: WINDOW / 4 };
        let near_2 = self.half.coherent(&half, windows, simd)?;
        let large = Windows { side: LARGE, step: LARGE / 4 };
        let far = self.quarter.coherent(&quarter, large, simd)?;
        let drawn = self.full.sampled(output, WINDOW, simd)?;
        let pictures = [(output, None)];
        let log = |a: f64, b: f64| libm::log2((a + 0.05) / (b + 0.05));
        let shade = marginals::shade(output, SHADE)?.zip(self.shade);
        let exemplar: usize = self.full.exemplars.firsts().map(|s| s.domain().len()).sum();
        Ok(Columns {
            coherence: drawn.mean(),
            coherence_2: near_2.mean(),
            coherence_4: self.quarter.coherent(&quarter, fine, simd)?.mean(),
            arrangement: far.mean(),
            worst: near_2.worst(),
            completeness_2: self.half.complete(&half, windows, simd)?,
            completeness_4: self.quarter.complete(&quarter, fine, simd)?,
            unevenness: near_2.unevenness(WINDOW),
            repeats: far.repeats(WINDOW),
            lattice: lattice::lost(&self.lattice, output, self.full.exemplars.weights()),
            bland: marginals::below_tenth(&marginals::variances(&[(&half, None)], WINDOW as usize), &self.variances),
            sharpness: log(marginals::sharpness(&pictures), self.sharpness),
            colour: marginals::colour(&pictures, &marginals::pictures(&self.full.exemplars)) / self.full.contrast,
            shade: shade.map_or(0.0, |(a, b)| log(a, b)),
            wrap: drawn.torn(),
            scale: libm::log2(output.domain().len() as f64 / exemplar as f64) / 2.0,
            seams: map.map(|m| self.prices.of(m)).transpose()?,
        })
    }

    fn check(&self, output: &Grid<u8, 2>, map: Option<&SourceMap<2>>) -> Result<(), Error> {
        let (expected, found) = (self.full.exemplars.channels(), output.channels());
        if expected != found {
            return Err(Error::Channels { expected, found });
        }
        let shape = output.domain().shape;
        large_enough(shape)?;
        let Some(map) = map else { return Ok(()) };
        if map.domain().shape != shape {
            return Err(Error::Map { expected: shape.to_vec(), found: map.domain().shape.to_vec() });
        }
        let (expected, found) = (self.full.exemplars.table().len(), map.table.len());
        if expected != found {
            return Err(Error::Map { expected: vec![expected], found: vec![found] });
        }
        Ok(())
    }
}

/// Share of an output's windows of 32 px, half of that apart, whose contrast (standard deviation over all channels) is
/// under a quarter of that of the exemplars' flattest: what became one blur. 0 where either holds no window.
///
/// No column, and no part of the preference: between outputs of which none is washed out it says nothing.
///
/// # Errors
/// [`Error::Channels`].
///
/// # Complexity
/// `O(samples)`.
pub fn washed_out(exemplars: &Exemplars<2>, output: &Grid<u8, 2>) -> Result<f64, Error> {
    let (expected, found) = (exemplars.channels(), output.channels());
    if expected != found {
        return Err(Error::Channels { expected, found });
    }
    let variances = |pictures: &[marginals::Valid<'_>]| marginals::variances(pictures, LEAST as usize);
    let (own, made) = (variances(&marginals::pictures(exemplars)), variances(&[(output, None)]));
    let Some(least) = own.into_iter().min_by(f64::total_cmp) else { return Ok(0.0) };
    let flat = made.iter().filter(|&&variance| variance * 16.0 < least).count();
    Ok(flat as f64 / made.len().max(1) as f64)
}

/// Halvings until a sample is the mean of 32 px: what differs over fewer belongs to bodies, not to light. A guess.
const SHADE: usize = 5;

fn large_enough(shape: [u32; 2]) -> Result<(), Error> {
    if shape.iter().any(|&n| n < LEAST) { Err(Error::TooSmall { shape: shape.to_vec() }) } else { Ok(()) }
}
