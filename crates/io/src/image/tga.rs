//! Truevision TGA: palettes, grey and RGB of 8 bits with or without alpha, straight.
//!
//! How a picture was made stands in the developer's area, which others pass over: after the samples, found from the
//! footer by way of a directory of tags.

use std::io::{SeekFrom, Write as _};

use image::codecs::tga::{TgaDecoder, TgaEncoder};
use selvedge_core::Plane;

use super::{complaint, eight_bits};
use crate::Format;
use crate::codec::{Context, Decoded, Description, Input, METADATA_BYTES};
use crate::error::Problem;
use crate::metadata::Metadata;
use crate::provenance::Provenance;
use crate::sink::encoded;

/// Ends a file that has areas after its samples.
const SIGNATURE: &[u8; 18] = b"TRUEVISION-XFILE.\0";
/// Bytes of a footer: where the extension and the developer's directory begin, and the signature.
const FOOTER: usize = 4 + 4 + SIGNATURE.len();
/// Our tag in the directory, one of those for anybody.
const MADE: u16 = 0x5e1f;

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let made = made(input)?;
    let mut description = super::describe(&mut open(input, context)?, Format::Tga, context)?;
    description.metadata.provenance = made;
    Ok(description)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let made = made(input)?;
    let (mut description, samples) = super::decode(open(input, context)?, Format::Tga, context)?;
    description.metadata.provenance = made;
    Ok((description, samples))
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<TgaDecoder<&'a mut dyn Input>, Problem> {
    TgaDecoder::new(input).map_err(|e| complaint(e, Format::Tga, context))
}

/// How the picture was made; `None` where nothing sound says so. Leaves the input at its start.
fn made(input: &mut dyn Input) -> Result<Option<Provenance>, Problem> {
    let found = tagged(input).unwrap_or_default();
    input.rewind().map_err(|e| Problem::file_system(e, 0))?;
    Ok(std::str::from_utf8(&found).ok().and_then(Provenance::parse))
}

/// The bytes of our tag.
fn tagged(input: &mut dyn Input) -> std::io::Result<Vec<u8>> {
    let end = input.seek(SeekFrom::End(0))?;
    let mut read = |at: u64, n: usize| {
        let mut bytes = vec![0; n];
        input.seek(SeekFrom::Start(at))?;
        input.read_exact(&mut bytes).map(|()| bytes)
    };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |n, &b| n << 8 | u64::from(b));
    let footer = read(end.saturating_sub(FOOTER as u64), FOOTER)?;
    let directory = number(&footer[4..8]);
    if !footer.ends_with(SIGNATURE) || directory == 0 {
        return Ok(Vec::new());
    }
    let count = number(&read(directory, 2)?) as usize;
    let tags = read(directory + 2, count * 10)?;
    let Some(tag) = tags.chunks_exact(10).find(|tag| number(&tag[..2]) == u64::from(MADE)) else {
        return Ok(Vec::new());
    };
    let (at, len) = (number(&tag[2..6]), number(&tag[6..]) as usize);
    if end < at + len as u64 || METADATA_BYTES < len { Ok(Vec::new()) } else { read(at, len) }
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
