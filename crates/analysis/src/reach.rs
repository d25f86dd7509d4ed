//! How far a texture is moved over itself, and what that search holds.

use selvedge_core::{Bytes, Domain};
use selvedge_fft_ssd::{Error, Holdings, Options, Sizes, held_in_box};

/// Of a texture at most so many samples around the centre are looked at: time and memory grow with them. A guess
/// at what people wait for.
pub(crate) const SAMPLES: usize = 1 << 20;
/// So many for their structures: some five looks at them take no longer than one at [`SAMPLES`].
pub(crate) const CLOSELY: usize = 1 << 18;
/// So many for what is larger than any middle: there what is small has been averaged away, and a coarse look does.
pub(crate) const ROUGHLY: usize = 1 << 16;

/// The shape of a middle of at most so many samples: the longest side is halved until it has them.
pub(crate) fn shape_of_middle<const D: usize>(mut shape: [u32; D], most: usize) -> [u32; D] {
    while (most as u64) < Bytes::of_samples(Domain::open(shape), 1).0 {
        let longest = (0..D).max_by_key(|&a| shape[a]).unwrap_or(0);
        shape[longest] = shape[longest].div_ceil(2);
    }
    shape
}

/// How far a grid is moved over itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach<const D: usize> {
    /// The most along each axis, to both sides.
    pub(crate) most: [u32; D],
    /// One in so many samples must overlap: few resemble each other by chance.
    pub(crate) one_in: usize,
}

impl<const D: usize> Reach<D> {
    /// Half of all sides.
    pub(crate) fn half(domain: Domain<D>) -> Self {
        Self { most: domain.shape.map(|n| n / 2), one_in: 8 }
    }

    /// The first translation, and how many along each axis: one of each pair of opposite ones.
    pub(crate) fn positions(&self) -> ([i32; D], [u32; D]) {
        let (mut first, mut count) = (self.most.map(|r| -(r as i32)), self.most.map(|r| 2 * r + 1));
        (first[0], count[0]) = (0, self.most[0] + 1);
        (first, count)
    }
}

/// Options for a search of its own, in which no position is asked for twice: no more spectra are kept than one
/// transform has. Of heavy weights parts are tried one after the other, each with spectra of its own, and all of those
/// took eight times as much.
pub(crate) fn asked_once<const D: usize>(
    domain: Domain<D>,
    weights: &[u8],
    masked: bool,
    reach: Reach<D>,
) -> Result<Options, Error> {
    let usual = Options::default();
    let Holdings { tables, spectra, .. } = sizes_held(domain, weights, (masked, masked), reach, &usual)?;
    Ok(Options { cache: (tables + spectra).0.min(usual.cache), ..usual })
}

/// What such a search holds, with holes or not, of any shape or not.
pub(crate) fn sizes_held<const D: usize>(
    domain: Domain<D>,
    weights: &[u8],
    (holes, noisy_masks): (bool, bool),
    reach: Reach<D>,
    options: &Options,
) -> Result<Holdings, Error> {
    let sizes =
        Sizes { sources: &[domain], weights, holes, template: domain.shape, samples: domain.len() as u64, noisy_masks };
    let (first, count) = reach.positions();
    held_in_box(&sizes, first, count, options)
}
