//! Writing PNG.

use png::{
    BitDepth, ColorType, Encoder, EncodingError, Info, PixelDimensions, ScaledFloat, SourceChromaticities, Unit,
};
use selvedge_core::{Plane, Samples};

use super::KEYWORD;
use crate::error::Problem;
use crate::metadata::Metadata;
use crate::{Depth, Format};

/// The whole file. Equal planes and metadata give equal bytes.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let (bytes, bit_depth) = match &plane.samples {
        Samples::U8(grid) => (grid.to_interleaved()?, BitDepth::Eight),
        Samples::U16(grid) => {
            (grid.to_interleaved()?.into_iter().flat_map(u16::to_be_bytes).collect(), BitDepth::Sixteen)
        }
        Samples::F16(_) => return Err(Problem::DepthNotHeld { format: Format::Png, depth: Depth::F16 }),
        Samples::F32(_) => return Err(Problem::DepthNotHeld { format: Format::Png, depth: Depth::F32 }),
    };
    let color_type = match (plane.color_channels(), plane.alpha) {
        (1, false) => ColorType::Grayscale,
        (1, true) => ColorType::GrayscaleAlpha,
        (3, false) => ColorType::Rgb,
        (3, true) => ColorType::Rgba,
        (channels, alpha) => return Err(Problem::ChannelsNotHeld { format: Format::Png, channels, alpha }),
    };
    let [height, width] = plane.domain().shape;
    let mut info = Info::with_size(width, height);
    (info.color_type, info.bit_depth) = (color_type, bit_depth);
    describe(&mut info, plane, metadata);
    let mut file = Vec::new();
    let mut encoder = Encoder::with_info(&mut file, info).map_err(complaint)?;
    if let Some(made) = &metadata.provenance {
        encoder.add_itxt_chunk(KEYWORD.to_owned(), made.to_string()).map_err(complaint)?;
    }
    let mut writer = encoder.write_header().map_err(complaint)?;
    writer.write_image_data(&bytes).map_err(complaint)?;
    writer.finish().map_err(complaint)?;
    Ok(file)
}

fn describe<'a>(info: &mut Info<'a>, plane: &Plane<2>, metadata: &'a Metadata) {
    info.icc_profile = metadata.icc_for(plane.color_channels()).map(Into::into);
    info.srgb = metadata.srgb.and_then(|intent| {
        use png::SrgbRenderingIntent as Intent;
        [Intent::Perceptual, Intent::RelativeColorimetric, Intent::Saturation, Intent::AbsoluteColorimetric]
            .into_iter()
            .find(|known| *known as u8 == intent)
    });
    info.source_gamma = metadata.gamma.map(ScaledFloat::from_scaled);
    info.source_chromaticities = metadata.chromaticities.map(|c| {
        let at = |i: usize| ScaledFloat::from_scaled((c[i] * 100_000.0).round() as u32);
        SourceChromaticities { white: (at(0), at(1)), red: (at(2), at(3)), green: (at(4), at(5)), blue: (at(6), at(7)) }
    });
    info.pixel_dims = metadata.density.map(|d| match d.per_metre() {
        Some((x, y)) => PixelDimensions { xppu: x.round() as u32, yppu: y.round() as u32, unit: Unit::Meter },
        None => PixelDimensions { xppu: d.x.round() as u32, yppu: d.y.round() as u32, unit: Unit::Unspecified },
    });
}

fn complaint(error: EncodingError) -> Problem {
    Problem::encoder(Format::Png, error)
}
