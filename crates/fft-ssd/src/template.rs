//! What is searched for.

use crate::Error;
use crate::axes::{Shape, lift};
use selvedge_core::Grid;

/// A box of 8-bit features with an optional mask: what is searched for.
///
/// Features are planar (channel by channel, each row-major) and come from the same encoder as the exemplars'. Where the
/// mask is false, the features are not looked at.
///
/// A patch of what is searched is cut out of its features ([`Grid::cropped`]); one of another picture goes through the
/// encoder that was fitted to what is searched:
///
/// ```
/// use selvedge_core::{Encoder, Exemplar, Exemplars, Plane, Role};
/// use selvedge_fft_ssd::Template;
///
/// let searched = [Plane::of_bytes(Role::Scalar, [2, 3], 1, &[1, 2, 3, 4, 5, 6])?];
/// let encoder = Encoder::fit(&[&searched])?;
/// let exemplars = Exemplars::new(&encoder, &[Exemplar::new(&searched)])?;
/// let another = [Plane::of_bytes(Role::Scalar, [1, 2], 1, &[5, 6])?];
/// let features = encoder.encode(&another)?;
/// assert_eq!(Template::of(&features).shape(), [1, 2]);
/// # assert_eq!(exemplars.channels(), 1);
/// # Ok::<(), selvedge_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Template<'a, const D: usize> {
    pub(crate) shape: [u32; D],
    pub(crate) features: &'a [u8],
    pub(crate) mask: Option<&'a [bool]>,
}

impl<'a, const D: usize> Template<'a, D> {
    /// A template in buffers of the caller; their lengths are checked when it is searched.
    pub fn new(shape: [u32; D], features: &'a [u8]) -> Self {
        Self { shape, features, mask: None }
    }

    /// A whole grid.
    pub fn of(features: &'a Grid<u8, D>) -> Self {
        Self::new(features.domain().shape, features.samples())
    }

    /// The same features, compared only where the mask (row-major, one value a sample) is true.
    ///
    /// A mask without a true value is not refused: such a template fits everywhere, with an error and a number of
    /// samples of 0, as a first patch does on an empty canvas.
    #[must_use]
    pub fn masked(mut self, mask: &'a [bool]) -> Self {
        self.mask = Some(mask);
        self
    }

    /// Sides, slowest axis first.
    pub fn shape(&self) -> [u32; D] {
        self.shape
    }

    /// Planar features.
    pub fn features(&self) -> &'a [u8] {
        self.features
    }

    /// Where it is compared; `None` for everywhere.
    pub fn mask(&self) -> Option<&'a [bool]> {
        self.mask
    }

    /// Samples in the box, or the error that makes the template unusable for that many channels.
    pub(crate) fn check(&self, channels: usize) -> Result<Checked<'a>, Error> {
        if self.shape.contains(&0) {
            return Err(Error::EmptyTemplate { shape: self.shape.to_vec() });
        }
        let len = self.shape.iter().fold(1_u64, |n, &s| n.saturating_mul(u64::from(s)));
        let expected = len.saturating_mul(channels as u64);
        if self.features.len() as u64 != expected {
            let (shape, found) = (self.shape.to_vec(), self.features.len() as u64);
            return Err(Error::TemplateLength { shape, channels, expected, found });
        }
        if let Some(mask) = self.mask.filter(|m| m.len() as u64 != len) {
            return Err(Error::MaskLength { expected: len, found: mask.len() as u64 });
        }
        let samples = self.mask.map_or(len, |m| m.iter().filter(|&&on| on).count() as u64);
        let mask = self.mask.filter(|_| samples < len);
        Ok(Checked { shape: lift(self.shape.map(|s| s as usize), 1), features: self.features, mask, samples })
    }
}

/// A template whose lengths are right, over three axes.
#[derive(Clone, Copy)]
pub(crate) struct Checked<'a> {
    pub(crate) shape: Shape,
    pub(crate) features: &'a [u8],
    /// `None` if every sample counts.
    pub(crate) mask: Option<&'a [bool]>,
    /// Samples that count.
    pub(crate) samples: u64,
}

impl Checked<'_> {
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    pub(crate) fn counts(&self, index: usize) -> bool {
        self.mask.is_none_or(|m| m[index])
    }
}
