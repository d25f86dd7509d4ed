//! What a picture file says about its samples.

use crate::Format;
use crate::provenance::Provenance;

/// What a file says besides its samples. Carried from input to output where the formats have a place for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// The ICC profile, as stored.
    pub icc: Option<Vec<u8>>,
    /// Code points of primaries, transfer, matrix and range [ITU-T H.273], as PNG's cICP has them.
    pub cicp: Option<[u8; 4]>,
    /// sRGB with this rendering intent, 0..=3.
    pub srgb: Option<u8>,
    /// PNG's gamma: 100,000 times the encoding exponent, so 45,455 for 1/2.2.
    pub gamma: Option<u32>,
    /// CIE x and y of white, red, green and blue.
    pub chromaticities: Option<[f64; 8]>,
    /// How densely samples lie.
    pub density: Option<Density>,
    /// Names of all channels of a picture that is more than colour, or whose channels were chosen, in its order; empty
    /// for others.
    pub channel_names: Vec<String>,
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

/// White, red, green and blue of sRGB and BT.709.
const SRGB: [f64; 8] = [0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06];

/// True for a gamma that is nothing, or what sRGB is said to be near to.
pub(crate) fn is_usual(gamma: u32) -> bool {
    matches!(gamma, 0 | 45_400..=45_500)
}

/// True for code points that say something else than sRGB of full range.
fn says_more([primaries, transfer, _, full]: [u8; 4]) -> bool {
    full == 0 || !(matches!(primaries, 1 | 2) && matches!(transfer, 2 | 13))
}

impl Metadata {
    /// The colour tags that `format` has no place for with so many colours, and that say more than sRGB does.
    pub(crate) fn left_out(&self, format: Format, color_channels: usize) -> Vec<&'static str> {
        let png = format == Format::Png;
        let has_points = matches!(format, Format::Png | Format::Exr | Format::Tiff);
        let profile = self.icc_in(format, color_channels);
        let told = self.srgb.is_some() || profile;
        let points = self.chromaticities_beside(format, color_channels);
        let said = [
            ("cicp tag", !png && self.cicp.is_some_and(says_more)),
            ("colour profile", self.icc.is_some() && !profile),
            ("gamma tag", !png && !told && self.gamma.is_some_and(|g| !is_usual(g))),
            ("chromaticities", !has_points && points.is_some()),
        ];
        said.into_iter().filter(|(_, lost)| *lost).map(|(tag, _)| tag).collect()
    }

    /// Chromaticities that say more than what stands beside them in a file of this format: whoever has a profile, or
    /// says that it is sRGB, says the rest for those who know no better.
    pub(crate) fn chromaticities_beside(&self, format: Format, color_channels: usize) -> Option<[f64; 8]> {
        let told = self.srgb.is_some() || self.icc_in(format, color_channels);
        let is_srgb = |c: &[f64; 8]| c.iter().zip(SRGB).all(|(a, b)| (a - b).abs() < 1e-3);
        self.chromaticities.filter(|c| !told && !is_srgb(c))
    }

    /// Whether a file of this format holds the profile.
    fn icc_in(&self, format: Format, color_channels: usize) -> bool {
        let holds = matches!(format, Format::Png | Format::Jpeg | Format::Tiff | Format::Webp);
        holds && self.icc_for(color_channels).is_some()
    }

    /// The profile if it is one for this number of channels: readers reject a grey profile over colour.
    pub(crate) fn icc_for(&self, color_channels: usize) -> Option<&[u8]> {
        let icc = self.icc.as_deref()?;
        let space: &[u8] = if color_channels == 1 { b"GRAY" } else { b"RGB " };
        (icc.get(16..20) == Some(space)).then_some(icc)
    }
}
