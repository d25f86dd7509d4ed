//! Writing PNG.

use png::chunk::{IDAT, cICP};
use png::{BitDepth, ColorType, Encoder, EncodingError, Info};
use png::{PixelDimensions, ScaledFloat, SourceChromaticities, Unit};
use selvedge_core::{Grid, Plane, Samples};

use super::KEYWORD;
use super::pack::Rows;
use crate::Format;
use crate::error::Problem;
use crate::metadata::Metadata;
use crate::sink::encoded;

/// The whole file. Equal planes and metadata give equal bytes.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    match &plane.samples {
        Samples::U8(grid) => with_depth(grid, |v| [v], plane, metadata),
        Samples::U16(grid) => with_depth(grid, u16::to_be_bytes, plane, metadata),
        floats => Err(Problem::DepthNotHeld { format: Format::Png, depth: floats.depth() }),
    }
}

fn with_depth<T: Copy + Sync, const N: usize>(
    grid: &Grid<T, 2>,
    bytes: impl Fn(T) -> [u8; N] + Sync,
    plane: &Plane<2>,
    metadata: &Metadata,
) -> Result<Vec<u8>, Problem> {
    let info = info_of(plane, metadata)?;
    let [height, width] = plane.domain().shape;
    let pixel = grid.channels() * N;
    let read = |y: usize, row: &mut [u8]| interleave(grid, y, &bytes, row);
    let rows = Rows { count: height as usize, bytes: width as usize * pixel, pixel, read };
    encoded(Format::Png, |file| {
        file.ask_for(rows.room())?;
        let mut encoder = Encoder::with_info(file, info)?;
        if let Some(made) = &metadata.provenance {
            encoder.add_itxt_chunk(KEYWORD.to_owned(), made.to_string())?;
        }
        let mut writer = encoder.write_header()?;
        if let Some(points) = metadata.cicp {
            writer.write_chunk(cICP, &points)?;
        }
        rows.pack::<EncodingError>(|part| writer.write_chunk(IDAT, part))?;
        writer.finish()
    })
}

/// What stands before the samples of an 8-bit or 16-bit plane.
pub(crate) fn info_of<'a>(plane: &Plane<2>, metadata: &'a Metadata) -> Result<Info<'a>, Problem> {
    let color_type = match (plane.color_channels(), plane.alpha) {
        (1, false) => ColorType::Grayscale,
        (1, true) => ColorType::GrayscaleAlpha,
        (3, false) => ColorType::Rgb,
        (3, true) => ColorType::Rgba,
        (channels, alpha) => return Err(Problem::ChannelsNotHeld { format: Format::Png, channels, alpha }),
    };
    let [height, width] = plane.domain().shape;
    let mut info = Info::with_size(width, height);
    let bit_depth = if matches!(plane.samples, Samples::U8(_)) { BitDepth::Eight } else { BitDepth::Sixteen };
    (info.color_type, info.bit_depth) = (color_type, bit_depth);
    describe(&mut info, plane, metadata);
    Ok(info)
}

/// One row of all channels.
fn interleave<T: Copy, const N: usize>(grid: &Grid<T, 2>, y: usize, bytes: impl Fn(T) -> [u8; N], row: &mut [u8]) {
    let width = grid.domain().shape[1] as usize;
    let (samples, _) = row.as_chunks_mut::<N>();
    for c in 0..grid.channels() {
        let from = &grid.plane(c)[y * width..][..width];
        samples[c..].iter_mut().step_by(grid.channels()).zip(from).for_each(|(to, v)| *to = bytes(*v));
    }
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
