//! Rows of chosen channels, block by block, so that no other channel is held in memory.

use crate::Format;
use crate::codec::Input;
use crate::error::{Problem, subject};
use crate::sink::encoded;
use exr::block::reader::{ChunksReader as _, Reader};
use exr::block::writer::ChunksWriter as _;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{Compression, SmallVec};

/// A file whose headers were read.
pub(super) type ExrReader<'a> = Reader<&'a mut dyn Input>;

pub(super) fn open(input: &mut dyn Input) -> Result<ExrReader<'_>, Problem> {
    Reader::read_from_buffered(input, false).map_err(complaint)
}

/// Hands every row of the chosen channels to `sink`: place among the chosen, index of the first sample, bytes in the
/// machine's order.
pub(super) fn read_rows(
    reader: ExrReader<'_>,
    part: usize,
    channels: &[usize],
    mut sink: impl FnMut(usize, usize, &[u8]),
) -> Result<(), Problem> {
    let Vec2(width, height) = reader.headers()[part].layer_size;
    let list = reader.headers()[part].channels.clone();
    let largest = |level: Vec2<usize>| level == Vec2(0, 0);
    let chunks = reader.filter_chunks(true, |_, _, block| block.layer == part && largest(block.level));
    let mut blocks = chunks.map_err(complaint)?.sequential_decompressor(false);
    let mut seen = 0;
    while let Some(block) = blocks.decompress_next_block() {
        let block = block.map_err(complaint)?;
        for line in block.lines(&list) {
            let (Vec2(x, y), count) = (line.location.position, line.location.sample_count);
            if width < x + count || height <= y || block.index.layer != part {
                return Err(Problem::damaged(Format::Exr, "a block lies outside"));
            }
            seen += count;
            for (place, _) in channels.iter().enumerate().filter(|(_, c)| **c == line.location.channel) {
                sink(place, y * width + x, line.value);
            }
        }
    }
    if seen != width * height * list.list.len() {
        return Err(Problem::damaged(Format::Exr, "blocks are missing"));
    }
    Ok(())
}

/// A file of one part, packed without loss. Rows come from `source`: place among the channels, index of the first
/// sample, bytes to fill.
pub(super) fn write_rows(
    [height, width]: [u32; 2],
    channels: &[(&str, SampleType)],
    describe: impl FnOnce(&mut Header),
    source: impl Fn(usize, usize, &mut [u8]),
) -> Result<Vec<u8>, Problem> {
    // The format wants channels in the order of their names.
    let mut order: Vec<usize> = (0..channels.len()).collect();
    order.sort_by_key(|c| channels[*c].0);
    let list = order.iter().map(|c| ChannelDescription::new(channels[*c].0, channels[*c].1, false));
    let width = width as usize;
    let mut header = Header::new(Text::from("selvedge"), (width, height as usize), list.collect()).with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    // A file of one part needs no name.
    header.own_attributes.layer_name = None;
    describe(&mut header);
    let headers: SmallVec<[Header; 3]> = [header].into_iter().collect();
    encoded(Format::Exr, |file| {
        exr::block::write(file, headers, true, |meta, chunks| {
            let mut packed = chunks.sequential_blocks_compressor(&meta);
            for (index, block) in enumerate_ordered_header_block_indices(&meta.headers) {
                let block = UncompressedBlock::from_lines(&meta.headers[0].channels, block, |line| {
                    let Vec2(x, y) = line.location.position;
                    source(order[line.location.channel], y * width + x, line.value);
                });
                packed.compress_block(index, block)?;
            }
            Ok(())
        })
    })
}

/// Text of any bytes.
pub(super) fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

pub(super) fn complaint(error: Error) -> Problem {
    match error {
        Error::NotSupported(what) => Problem::unsupported(Format::Exr, subject(&what)),
        Error::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Problem::ends_early(Format::Exr),
        other => Problem::damaged(Format::Exr, other),
    }
}
