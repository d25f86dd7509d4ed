//! Writing JPEG.

use image::codecs::jpeg::{JpegEncoder, PixelDensity, PixelDensityUnit};
use image::{ExtendedColorType, ImageEncoder as _, ImageError};
use selvedge_core::Plane;

use crate::Format;
use crate::error::Problem;
use crate::exif;
use crate::image::eight_bits;
use crate::metadata::{Density, DensityUnit, Metadata};
use crate::sink::encoded;

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
