//! WebP: read as it is, written lossless.

use std::io::{self, BufRead, Seek, SeekFrom};

use image::codecs::webp::{WebPDecoder, WebPEncoder};
use image::{ExtendedColorType, ImageDecoder as _, ImageEncoder as _, ImageError};
use selvedge_core::Plane;

use super::{complaint, eight_bits, memory, without_alpha};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::exif;
use crate::metadata::Metadata;
use crate::sink::encoded;
use crate::{Format, Warning};

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let opaque = opaque(input).map_err(|e| Problem::file_system(e, 0))?;
    let mut description = super::describe(&mut open(input, context)?, Format::Webp, context)?;
    // Samples as they are answered, and as four bytes while they are decoded.
    let (bytes, pixels) = (description.header.bytes(), description.header.width * description.header.height);
    description.reading = Some(context.file_bytes.saturating_add(bytes).saturating_add(pixels * 4));
    complete(&mut description, opaque);
    Ok(description)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let opaque = opaque(input).map_err(|e| Problem::file_system(e, 0))?;
    let (mut description, samples) = super::decode(open(input, context)?, Format::Webp, context)?;
    let had_alpha = description.header.alpha;
    complete(&mut description, opaque);
    let lost = had_alpha && !description.header.alpha;
    Ok((description, if lost { without_alpha(samples)? } else { samples }))
}

/// An animation says only whether any of its frames may have alpha.
fn complete(description: &mut Description, opaque: Option<[u64; 2]>) {
    let header = &mut description.header;
    if header.alpha && opaque == Some([header.width, header.height]) {
        (header.channels, header.alpha) = (3, false);
    }
}

/// Width and height of an animation's first frame, if it begins at the corner and has no alpha. Leaves the input at its
/// start.
fn opaque(input: &mut dyn Input) -> io::Result<Option<[u64; 2]>> {
    let (mut chunk, mut at) = ([0; 8], 12);
    let mut frame = [0; 29];
    let found = loop {
        input.seek(SeekFrom::Start(at))?;
        let Ok(()) = input.read_exact(&mut chunk) else { break None };
        let [kind @ .., l0, l1, l2, l3] = chunk;
        if kind == *b"ANMF" {
            break input.read_exact(&mut frame).ok();
        }
        at += 8 + u64::from(u32::from_le_bytes([l0, l1, l2, l3])).next_multiple_of(2);
    };
    input.rewind()?;
    let [x, y, width, height] =
        [0, 3, 6, 9].map(|i| u64::from(u32::from_le_bytes([frame[i], frame[i + 1], frame[i + 2], 0])));
    // A bit of the lossless header, after its sides; alpha of the lossy kind is a chunk of its own.
    let has_none = match &frame[16..20] {
        b"VP8L" => frame[28] & 0x10 == 0,
        kind => kind == b"VP8 ",
    };
    Ok(found.filter(|()| x == 0 && y == 0 && has_none).map(|()| [width + 1, height + 1]))
}

fn open<'a>(input: &'a mut dyn Input, context: &mut Context<'_>) -> Result<WebPDecoder<&'a mut dyn Input>, Problem> {
    if !is_whole(input).map_err(|e| Problem::file_system(e, 0))? {
        return Err(Problem::ends_early(Format::Webp));
    }
    let decoder = WebPDecoder::new(input).map_err(|e| complaint(e, Format::Webp, context))?;
    if decoder.has_animation() {
        context.warn(Warning::FirstFrameOnly);
    }
    Ok(decoder)
}

/// An animation's decoder, and what stands before its frames.
pub(crate) fn animation<R: BufRead + Seek>(
    mut input: R,
    context: &mut Context<'_>,
) -> Result<(WebPDecoder<R>, Description), Problem> {
    if !is_whole(&mut input).map_err(|e| Problem::file_system(e, 0))? {
        return Err(Problem::ends_early(Format::Webp));
    }
    let mut decoder = WebPDecoder::new(input).map_err(|e| complaint(e, Format::Webp, context))?;
    let description = super::describe(&mut decoder, Format::Webp, context)?;
    context.check(&description.header)?;
    context.ask(&description.header)?;
    decoder.set_limits(memory(context.options.limits.memory)).map_err(|e| complaint(e, Format::Webp, context))?;
    Ok((decoder, description))
}

/// How many frames there are, as far as the file goes on as it should.
pub(crate) fn count(file: &[u8]) -> u32 {
    let (mut at, mut count) = (12, 0_u32);
    while let Some([kind @ .., l0, l1, l2, l3]) = file.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        count += u32::from(kind == b"ANMF");
        // Chunks begin at even places.
        at = at.saturating_add(8 + u32::from_le_bytes([*l0, *l1, *l2, *l3]).next_multiple_of(2) as usize);
    }
    count
}

/// Whether every chunk lies within the file. The decoder would take a chunk's claim at its word and ask for that much
/// memory. Leaves the input at its start.
fn is_whole(input: &mut dyn Input) -> io::Result<bool> {
    let len = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    let mut claim = |at: u64| {
        let mut size = [0; 4];
        input.seek(SeekFrom::Start(at + 4))?;
        input.read_exact(&mut size)?;
        io::Result::Ok(u64::from(u32::from_le_bytes(size)))
    };
    let end = claim(0)? + 8;
    // The name of the file's kind stands before the first chunk; odd chunks are padded, though not by everyone.
    let mut at = 12;
    while at + 8 <= end.min(len) {
        let size = claim(at)?;
        if len < at + 8 + size {
            return Ok(false);
        }
        at += 8 + size.next_multiple_of(2);
    }
    input.rewind()?;
    Ok(end <= len + 1)
}

/// The whole file, with profile and EXIF software.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let (bytes, color) = eight_bits(plane, Format::Webp)?;
    let [height, width] = plane.domain().shape;
    encoded(Format::Webp, |file| {
        // The encoder keeps its own pixels, and the file until it is whole.
        file.ask_for(plane.domain().len().saturating_mul(8)).map_err(ImageError::IoError)?;
        let mut encoder = WebPEncoder::new_lossless(file);
        if let Some(icc) = metadata.icc_for(plane.color_channels()) {
            encoder.set_icc_profile(icc.to_vec()).map_err(ImageError::Unsupported)?;
        }
        if let Some(block) = exif::software(metadata) {
            encoder.set_exif_metadata(block).map_err(ImageError::Unsupported)?;
        }
        encoder.write_image(&bytes, width, height, ExtendedColorType::from(color))
    })
}
