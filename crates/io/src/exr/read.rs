//! Reading EXR: the data window of one part at its full resolution.

use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::prelude::Compression;
use half::f16;
use selvedge_core::Samples;

use super::attributes::{metadata, unread};
use super::blocks::{self, ExrReader};
use super::map::is_map;
use super::select::{self, Selection};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::header::Header;
use crate::samples::zero_grid;
use crate::{Depth, Warning};

/// Everything up to the samples.
pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    Ok(open(input, context)?.2)
}

/// The chosen channels.
pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let (reader, selection, description) = open(input, context)?;
    let samples = samples(reader, &selection, &description.header)?;
    Ok((description, samples))
}

fn open<'a>(
    input: &'a mut dyn Input,
    context: &mut Context<'_>,
) -> Result<(ExrReader<'a>, Selection, Description), Problem> {
    let reader = blocks::open(input)?;
    let parts = reader.headers();
    if is_map(&parts[0]) {
        return Err(Problem::IsAMap);
    }
    let selection = select::select(parts, context.options.channels.as_deref())?;
    let part = &parts[selection.part];
    let (width, height) = (part.layer_size.0 as u64, part.layer_size.1 as u64);
    let kinds: Vec<SampleType> = selection.channels.iter().map(|c| part.channels.list[*c].sample_type).collect();
    let depth = if kinds.iter().all(|k| *k == SampleType::F16) { Depth::F16 } else { Depth::F32 };
    if depth == Depth::F32 && kinds.contains(&SampleType::F16) {
        context.warn(Warning::Widened);
    }
    if context.options.channels.is_none()
        && let Some(what) = select::left_out(parts, &selection)
    {
        context.warn(Warning::ChannelsLeftOut { what });
    }
    let header = Header { width, height, channels: selection.channels.len(), alpha: selection.alpha, depth };
    context.check(&header)?;
    for tag in unread(part) {
        context.warn(Warning::TagUnread { tag });
    }
    let mut metadata = metadata(part);
    if context.options.channels.is_some() || 3 < selection.channels.len() - usize::from(selection.alpha) {
        let name = |c: &usize| part.channels.list[*c].name.to_string();
        metadata.channel_names = selection.channels.iter().map(name).collect();
    }
    // Wavelets and cosines of a block are worked on as floats, several times over.
    let often = if matches!(part.compression, Compression::DWAA(_) | Compression::DWAB(_)) { 6 } else { 4 };
    let block = match part.blocks {
        BlockDescription::Tiles(tiles) => width.min(tiles.tile_size.0 as u64) * height.min(tiles.tile_size.1 as u64),
        BlockDescription::ScanLines => width * height.min(part.compression.scan_lines_per_block() as u64),
    };
    let block = block.saturating_mul(part.channels.bytes_per_pixel as u64).saturating_mul(often);
    let reading = Some(context.file_bytes.saturating_add(header.bytes().max(block)));
    let channel_names = select::names(parts);
    let description = Description { channel_names, reading, ..Description::new(header, metadata) };
    Ok((reader, selection, description))
}

fn samples(reader: ExrReader<'_>, selection: &Selection, header: &Header) -> Result<Samples<2>, Problem> {
    let (part, channels) = (selection.part, &selection.channels[..]);
    let list = &reader.headers()[part].channels.list;
    let half: Vec<bool> = channels.iter().map(|c| list[*c].sample_type == SampleType::F16).collect();
    if header.depth == Depth::F16 {
        let mut grid = zero_grid::<u16>(header)?;
        blocks::read_rows(reader, part, channels, |c, at, bytes| {
            for (to, from) in grid.plane_mut(c)[at..].iter_mut().zip(bytes.as_chunks().0) {
                *to = u16::from_ne_bytes(*from);
            }
        })?;
        return Ok(Samples::F16(grid));
    }
    let mut grid = zero_grid::<f32>(header)?;
    blocks::read_rows(reader, part, channels, |c, at, bytes| {
        let row = grid.plane_mut(c)[at..].iter_mut();
        if half[c] {
            row.zip(bytes.as_chunks().0).for_each(|(to, from)| *to = f16::from_ne_bytes(*from).to_f32());
        } else {
            row.zip(bytes.as_chunks().0).for_each(|(to, from)| *to = f32::from_ne_bytes(*from));
        }
    })?;
    Ok(Samples::F32(grid))
}
