//! Truevision TGA: palettes, grey and RGB of 8 bits with or without alpha.
//!
//! How a picture was made stands in the developer's area, which others pass over: after the samples, found from the
//! footer by way of a directory of tags.

mod areas;

use std::io::{Read as _, Write as _};

use image::codecs::tga::{TgaDecoder, TgaEncoder};
use selvedge_core::Plane;

use self::areas::{Areas, MADE, SIGNATURE};
use super::{complaint, eight_bits, without_alpha};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::exif::encoding;
use crate::metadata::Metadata;
use crate::sink::encoded;
use crate::{Association, Format, Warning};

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let said = Said::of(input)?;
    let mut description = super::describe(&mut open(input, context)?, Format::Tga, context)?;
    said.complete(&mut description, context);
    Ok(description)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let said = Said::of(input)?;
    let (mut description, samples) = super::decode(open(input, context)?, Format::Tga, context)?;
    let had_alpha = description.header.alpha;
    said.complete(&mut description, context);
    let lost = had_alpha && !description.header.alpha;
    Ok((description, if lost { without_alpha(samples)? } else { samples }))
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<TgaDecoder<&'a mut dyn Input>, Problem> {
    TgaDecoder::new(input).map_err(|e| complaint(e, Format::Tga, context))
}

/// What a file says beside what the decoder answers.
struct Said {
    areas: Areas,
    /// Whether each sample has a bit of alpha beside five a colour, which the decoder leaves out.
    bit: bool,
}

impl Said {
    /// Leaves the input at its start.
    fn of(input: &mut dyn Input) -> Result<Self, Problem> {
        let wrong = |e| Problem::file_system(e, 0);
        let areas = Areas::of(input)?;
        let mut head = Vec::new();
        (&mut *input).take(HEADER as u64).read_to_end(&mut head).map_err(wrong)?;
        input.rewind().map_err(wrong)?;
        // Of a palette's entry, or of a sample; the lowest bits of the last byte count those of alpha.
        let bits = |head: &[u8]| if head[2] % 8 == 1 { head[7] } else { head[16] };
        let bit = head.len() == HEADER && bits(&head) == 16 && head[17] & 15 == 1;
        Ok(Self { areas, bit })
    }

    fn complete(self, description: &mut Description, context: &mut Context<'_>) {
        let Areas { made, alpha, gamma } = self.areas;
        description.metadata.provenance = made;
        description.metadata.gamma = gamma.and_then(encoding);
        let header = &mut description.header;
        let is_alpha = alpha.is_none_or(|kind| 2 < kind);
        match (header.alpha, is_alpha) {
            (true, true) if alpha == Some(4) => description.association = Some(Association::Premultiplied),
            (true, false) => {
                (header.channels, header.alpha) = (header.channels - 1, false);
                let what = "its last channel is left out: the file says that it is no alpha".to_owned();
                context.warn(Warning::ChannelsLeftOut { what });
            }
            (false, true) if self.bit => {
                let what = "the bit of alpha of its 16-bit samples is left out: it is all opaque".to_owned();
                context.warn(Warning::ChannelsLeftOut { what });
            }
            _ => {}
        }
    }
}

/// Bytes before the samples, and where among them the height stands.
const HEADER: usize = 18;
const HEIGHT: std::ops::Range<usize> = 14..16;

/// The whole file, its runs packed row by row: no packet goes on in the next row [TGA 2.0], as the encoder's would.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let (bytes, color) = eight_bits(plane, Format::Tga)?;
    let [height, width] = plane.domain().shape;
    encoded(Format::Tga, |file| {
        let height = u16::try_from(height).map_err(|e| e.to_string())?;
        let mut packed = Vec::new();
        for (y, row) in bytes.chunks_exact(bytes.len() / usize::from(height)).enumerate() {
            packed.clear();
            TgaEncoder::new(&mut packed).encode(row, width, 1, color.into()).map_err(|e| e.to_string())?;
            packed[HEIGHT].copy_from_slice(&height.to_le_bytes());
            file.write_all(&packed[if y == 0 { 0 } else { HEADER }..]).map_err(|e| e.to_string())?;
        }
        append(file, metadata).map_err(|e| e.to_string())
    })
}

fn append(file: &mut crate::sink::Sink, metadata: &Metadata) -> std::io::Result<()> {
    let Some(made) = &metadata.provenance else { return Ok(()) };
    let (made, at) = (made.to_string(), file.bytes().len() as u32);
    let len = made.len() as u32;
    file.write_all(made.as_bytes())?;
    file.write_all(&1_u16.to_le_bytes())?;
    file.write_all(&MADE.to_le_bytes())?;
    file.write_all(&[at.to_le_bytes(), len.to_le_bytes()].concat())?;
    // No extension; the directory follows the tag.
    file.write_all(&[[0; 4], (at + len).to_le_bytes()].concat())?;
    file.write_all(SIGNATURE)
}
