//! Reading PNG.

use std::io::{self, SeekFrom};

use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Reader, Transformations, Unit};
use selvedge_core::Samples;

use super::{KEYWORD, palette};
use crate::codec::{Context, Decoded, Description, Input, METADATA_BYTES};
use crate::error::Problem;
use crate::exif::Exif;
use crate::header::Header;
use crate::metadata::{Density, DensityUnit, Metadata};
use crate::provenance::Provenance;
use crate::samples::{deinterleave, zeros};
use crate::{Depth, Format, Warning};

type PngReader<'a> = Reader<&'a mut dyn Input>;

/// Everything up to the samples.
pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let profile = has_profile(input).map_err(|e| Problem::file_system(e, 0))?;
    let reader = open(input, context)?;
    Ok(description(reader.info(), profile, context))
}

/// The picture; of an animation its default picture.
pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let profile = has_profile(input).map_err(|e| Problem::file_system(e, 0))?;
    let mut reader = open(input, context)?;
    let description = description(reader.info(), profile, context);
    let header = description.header;
    context.check(&header)?;
    let len = reader.output_buffer_size().ok_or_else(|| Problem::damaged(Format::Png, "impossible size"))?;
    let mut bytes = zeros(len)?;
    reader.next_frame(&mut bytes).map_err(complaint)?;
    reader.finish().map_err(complaint)?;
    let samples = match (reader.info().color_type, header.depth) {
        (ColorType::Indexed, _) => palette::expand(reader.info(), &header, &bytes, context)?,
        (_, Depth::U8) => Samples::U8(deinterleave(&header, &bytes, |b: [u8; 1]| b[0])?),
        _ => Samples::U16(deinterleave(&header, &bytes, u16::from_be_bytes)?),
    };
    Ok((description, samples))
}

/// The claimed size is checked before the rows' buffers are made.
fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<PngReader<'a>, Problem> {
    let mut decoder = Decoder::new_with_limits(input, Limits { bytes: METADATA_BYTES });
    let info = decoder.read_header_info().map_err(complaint)?;
    context.check(&header(info))?;
    let indexed = info.color_type == ColorType::Indexed;
    decoder.set_transformations(if indexed { Transformations::IDENTITY } else { Transformations::EXPAND });
    decoder.read_info().map_err(complaint)
}

/// What the samples will be once they are expanded.
pub(crate) fn header(info: &Info<'_>) -> Header {
    let stored_alpha = matches!(info.color_type, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let keyed = info.trns.is_some() && !stored_alpha;
    let colors = match info.color_type {
        ColorType::Grayscale | ColorType::GrayscaleAlpha => 1,
        _ => 3,
    };
    let alpha = stored_alpha || keyed;
    Header {
        width: info.width.into(),
        height: info.height.into(),
        channels: colors + usize::from(alpha),
        alpha,
        depth: if info.bit_depth == BitDepth::Sixteen { Depth::U16 } else { Depth::U8 },
    }
}

/// Whether there is a profile before the samples; the decoder passes over one that it cannot unpack and says nothing.
/// Leaves the input at its start.
fn has_profile(input: &mut dyn Input) -> io::Result<bool> {
    let mut head = [0; 8];
    let mut at = 8;
    let found = loop {
        input.seek(SeekFrom::Start(at))?;
        match input.read_exact(&mut head) {
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break false,
            read => read?,
        }
        let [l3, l2, l1, l0, kind @ ..] = head;
        match &kind {
            b"iCCP" => break true,
            b"IDAT" => break false,
            // Length, kind and checksum stand around the data.
            _ => at += u64::from(u32::from_be_bytes([l3, l2, l1, l0])) + 12,
        }
    };
    input.rewind()?;
    Ok(found)
}

fn description(info: &Info<'_>, profile: bool, context: &mut Context<'_>) -> Description {
    if profile && info.icc_profile.is_none() {
        context.warn(Warning::ProfileLeftOut);
    }
    if info.is_animated() {
        context.warn(Warning::FirstFrameOnly);
    } else if info.animation_control.is_some() {
        context.warn(Warning::DefaultPictureOnly);
    }
    let mastered = info.mastering_display_color_volume.is_some();
    for (said, tag) in [(mastered, "mastering display"), (info.content_light_level.is_some(), "content light level")] {
        if said {
            context.warn(Warning::TagUnread { tag });
        }
    }
    let exif = info.exif_metadata.as_deref().map(Exif::parse).unwrap_or_default();
    let orientation = exif.orientation.unwrap_or(1);
    let mut metadata = metadata(info);
    exif.complete(&mut metadata);
    Description { orientation, ..Description::new(header(info), metadata) }
}

pub(crate) fn metadata(info: &Info<'_>) -> Metadata {
    let density = info.pixel_dims.map(|d| Density {
        x: d.xppu.into(),
        y: d.yppu.into(),
        unit: if d.unit == Unit::Meter { DensityUnit::Metre } else { DensityUnit::Aspect },
    });
    let chromaticities = info.chrm_chunk.map(|c| {
        [c.white, c.red, c.green, c.blue].map(|(x, y)| [x, y].map(|v| f64::from(v.into_scaled()) / 100_000.0))
    });
    let ours = info.utf8_text.iter().find(|chunk| chunk.keyword == KEYWORD && !chunk.compressed);
    Metadata {
        icc: info.icc_profile.as_ref().map(|icc| icc.to_vec()),
        cicp: info.coding_independent_code_points.map(|c| {
            [c.color_primaries, c.transfer_function, c.matrix_coefficients, u8::from(c.is_video_full_range_image)]
        }),
        srgb: info.srgb.map(|intent| intent as u8),
        gamma: info.gama_chunk.map(png::ScaledFloat::into_scaled),
        chromaticities: chromaticities.map(|c| c.concat().try_into().expect("four times two")),
        density,
        provenance: ours.and_then(|chunk| Provenance::parse(&chunk.get_text().ok()?)),
        ..Metadata::default()
    }
}

pub(crate) fn complaint(error: DecodingError) -> Problem {
    match error {
        DecodingError::LimitsExceeded => Problem::unsupported(Format::Png, "metadata over 16 MiB"),
        DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Problem::ends_early(Format::Png),
        other => Problem::damaged(Format::Png, other),
    }
}
