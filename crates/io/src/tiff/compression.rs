//! Compression: ZSTD is unpacked before the decoder sees the file, since it could do so only with a library in C, and
//! LZW, since it wants an end that some writers leave out. What nobody here can unpack is named.

use std::io::Read;

use super::directory::{Directory, TILES};
use crate::Format;
use crate::codec::Context;
use crate::error::Problem;
use crate::header::{Header, afford};

const COMPRESSION: u16 = 259;
const NONE: u16 = 1;
const LZW: u64 = 5;
const ZSTD: u64 = 50_000;

const ROWS_PER_STRIP: u16 = 278;
const TILE_SIZE: [u16; 2] = [323, 322];
/// Where the pieces are and how long, of strips; of tiles see [`TILES`].
const STRIPS: [u16; 2] = [273, 279];

/// Appends at most so many bytes of what is packed.
type Unpack = fn(&[u8], u64, &mut Vec<u8>, &Context<'_>) -> Result<(), Problem>;

/// How often the unpacked file is held where a method is unpacked here: ZSTD looks back at all of a piece.
pub(super) fn times_held(method: u16) -> u64 {
    match method.into() {
        LZW => 1,
        ZSTD => 2,
        _ => 0,
    }
}

/// Refuses what cannot be unpacked; the file with its pieces unpacked if they are ZSTD's or LZW's.
///
/// `stored` is what the file holds, its `bits` those of a sample.
pub(super) fn unpacked(
    file: &[u8],
    stored: &Header,
    samples: usize,
    bits: usize,
    context: &Context<'_>,
) -> Result<Option<Vec<u8>>, Problem> {
    let directory = Directory::of(file)?;
    let method = directory.first(file, COMPRESSION).unwrap_or(1);
    let named = match method {
        ZSTD => return unpack(file, directory, stored, samples * bits, (of_zstd, context)).map(Some),
        LZW => return unpack(file, directory, stored, samples * bits, (of_lzw, context)).map(Some),
        1 | 3 | 4 | 8 | 32_773 | 32_946 => return Ok(None),
        2 => "compression by huffman codes".to_owned(),
        6 | 7 => "compression by jpeg".to_owned(),
        34_712 => "compression by jpeg 2000".to_owned(),
        34_887 => "compression by lerc".to_owned(),
        34_925 => "compression by lzma".to_owned(),
        50_001 => "compression by webp".to_owned(),
        50_002 => "compression by jpeg xl".to_owned(),
        other => format!("compression by method {other}"),
    };
    Err(Problem::unsupported(Format::Tiff, named))
}

fn unpack(
    file: &[u8],
    directory: Directory,
    stored: &Header,
    bits: usize,
    (unpack, context): (Unpack, &Context<'_>),
) -> Result<Vec<u8>, Problem> {
    let damaged = |cause: &str| Problem::damaged(Format::Tiff, cause);
    let number = |tag| directory.first(file, tag);
    let tiled = number(TILES[0]).is_some();
    let tags = if tiled { TILES } else { STRIPS };
    let [at, len] = tags.map(|tag| directory.numbers(file, tag));
    let (Some(at), Some(len)) = (at, len) else { return Err(damaged("it has no strips or tiles")) };
    let sides = if tiled {
        TILE_SIZE.map(number)
    } else {
        [Some(number(ROWS_PER_STRIP).unwrap_or(stored.height).min(stored.height)), Some(stored.width)]
    };
    let [Some(height), Some(width)] = sides else { return Err(damaged("it has no size of tiles")) };
    // Pieces of one plane are smaller.
    let most = width.saturating_mul(bits as u64).div_ceil(8).saturating_mul(height);
    let most = most.min(context.options.limits.memory);
    let mut out = Vec::new();
    append(&mut out, file)?;
    let (mut places, mut lengths) = (Vec::new(), Vec::new());
    for (at, len) in at.into_iter().zip(len) {
        let piece = usize::try_from(at).ok().zip(usize::try_from(at.saturating_add(len)).ok());
        let piece = piece.and_then(|(from, to)| file.get(from..to)).ok_or_else(|| Problem::ends_early(Format::Tiff))?;
        places.push(out.len() as u64);
        let start = out.len();
        unpack(piece, most, &mut out, context)?;
        lengths.push((out.len() - start) as u64);
    }
    let all = directory.set(&mut out, COMPRESSION, NONE);
    let all = all.and_then(|()| directory.set_all(&mut out, tags[0], &places));
    let all = all.and_then(|()| directory.set_all(&mut out, tags[1], &lengths));
    all.ok_or_else(|| damaged("its directory"))?;
    Ok(out)
}

/// A piece without an end is as whole as one that has it: the codes before it are all samples.
fn of_lzw(piece: &[u8], most: u64, out: &mut Vec<u8>, context: &Context<'_>) -> Result<(), Problem> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
    let (mut rest, mut left) = (piece, most);
    let mut part = [0; 1 << 14];
    while 0 < left {
        let room = part.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        let done = decoder.decode_bytes(rest, &mut part[..room]);
        let status = done.status.map_err(|e| Problem::damaged(Format::Tiff, e))?;
        admit(out, done.consumed_out, context)?;
        append(out, &part[..done.consumed_out])?;
        rest = &rest[done.consumed_in..];
        left -= done.consumed_out as u64;
        if matches!(status, weezl::LzwStatus::Done) || done.consumed_in + done.consumed_out == 0 {
            break;
        }
    }
    Ok(())
}

fn of_zstd(piece: &[u8], most: u64, out: &mut Vec<u8>, context: &Context<'_>) -> Result<(), Problem> {
    let wrong = |e: &dyn std::fmt::Display| Problem::damaged(Format::Tiff, e);
    let decoder = ruzstd::decoding::StreamingDecoder::new(piece).map_err(|e| wrong(&e))?;
    let mut decoder = decoder.take(most);
    let mut part = [0; 1 << 16];
    loop {
        let n = decoder.read(&mut part).map_err(|e| wrong(&e))?;
        if n == 0 {
            return Ok(());
        }
        admit(out, n, context)?;
        append(out, &part[..n])?;
    }
}

/// Refuses what is more than there may be.
fn admit(out: &[u8], more: usize, context: &Context<'_>) -> Result<(), Problem> {
    afford(&context.options.limits, (out.len() + more) as u64)
}

fn append(out: &mut Vec<u8>, bytes: &[u8]) -> Result<(), Problem> {
    let refused = |_| selvedge_core::Error::Allocation { bytes: bytes.len() as u64 };
    out.try_reserve(bytes.len()).map_err(refused)?;
    out.extend_from_slice(bytes);
    Ok(())
}
