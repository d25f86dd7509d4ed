//! The channels and attributes of source maps.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header as Part;
use selvedge_core::{Domain, Grid, SampleId, SourceMap, SourceTable};

use super::blocks::{open, read_rows, text, write_rows};
use super::{attributes, write};
use crate::codec::{Context, METADATA_BYTES};
use crate::error::Problem;
use crate::header::Header;
use crate::metadata::Metadata;
use crate::samples::zero_grid;
use crate::{Depth, Format};

const CHANNELS: [&str; 3] = ["source", "x", "y"];
const SOURCES: &str = "selvedge.sources";
const UNASSIGNED: u32 = u32::MAX;

/// The file of a map whose sources are listed in `sources`.
pub(crate) fn encode_map(map: &SourceMap<2>, sources: &str, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let domain = map.domain();
    if domain.is_empty() {
        let [height, width] = domain.shape.map(u64::from);
        return Err(Problem::NoSamples { width, height });
    }
    let describe = |header: &mut Part| {
        write::describe(header, metadata);
        let [y, x] = domain.periodic.map(|p| if p { "periodic" } else { "black" });
        header.own_attributes.wrap_mode_name = Some(text(&format!("{x},{y}")));
        // The one custom attribute: several would be written in no fixed order.
        header.shared_attributes.other.insert(text(SOURCES), AttributeValue::Text(text(sources)));
    };
    let channels = CHANNELS.map(|name| (name, SampleType::U32));
    write_rows(domain.shape, &channels, describe, |c, at, bytes| {
        for (to, id) in bytes.as_chunks_mut().0.iter_mut().zip(&map.ids.plane(0)[at..]) {
            let located = map.table.locate(*id).map(|(source, [y, x])| [source as u32, x, y]);
            *to = located.map_or(UNASSIGNED, |l| l[c]).to_ne_bytes();
        }
    })
}

/// The channels as they are, the output's domain, the list of sources, and what the file says besides.
pub(crate) fn decode_map(
    bytes: &[u8],
    context: &Context<'_>,
) -> Result<(Grid<u32, 2>, Domain<2>, String, Metadata), Problem> {
    let mut input = Cursor::new(bytes);
    let reader = open(&mut input)?;
    let part = &reader.headers()[0];
    let header = Header {
        width: part.layer_size.0 as u64,
        height: part.layer_size.1 as u64,
        channels: CHANNELS.len(),
        alpha: false,
        depth: Depth::F32,
    };
    context.check(&header)?;
    let (channels, sources) = layout(part)?;
    let mut domain = header.domain();
    let wrap = part.own_attributes.wrap_mode_name.as_ref().map(ToString::to_string).unwrap_or_default();
    let (x, y) = wrap.split_once(',').unwrap_or((&wrap, &wrap));
    domain.periodic = [y, x].map(|mode| mode == "periodic");
    let metadata = attributes::metadata(part);
    // Every sample is read, or the file is refused.
    let mut places = zero_grid::<u32>(&header)?;
    read_rows(reader, 0, &channels, |c, at, bytes| {
        for (to, from) in places.plane_mut(c)[at..].iter_mut().zip(bytes.as_chunks().0) {
            *to = u32::from_ne_bytes(*from);
        }
    })?;
    Ok((places, domain, sources, metadata))
}

/// Whether a part is a source map.
pub(super) fn is_map(part: &Part) -> bool {
    list_of_sources(part).is_some()
}

fn list_of_sources(part: &Part) -> Option<&AttributeValue> {
    let (shared, own) = (&part.shared_attributes.other, &part.own_attributes.other);
    shared.get(&text(SOURCES)).or_else(|| own.get(&text(SOURCES)))
}

/// Places of the channels, and the list of sources.
fn layout(part: &Part) -> Result<(Vec<usize>, String), Problem> {
    let list = &part.channels.list;
    let found = || list.iter().map(|c| c.name.to_string()).collect::<Vec<_>>().join(", ");
    let not_a_map = || Problem::NotAMap { found: format!("channels {}", found()) };
    let flat = !part.deep && list.iter().all(|c| c.sampling.0 == 1 && c.sampling.1 == 1);
    let find = |name: &str| {
        list.iter().position(|c| flat && c.name.as_slice() == name.as_bytes() && c.sample_type == SampleType::U32)
    };
    let channels: Option<Vec<usize>> = CHANNELS.iter().map(|name| find(name)).collect();
    let Some(AttributeValue::Text(sources)) = list_of_sources(part) else { return Err(not_a_map()) };
    let sources = String::from_utf8(sources.as_slice().to_vec()).ok().filter(|s| s.len() <= METADATA_BYTES);
    Ok((channels.ok_or_else(not_a_map)?, sources.ok_or_else(not_a_map)?))
}

/// The map of places in sources.
pub(crate) fn assemble(
    places: &Grid<u32, 2>,
    domain: Domain<2>,
    table: SourceTable<2>,
) -> Result<SourceMap<2>, Problem> {
    let mut ids = Grid::try_filled(domain, 1, SampleId::UNASSIGNED)?;
    let channels = [0, 1, 2].map(|c| places.plane(c));
    for (i, id) in ids.plane_mut(0).iter_mut().enumerate() {
        let [source, x, y] = channels.map(|c| c[i]);
        if [source, x, y] == [UNASSIGNED; 3] {
            continue;
        }
        let known = table.sources().get(source as usize).filter(|(_, domain)| domain.contains([y, x]));
        if known.is_none() {
            let cause = format!("it names sample x={x} y={y} of source {source}, which is none");
            return Err(Problem::damaged(Format::Exr, cause));
        }
        *id = table.id(source as usize, [y, x]);
    }
    Ok(SourceMap::new(ids, table)?)
}
