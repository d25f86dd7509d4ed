//! Exact nearest neighborhoods between two pictures: which window of the exemplars is most like each window of another
//! picture?
//!
//! Windows that overlap share their work by displacement: at each shift of one picture against the other every pixel
//! pair is compared once, its squared difference goes into a cell of `step` by `step` pixels, and a window is a square
//! of cells. So the time does not depend on the windows' side, and does on the step only by the number of windows. No
//! tree and no propagation is exact, and none is faster at the sizes of textures.

mod comparison;
mod coverage;
mod field;
mod one_by_one;
mod scale;
mod walk;

use crate::kernel::Kernel;
use crate::{Error, memory};
use comparison::Comparison;
pub use coverage::Coverage;
use selvedge_core::{Domain, Exemplars, Grid, SimdLevel, Source};

/// A picture whose windows are compared: 8-bit features, and which samples count.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Features, one channel after the other. Windows reach around periodic axes.
    pub features: &'a Grid<u8, 2>,
    /// Samples that count; `None` for all.
    pub valid: Option<&'a Grid<bool, 2>>,
}

impl<'a> Field<'a> {
    /// A picture all of whose samples count.
    pub fn new(features: &'a Grid<u8, 2>) -> Self {
        Self { features, valid: None }
    }

    /// A source of exemplars.
    pub fn of(source: &'a Source<2>) -> Self {
        Self { features: &source.features, valid: source.valid.as_deref() }
    }

    /// All sources of exemplars, in their order.
    pub fn all(exemplars: &'a Exemplars<2>) -> Vec<Self> {
        exemplars.sources().iter().map(|source| Self::of(source)).collect()
    }
}

/// Which windows are asked for: squares whose first samples lie at multiples of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Windows {
    /// Side of a window in samples, at least 1.
    pub side: u32,
    /// Samples from one window to the next along each axis, at least 1. A divisor of the side is fast, any other is
    /// answered window by window.
    pub step: u32,
}

impl Windows {
    /// Where windows of a picture stand, in units of the step: those inside, and along a periodic axis also those
    /// around its border.
    pub fn over(self, domain: Domain<2>) -> Domain<2> {
        let count = |axis: usize| match (domain.shape[axis], domain.periodic[axis]) {
            (n, _) if n < self.side => 0,
            (n, true) => n.div_ceil(self.step),
            (n, false) => (n - self.side) / self.step + 1,
        };
        Domain { shape: [count(0), count(1)], periodic: domain.periodic }
    }
}

/// The window most like another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbor {
    /// Its source, from 0.
    pub source: u32,
    /// Its first sample there, slowest axis first.
    pub position: [u32; 2],
    /// `sum of W_c (a - b)^2` over samples and channels, in squared 8-bit steps times the weights; not a mean.
    pub error: u64,
}

/// For each window of a picture the most similar window of some sources, at any position; the lowest source, row and
/// column of equal ones. The answer lies over [`Windows::over`] the picture; `None` where no window of any source is
/// valid throughout.
///
/// Samples of `picture` that do not count are not compared: so a window that knows a part of itself is found by that
/// part, and one that knows nothing is like the first that is valid.
///
/// Takes `O(samples of the picture * samples of the sources * channels)` whatever the side, in the caller's pool; the
/// same answer for any instructions and threads. Needs about 130 bytes for each window of 16 rows of them, and 4 to 8
/// bytes for each sample.
///
/// # Errors
/// [`Error::Count`] if weights and channels differ, [`Error::EmptyTemplate`] for a side or step of 0,
/// [`Error::MaskShape`] for a mask of another shape than its picture, [`Error::Core`] if memory is short.
pub fn nearest(
    picture: Field<'_>,
    sources: &[Field<'_>],
    weights: &[u8],
    windows: Windows,
    simd: SimdLevel,
) -> Result<Grid<Option<Neighbor>, 2>, Error> {
    let over = check(picture, sources, weights, windows)?;
    let mut found = Grid::try_filled(over, 1, None)?;
    for (number, &source) in sources.iter().enumerate() {
        let comparison = Comparison { picture, source, weights, windows };
        let best = if comparison.is_by_displacement() {
            walk::nearest(comparison, Kernel::new(simd))?
        } else {
            one_by_one::nearest(comparison, simd)?
        };
        for (found, best) in found.plane_mut(0).iter_mut().zip(best) {
            let is_better = |&(error, _): &(u64, [u32; 2])| found.is_none_or(|f: Neighbor| error < f.error);
            if let Some((error, position)) = best.filter(is_better) {
                *found = Some(Neighbor { source: number as u32, position, error });
            }
        }
    }
    Ok(found)
}

/// For each window of a picture, at how many other positions of the picture a window differs from it by at most `error`
/// (as [`Neighbor::error`]). Windows less than `apart` samples away along both axes do not count, nor do those with
/// samples that are not valid.
///
/// Takes what [`nearest`] takes.
///
/// # Errors
/// Those of [`nearest`].
pub fn alike(
    picture: Field<'_>,
    weights: &[u8],
    windows: Windows,
    error: u64,
    apart: u32,
    simd: SimdLevel,
) -> Result<Grid<u32, 2>, Error> {
    let over = check(picture, &[picture], weights, windows)?;
    let comparison = Comparison { picture, source: picture, weights, windows };
    let counts = if comparison.is_by_displacement() {
        walk::alike(comparison, error, apart, Kernel::new(simd))?
    } else {
        one_by_one::alike(comparison, error, apart, simd)?
    };
    Ok(Grid::from_vec(over, 1, counts)?)
}

/// How many windows there are along each axis, if the pictures can be compared.
fn check(picture: Field<'_>, sources: &[Field<'_>], weights: &[u8], windows: Windows) -> Result<Domain<2>, Error> {
    if windows.side == 0 || windows.step == 0 {
        return Err(Error::EmptyTemplate { shape: vec![windows.side, windows.step] });
    }
    for field in std::iter::once(&picture).chain(sources) {
        let (expected, found) = (weights.len(), field.features.channels());
        if expected != found {
            return Err(Error::Count { what: "channels", expected, found });
        }
        let shape = field.features.domain().shape;
        if let Some(mask) = field.valid.filter(|m| m.domain().shape != shape) {
            let found = mask.domain().shape.to_vec();
            return Err(Error::MaskShape { expected: shape.to_vec(), found });
        }
    }
    Ok(windows.over(picture.features.domain()))
}

/// Error and position of the most similar window of one source.
type Best = Option<(u64, [u32; 2])>;

/// Joins the answers of bands of windows.
fn joined<T>(bands: Vec<Result<Vec<T>, Error>>, len: usize) -> Result<Vec<T>, Error> {
    let mut all = Vec::new();
    memory::reserve(&mut all, len)?;
    for band in bands {
        all.extend(band?);
    }
    Ok(all)
}
