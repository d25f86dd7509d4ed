//! Reading PNG.

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Reader, Transformations, Unit};
use selvedge_core::{Samples, try_vec};

use crate::error::Problem;
use crate::header::Header;
use crate::metadata::{Density, DensityUnit, Metadata};
use crate::read::{Context, Decoded, Input, METADATA_BYTES};
use crate::samples::deinterleave;
use crate::{Depth, Format, Warning};

type PngReader<'a> = Reader<&'a mut dyn Input>;

/// The picture; of an animation its default picture.
pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let mut reader = open(input, context)?;
    let header = header_of(&reader);
    context.check(&header)?;
    if reader.info().is_animated() {
        context.warn(Warning::FirstFrameOnly);
    }
    let len = reader.output_buffer_size().ok_or_else(|| Problem::damaged(Format::Png, "impossible size"))?;
    let mut bytes = try_vec(len, 0_u8)?;
    reader.next_frame(&mut bytes).map_err(complaint)?;
    reader.finish().map_err(complaint)?;
    let samples = match header.depth {
        Depth::U8 => Samples::U8(deinterleave(&header, &bytes, |b: [u8; 1]| b[0])?),
        _ => Samples::U16(deinterleave(&header, &bytes, u16::from_be_bytes)?),
    };
    Ok(Decoded { samples, alpha: header.alpha, metadata: metadata(&reader) })
}

/// Everything up to the samples. The claimed size is checked before the rows' buffers are made.
fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<PngReader<'a>, Problem> {
    let mut decoder = Decoder::new_with_limits(input, Limits { bytes: METADATA_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(complaint)?;
    let depth = if info.bit_depth == BitDepth::Sixteen { Depth::U16 } else { Depth::U8 };
    let channels = if info.color_type == ColorType::Indexed { 3 } else { info.color_type.samples() };
    let (width, height) = (info.width.into(), info.height.into());
    context.check(&Header { width, height, channels, alpha: false, depth })?;
    decoder.read_info().map_err(complaint)
}

fn header_of(reader: &PngReader<'_>) -> Header {
    let (color, bits) = reader.output_color_type();
    Header {
        width: reader.info().width.into(),
        height: reader.info().height.into(),
        channels: color.samples(),
        alpha: matches!(color, ColorType::GrayscaleAlpha | ColorType::Rgba),
        depth: if bits == BitDepth::Sixteen { Depth::U16 } else { Depth::U8 },
    }
}

fn metadata(reader: &PngReader<'_>) -> Metadata {
    let info = reader.info();
    let density = info.pixel_dims.map(|d| Density {
        x: d.xppu.into(),
        y: d.yppu.into(),
        unit: if d.unit == Unit::Meter { DensityUnit::Metre } else { DensityUnit::Aspect },
    });
    let chromaticities = info.chrm_chunk.map(|c| {
        [c.white, c.red, c.green, c.blue].map(|(x, y)| [x, y].map(|v| f64::from(v.into_scaled()) / 100_000.0))
    });
    Metadata {
        icc: info.icc_profile.as_ref().map(|icc| icc.to_vec()),
        srgb: info.srgb.map(|intent| intent as u8),
        gamma: info.gama_chunk.map(png::ScaledFloat::into_scaled),
        chromaticities: chromaticities.map(|c| c.concat().try_into().expect("four times two")),
        density,
    }
}

fn complaint(error: DecodingError) -> Problem {
    match error {
        DecodingError::LimitsExceeded => Problem::unsupported(Format::Png, "metadata over 16 MiB"),
        DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Problem::damaged(Format::Png, "it ends early")
        }
        other => Problem::damaged(Format::Png, other),
    }
}
