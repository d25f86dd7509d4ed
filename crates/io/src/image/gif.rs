//! GIF, read: the first frame.

use std::io::{BufRead, Cursor, Read as _, Seek};

use image::codecs::gif::GifDecoder;
use image::{AnimationDecoder as _, ImageDecoder as _};
use selvedge_core::Samples;

use super::{complaint, memory, without_alpha};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::header::Header;
use crate::samples::from_native;
use crate::{Format, Warning};

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let wrong = |e| Problem::file_system(e, 0);
    let mut head = Vec::new();
    (&mut *input).take(HEAD).read_to_end(&mut head).map_err(wrong)?;
    input.rewind().map_err(wrong)?;
    let mut description = super::describe(&mut open(input, context)?, Format::Gif, context)?;
    let Header { width, height, .. } = description.header;
    // The canvas, the frame on it, what is answered, and that by channel: four bytes a sample each.
    description.reading = Some(context.file_bytes.saturating_add(width * height * 16));
    if frames(&head).first().is_some_and(|first| !first.transparent && first.sides == [width, height]) {
        (description.header.channels, description.header.alpha) = (3, false);
    }
    Ok(description)
}

/// The first frame begins within so many bytes, but after comments without end.
const HEAD: u64 = 1 << 20;

pub(crate) fn decode(file: &[u8], context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let (decoder, mut description) = animation(Cursor::new(file), file, context)?;
    let mut frames = decoder.into_frames();
    let first = frames.next().ok_or_else(|| Problem::damaged(Format::Gif, "it has no frame"))?;
    let first = first.map_err(|e| complaint(e, Format::Gif, context))?.into_buffer();
    if frames.next().is_some() {
        context.warn(Warning::FirstFrameOnly);
    }
    let samples = opaque(from_native(&description.header, first.as_raw())?, &mut description.header)?;
    Ok((description, samples))
}

/// An animation's decoder, which may hold what the file can, and what stands before its frames.
pub(crate) fn animation<R: BufRead + Seek>(
    input: R,
    file: &[u8],
    context: &mut Context<'_>,
) -> Result<(GifDecoder<R>, Description), Problem> {
    let mut sizes = frames(file).into_iter().map(|frame| frame.sides[0] * frame.sides[1]);
    let first = sizes.next().unwrap_or(0);
    if MOST.saturating_mul(file.len() as u64) < first {
        return Err(Problem::ends_early(Format::Gif));
    }
    let mut decoder = GifDecoder::new(input).map_err(|e| complaint(e, Format::Gif, context))?;
    let description = super::describe(&mut decoder, Format::Gif, context)?;
    context.check(&description.header)?;
    context.ask(&description.header)?;
    // Later frames are made as large as they claim to be, too.
    let Header { width, height, .. } = description.header;
    if sizes.any(|frame| first.max(width * height) < frame) {
        return Err(Problem::damaged(Format::Gif, "a frame is larger than the picture"));
    }
    decoder.set_limits(memory(context.options.limits.memory)).map_err(|e| complaint(e, Format::Gif, context))?;
    Ok((decoder, description))
}

/// Samples that a byte can stand for: a code of 12 bits stands for a row of the table, the longest of which has as many
/// samples as the table has rows. The decoder makes the whole frame before it reads the first one.
const MOST: u64 = 4096 * 8 / 12;

/// What stands before the samples of a frame.
struct Frame {
    /// Width and height.
    sides: [u64; 2],
    /// Whether it has a colour that does not show.
    transparent: bool,
}

/// Each frame, as far as the file goes on as it should.
fn frames(file: &[u8]) -> Vec<Frame> {
    let mut found = Vec::new();
    walk(file, &mut found);
    found
}

/// How many frames there are, as far as the file goes on as it should.
pub(crate) fn count(file: &[u8]) -> u32 {
    u32::try_from(frames(file).len()).unwrap_or(u32::MAX)
}

/// `None` where the file ends or is another one.
fn walk(file: &[u8], found: &mut Vec<Frame>) -> Option<()> {
    let table = |packed: u8| if packed & 0x80 == 0 { 0 } else { 3 << ((packed & 7) + 1) };
    // Blocks that say how long they are, up to an empty one.
    let after_blocks = |mut at: usize| {
        while let Some(len) = file.get(at).filter(|len| **len != 0) {
            at += 1 + usize::from(*len);
        }
        at + 1
    };
    let mut at = 13 + table(*file.get(10)?);
    let mut transparent = false;
    loop {
        match *file.get(at)? {
            // An extension: two bytes, then blocks. That of the next frame says whether it has a transparent colour.
            0x21 => {
                transparent |= file.get(at + 1) == Some(&0xf9) && file.get(at + 3).is_some_and(|flags| flags & 1 == 1);
                at = after_blocks(at + 2);
            }
            0x2c => {
                let side = |at: usize| Some(u64::from(u16::from_le_bytes(*file.get(at..)?.first_chunk()?)));
                found.push(Frame { sides: [side(at + 5)?, side(at + 7)?], transparent });
                transparent = false;
                // Its own table, and the size of its codes.
                at = after_blocks(at + 10 + table(*file.get(at + 9)?) + 1);
            }
            _ => return None,
        }
    }
}

/// The decoder always gives alpha; without a transparent sample it means nothing.
fn opaque(samples: Samples<2>, header: &mut Header) -> Result<Samples<2>, Problem> {
    let Samples::U8(grid) = &samples else { return Ok(samples) };
    if header.channels != 4 || grid.plane(3).iter().any(|a| *a != 255) {
        return Ok(samples);
    }
    (header.channels, header.alpha) = (3, false);
    without_alpha(samples)
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<GifDecoder<&'a mut dyn Input>, Problem> {
    GifDecoder::new(input).map_err(|e| complaint(e, Format::Gif, context))
}
