//! JPEG, 8 bits.

use std::io::SeekFrom;

use image::codecs::jpeg::{JpegDecoder, JpegEncoder, PixelDensity, PixelDensityUnit};
use image::{ExtendedColorType, ImageEncoder as _, ImageError};
use selvedge_core::Plane;

use super::{complaint, eight_bits};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::exif;
use crate::metadata::{Density, DensityUnit, Metadata};
use crate::sink::encoded;
use crate::{Format, Warning};

/// Everything up to the samples.
pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let markers = Markers::scan(input)?;
    let mut decoder = JpegDecoder::new(input).map_err(|e| complaint(e, Format::Jpeg, context))?;
    let mut description = super::describe(&mut decoder, Format::Jpeg, context)?;
    markers.complete(&mut description, context);
    Ok(description)
}

/// The picture. The decoder would fill what is missing at the end with grey; we refuse it.
pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let markers = Markers::scan(input)?;
    let decoder = JpegDecoder::new(input).map_err(|e| complaint(e, Format::Jpeg, context))?;
    let (mut description, samples) = super::decode(decoder, Format::Jpeg, context)?;
    if !markers.ended {
        return Err(Problem::ends_early(Format::Jpeg));
    }
    markers.complete(&mut description, context);
    Ok((description, samples))
}

/// The whole file, with profile, density and EXIF software.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata, quality: u8) -> Result<Vec<u8>, Problem> {
    let (bytes, color) = eight_bits(plane, Format::Jpeg)?;
    let [height, width] = plane.domain().shape;
    encoded(Format::Jpeg, |file| {
        let mut encoder = JpegEncoder::new_with_quality(file, quality);
        if let Some(density) = metadata.density {
            encoder.set_pixel_density(pixel_density(density));
        }
        if let Some(icc) = metadata.icc_for(plane.color_channels()) {
            encoder.set_icc_profile(icc.to_vec()).map_err(ImageError::Unsupported)?;
        }
        if let Some(block) = exif::software(metadata) {
            encoder.set_exif_metadata(block).map_err(ImageError::Unsupported)?;
        }
        encoder.write_image(&bytes, width, height, ExtendedColorType::from(color))
    })
}

/// JFIF has whole numbers of samples an inch or a centimetre.
fn pixel_density(density: Density) -> PixelDensity {
    let (factor, unit) = match density.unit {
        DensityUnit::Aspect => (1.0, PixelDensityUnit::PixelAspectRatio),
        DensityUnit::Inch => (1.0, PixelDensityUnit::Inches),
        DensityUnit::Centimetre => (1.0, PixelDensityUnit::Centimeters),
        DensityUnit::Metre => (0.0254, PixelDensityUnit::Inches),
    };
    let whole = |v: f64| ((v * factor).round() as u16).max(1);
    PixelDensity { density: (whole(density.x), whole(density.y)), unit }
}

/// What the markers say that the decoder does not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Markers {
    density: Option<Density>,
    /// Four components: CMYK or YCCK.
    cmyk: bool,
    /// Whether the end marker was found.
    ended: bool,
}

impl Markers {
    /// Walks over the segments and leaves the input at its start.
    fn scan(input: &mut dyn Input) -> Result<Self, Problem> {
        let wrong = |e| Problem::file_system(e, 0);
        let mut bytes = Vec::new();
        input.read_to_end(&mut bytes).map_err(wrong)?;
        input.seek(SeekFrom::Start(0)).map_err(wrong)?;
        let mut markers = Self::default();
        let _ = markers.walk(&bytes);
        Ok(markers)
    }

    /// `None` where the file ends.
    fn walk(&mut self, bytes: &[u8]) -> Option<()> {
        let mut at = 2;
        loop {
            // Between segments, and after entropy-coded data, everything up to the next marker is passed over.
            at += bytes.get(at..)?.iter().position(|b| *b == 0xff)?;
            let marker = *bytes.get(at + 1)?;
            match marker {
                0xff => at += 1,
                0xd9 => {
                    self.ended = true;
                    return Some(());
                }
                0x00 | 0x01 | 0xd0..=0xd8 => at += 2,
                _ => {
                    let len = u16::from_be_bytes(*bytes.get(at + 2..)?.first_chunk()?);
                    let segment = bytes.get(at + 4..at + 2 + usize::from(len.max(2)))?;
                    self.segment(marker, segment);
                    at += 2 + usize::from(len.max(2));
                }
            }
        }
    }

    fn segment(&mut self, marker: u8, segment: &[u8]) {
        match (marker, segment) {
            (0xe0, [b'J', b'F', b'I', b'F', 0, _, _, unit, x1, x0, y1, y0, ..]) => {
                let unit = match unit {
                    1 => DensityUnit::Inch,
                    2 => DensityUnit::Centimetre,
                    _ => DensityUnit::Aspect,
                };
                let [x, y] = [[*x1, *x0], [*y1, *y0]].map(|b| f64::from(u16::from_be_bytes(b)));
                self.density = (0.0 < x && 0.0 < y).then_some(Density { x, y, unit });
            }
            // All frame headers; c4, c8 and cc among them mean something else.
            (0xc0..=0xcf, [_, _, _, _, _, components, ..]) if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => {
                self.cmyk = *components == 4;
            }
            _ => {}
        }
    }

    fn complete(self, description: &mut Description, context: &mut Context<'_>) {
        description.metadata.density = self.density.or(description.metadata.density);
        if self.cmyk {
            context.warn(Warning::CmykConverted);
            // The profile is one for CMYK.
            description.metadata.icc = None;
        }
    }
}
