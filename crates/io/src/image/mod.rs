//! Formats that the `image` crate decodes: all but PNG, JPEG, TIFF and EXR, of which we need more than it
//! offers.

pub(crate) mod bmp;
pub(crate) mod gif;
pub(crate) mod hdr;
pub(crate) mod tga;
pub(crate) mod webp;

use image::error::LimitErrorKind;
use image::{ColorType, ImageDecoder, ImageError, Limits};
use selvedge_core::{Bytes, Grid, Plane, Samples};

use crate::codec::{Context, Decoded, Description, METADATA_BYTES};
use crate::error::{Problem, subject};
use crate::exif::Exif;
use crate::header::Header;
use crate::metadata::Metadata;
use crate::samples::{from_native, zeros};
use crate::{Depth, Format, Warning};

/// What a decoder says before it decodes.
fn describe(
    decoder: &mut impl ImageDecoder,
    format: Format,
    context: &mut Context<'_>,
) -> Result<Description, Problem> {
    let (width, height) = decoder.dimensions();
    let (channels, alpha, depth) = layout(decoder.color_type(), format)?;
    let header = Header { width: width.into(), height: height.into(), channels, alpha, depth };
    let stored = decoder.icc_profile().unwrap_or(Some(Vec::new()));
    let has_profile = stored.is_some();
    let icc = stored.filter(|icc| (1..=METADATA_BYTES).contains(&icc.len()));
    if has_profile && icc.is_none() {
        context.warn(Warning::ProfileLeftOut);
    }
    let mut metadata = Metadata { icc, ..Metadata::default() };
    let exif = decoder.exif_metadata().ok().flatten().map(|block| Exif::parse(&block)).unwrap_or_default();
    let orientation = exif.orientation.unwrap_or(1);
    exif.complete(&mut metadata);
    Ok(Description { orientation, ..Description::new(header, metadata) })
}

/// Checks the size, then decodes.
fn decode(mut decoder: impl ImageDecoder, format: Format, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let description = describe(&mut decoder, format, context)?;
    let header = description.header;
    context.check(&header)?;
    decoder.set_limits(memory(context.options.limits.memory)).map_err(|e| complaint(e, format, context))?;
    context.ask(&header)?;
    let mut bytes = zeros(header.bytes() as usize)?;
    decoder.read_image(&mut bytes).map_err(|e| complaint(e, format, context))?;
    let samples = from_native(&header, &bytes)?;
    Ok((description, samples))
}

/// The colours alone.
fn without_alpha(samples: Samples<2>) -> Result<Samples<2>, Problem> {
    let Samples::U8(grid) = &samples else { return Ok(samples) };
    let colors = grid.channels() - 1;
    let mut alone = Grid::try_filled(grid.domain(), colors, 0_u8)?;
    (0..colors).for_each(|c| alone.plane_mut(c).copy_from_slice(grid.plane(c)));
    Ok(Samples::U8(alone))
}

/// Limits of nothing but memory.
fn memory(bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(bytes);
    limits
}

fn layout(color: ColorType, format: Format) -> Result<(usize, bool, Depth), Problem> {
    Ok(match color {
        ColorType::L8 => (1, false, Depth::U8),
        ColorType::La8 => (2, true, Depth::U8),
        ColorType::Rgb8 => (3, false, Depth::U8),
        ColorType::Rgba8 => (4, true, Depth::U8),
        ColorType::Rgb32F => (3, false, Depth::F32),
        other => return Err(Problem::unsupported(format, format!("{other:?}"))),
    })
}

pub(crate) fn complaint(error: ImageError, format: Format, context: &Context<'_>) -> Problem {
    match error {
        ImageError::Limits(e) if matches!(e.kind(), LimitErrorKind::InsufficientMemory) => {
            let budget = context.options.limits.memory;
            Problem::Memory { needed: Bytes(budget.saturating_add(1)), budget: Bytes(budget) }
        }
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Problem::ends_early(format),
        ImageError::Unsupported(e) => Problem::unsupported(format, subject(&e.to_string())),
        // Its own words name the format again.
        ImageError::Decoding(e) => match std::error::Error::source(&e) {
            Some(cause) => Problem::damaged(format, cause),
            None => Problem::damaged(format, e),
        },
        other => Problem::damaged(format, other),
    }
}

/// Interleaved bytes of a plane of one or three channels, with alpha where the format has it.
pub(crate) fn eight_bits(plane: &Plane<2>, format: Format) -> Result<(Vec<u8>, ColorType), Problem> {
    let Samples::U8(grid) = &plane.samples else {
        return Err(Problem::DepthNotHeld { format, depth: plane.samples.depth() });
    };
    let color = match (plane.color_channels(), plane.alpha) {
        (1, false) => ColorType::L8,
        (3, false) => ColorType::Rgb8,
        (1, true) if format.holds_alpha() => ColorType::La8,
        (3, true) if format.holds_alpha() => ColorType::Rgba8,
        (channels, alpha) => return Err(Problem::ChannelsNotHeld { format, channels, alpha }),
    };
    Ok((grid.to_interleaved()?, color))
}
