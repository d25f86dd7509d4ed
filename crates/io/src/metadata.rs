//! What a picture file says about its samples.

use crate::Depth;
use crate::provenance::Provenance;

/// What a file says besides its samples. Carried from input to output where the formats have a place for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// The ICC profile, as stored.
    pub icc: Option<Vec<u8>>,
    /// sRGB with this rendering intent, 0..=3.
    pub srgb: Option<u8>,
    /// PNG's gamma: 100,000 times the encoding exponent, so 45,455 for 1/2.2.
    pub gamma: Option<u32>,
    /// CIE x and y of white, red, green and blue.
    pub chromaticities: Option<[f64; 8]>,
    /// How densely samples lie.
    pub density: Option<Density>,
    /// How the picture was made.
    pub provenance: Option<Provenance>,
}

/// How densely samples lie, or the shape of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// Samples a unit along x.
    pub x: f64,
    /// Samples a unit along y.
    pub y: f64,
    /// The unit.
    pub unit: DensityUnit,
}

/// The unit of a [`Density`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityUnit {
    /// No unit: only the ratio of x and y means something.
    Aspect,
    /// Samples a metre.
    Metre,
    /// Samples a centimetre.
    Centimetre,
    /// Samples an inch.
    Inch,
}

impl Density {
    /// The same density in samples a metre; `None` if it has no unit.
    pub fn per_metre(self) -> Option<(f64, f64)> {
        let factor = match self.unit {
            DensityUnit::Aspect => return None,
            DensityUnit::Metre => 1.0,
            DensityUnit::Centimetre => 100.0,
            DensityUnit::Inch => 1.0 / 0.0254,
        };
        Some((self.x * factor, self.y * factor))
    }
}

impl Metadata {
    /// What still holds when samples change their depth: integers are encoded and floats are linear light, so a
    /// profile, sRGB or a gamma for the one says nothing of the other.
    #[must_use]
    pub fn converted(&self, from: Depth, to: Depth) -> Self {
        let float = |depth| matches!(depth, Depth::F16 | Depth::F32);
        let mut metadata = self.clone();
        if float(from) != float(to) {
            (metadata.icc, metadata.srgb, metadata.gamma) = (None, None, None);
        }
        metadata
    }

    /// The profile if it is one for this number of channels: readers reject a grey profile over colour.
    pub(crate) fn icc_for(&self, color_channels: usize) -> Option<&[u8]> {
        let icc = self.icc.as_deref()?;
        let space: &[u8] = if color_channels == 1 { b"GRAY" } else { b"RGB " };
        (icc.get(16..20) == Some(space)).then_some(icc)
    }
}
