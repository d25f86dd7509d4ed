//! Source map files: which exemplar sample stands where, as EXR, so that a map can be applied again later.
//!
//! Three channels of 32-bit integers: `source`, and `x` and `y` in it; 2^32 - 1 in all three where nothing is assigned.
//! The attribute `selvedge.sources` has one line a source, in order:
//! `exemplar=0 turns=1 mirror=0 width=64 height=48 wrap=x blake3=00ff name=brick.png`. A source that was resampled has
//! `degrees=30 scale=0.5` (clockwise, as decimals that are read back exactly) instead of `turns`; `width`, `height` and
//! `wrap` are the source's, not its exemplar's. The standard attribute `wrapmodes` tells the periodic axes of the
//! output.

use std::path::Path;

use selvedge_core::{Domain, Limits, Origin, SourceMap, SourceTable, Transform};

use crate::atomic::write_bytes;
use crate::codec::{Context, guarded};
use crate::error::{Error, Problem};
use crate::header::Header;
use crate::metadata::Metadata;
use crate::name::escaped;
use crate::options::ReadOptions;
use crate::provenance::Fingerprint;
use crate::read::read_bytes;
use crate::{Depth, Format, exr};

/// A source map and what its file says besides.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MapFile {
    /// The map.
    pub map: SourceMap<2>,
    /// The exemplars that its sources were made from, by their number.
    pub exemplars: Vec<Fingerprint>,
    /// What the file says besides.
    pub metadata: Metadata,
}

/// Writes a map with the exemplars that it was made from, whole or not at all.
///
/// # Errors
/// [`Problem::ExemplarCount`] if a source names an exemplar that is not given, and those of
/// [`write()`](crate::write()).
pub fn write_map(path: impl AsRef<Path>, file: &MapFile, no_clobber: bool) -> Result<(), Error> {
    let path = path.as_ref();
    write_bytes(path, &encode_map(file, path)?, no_clobber)
}

/// The bytes of a map file; see [`write_map`]. Equal maps give equal bytes.
///
/// # Errors
/// Those of [`write_map`].
pub fn encode_map(file: &MapFile, name: impl AsRef<Path>) -> Result<Vec<u8>, Error> {
    let encoded = sources(file).and_then(|sources| exr::encode_map(&file.map, &sources, &file.metadata));
    encoded.map_err(|p| Error::new(name.as_ref(), p))
}

/// Reads a map file.
///
/// # Errors
/// [`Problem::NotAMap`] for any other EXR file, and those of [`read()`](crate::read()).
pub fn read_map(path: impl AsRef<Path>, limits: &Limits) -> Result<MapFile, Error> {
    let path = path.as_ref();
    let bytes = read_bytes(path, limits).map_err(|p| Error::new(path, p))?;
    decode_map(&bytes, path, limits)
}

/// Reads a map from the bytes of its file; see [`read_map`].
///
/// # Errors
/// Those of [`read_map`].
pub fn decode_map(bytes: &[u8], name: impl AsRef<Path>, limits: &Limits) -> Result<MapFile, Error> {
    let options = ReadOptions { limits: *limits, ..ReadOptions::default() };
    let context = Context::new(&options, bytes.len() as u64);
    guarded(Format::Exr, || decode(bytes, &context)).map_err(|p| Error::new(name.as_ref(), p))
}

fn decode(bytes: &[u8], context: &Context<'_>) -> Result<MapFile, Problem> {
    match Format::of_content(bytes) {
        _ if bytes.is_empty() => Err(Problem::Empty),
        Some(Format::Exr) => {
            let (places, domain, text, metadata) = exr::decode_map(bytes, context)?;
            let (table, exemplars) =
                parse(&text).ok_or_else(|| Problem::damaged(Format::Exr, "its list of sources"))?;
            for (_, domain) in table.sources() {
                let [height, width] = domain.shape.map(u64::from);
                Header { width, height, channels: 1, alpha: false, depth: Depth::U8 }
                    .check_size(&context.options.limits)?;
            }
            let map = exr::assemble(&places, domain, table)?;
            Ok(MapFile { map, exemplars, metadata })
        }
        other => Err(Problem::NotAMap { found: other.map_or("unknown data".to_owned(), |f| f.to_string()) }),
    }
}

/// One line a source.
fn sources(file: &MapFile) -> Result<String, Problem> {
    let mut text = String::new();
    for (origin, domain) in file.map.table.sources() {
        let exemplar = usize::from(origin.exemplar);
        let how = match origin.transform {
            Transform::Exact { quarter_turns, mirror } => format!("turns={quarter_turns} mirror={}", u8::from(mirror)),
            Transform::Resampled { degrees, scale, mirror } => {
                format!("degrees={degrees} scale={scale} mirror={}", u8::from(mirror))
            }
            other => return Err(Problem::unsupported(Format::Exr, format!("a source map with {other:?}"))),
        };
        let missing = Problem::ExemplarCount { found: file.exemplars.len(), needed: exemplar + 1 };
        let Fingerprint { name, blake3 } = file.exemplars.get(exemplar).ok_or(missing)?;
        let [height, width] = domain.shape;
        let line = format!(
            "exemplar={exemplar} {how} width={width} height={height} wrap={} blake3={} name={}\n",
            wrap(domain),
            escaped(blake3.as_bytes()),
            escaped(name.as_bytes())
        );
        text.push_str(&line);
    }
    Ok(text)
}

fn wrap(domain: &Domain<2>) -> &'static str {
    match domain.periodic {
        [false, false] => "",
        [false, true] => "x",
        [true, false] => "y",
        [true, true] => "xy",
    }
}

/// The sources and their exemplars; `None` if the text is not ours or contradicts itself.
fn parse(text: &str) -> Option<(SourceTable<2>, Vec<Fingerprint>)> {
    let mut sources = Vec::new();
    let mut exemplars: Vec<Fingerprint> = Vec::new();
    for line in text.lines() {
        let (fields, name) = line.split_once(" name=")?;
        let field = |key: &str| fields.split(' ').find_map(|f| f.strip_prefix(key)?.strip_prefix('='));
        let number = |key| field(key)?.parse::<u32>().ok();
        let exemplar = u16::try_from(number("exemplar")?).ok()?;
        let mirror = number("mirror")? == 1;
        let transform = if let Some(turns) = number("turns") {
            Transform::Exact { quarter_turns: u8::try_from(turns).ok().filter(|t| *t < 4)?, mirror }
        } else {
            let decimal = |key| field(key)?.parse::<f64>().ok();
            let transform = Transform::Resampled { degrees: decimal("degrees")?, scale: decimal("scale")?, mirror };
            Some(transform).filter(|t| t.is_valid())?
        };
        let wrap = field("wrap")?;
        let periodic = [wrap.contains('y'), wrap.contains('x')];
        let domain = Domain { shape: [number("height")?, number("width")?], periodic };
        sources.push((Origin { exemplar, transform }, domain));

        let found = Fingerprint { name: name.to_owned(), blake3: field("blake3")?.to_owned() };
        let place = usize::from(exemplar);
        if exemplars.len() <= place {
            // An exemplar of which no source is left keeps its number.
            exemplars.resize(place + 1, Fingerprint::default());
        }
        if exemplars[place] != Fingerprint::default() && exemplars[place] != found {
            return None;
        }
        exemplars[place] = found;
    }
    Some((SourceTable::new(sources).ok()?, exemplars))
}

impl MapFile {
    /// A map and the exemplars that it was made from, by their number.
    pub fn new(map: SourceMap<2>, exemplars: Vec<Fingerprint>, metadata: Metadata) -> Self {
        Self { map, exemplars, metadata }
    }
}
