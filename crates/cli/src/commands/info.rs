//! `selvedge info`: what is in a picture or a source map, and how it was made.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Association, SourceMap, Transform};
use selvedge_io::{DensityUnit, Fingerprint, Info as Header, MapFile, Metadata};
use serde_json::{Value, json};

use crate::failure::{Failure, shown};
use crate::inputs::{Either, Input};
use crate::made;
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;

/// Options of `info`.
#[derive(Args, Debug)]
pub(crate) struct Info {
    /// A picture or a source map.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
}

impl Info {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("info");
        outputs::check::<&Path>(session, &[], std::slice::from_ref(&self.file))?;
        let (facts, metadata) = match Input::new(session, &self.file)?.look(session, &mut report)? {
            Either::Picture(header) => (picture(&header), header.metadata),
            Either::Map(file) => (source_map(&file)?, file.metadata),
        };
        let facts: Facts = facts.into_iter().chain(carried(&metadata)).collect();
        let text = facts.iter().fold(shown(&self.file) + "\n", |text, (name, fact)| text + &line(name, fact));
        report.stats = facts.into_iter().map(|(name, fact)| (name.replace(' ', "_"), fact)).collect();
        Ok(Done::answered(report, text))
    }
}

type Facts = Vec<(&'static str, Value)>;

/// A fact as text; one that is a list takes a line an item, one that has parts a line a part.
fn line(name: &str, fact: &Value) -> String {
    match fact {
        Value::Null => String::new(),
        Value::Array(items) => items.iter().map(|item| line(name, item)).collect(),
        Value::Object(parts) if name == "made by selvedge" => {
            parts.iter().fold(format!("  {name}\n"), |text, (name, part)| text + "  " + &line(name, part))
        }
        Value::Object(parts) => {
            let words: Vec<String> = parts.iter().map(|(name, part)| format!("{name} {}", plain(part))).collect();
            format!("  {name}: {}\n", words.join(", "))
        }
        other => format!("  {name}: {}\n", plain(other)),
    }
}

/// A value without the quotes of JSON.
fn plain(value: &Value) -> String {
    selvedge_io::one_line(&value.as_str().map_or_else(|| value.to_string(), str::to_owned))
}

fn picture(header: &Header) -> Facts {
    vec![
        ("format", header.format.name().into()),
        ("size", format!("{}x{} px", header.width, header.height).into()),
        ("channels", header.channels.into()),
        ("alpha", header.alpha.into()),
        ("colours with alpha", header.alpha.then(|| association(header.association)).into()),
        ("depth", header.depth.name().into()),
        ("channel names", (!header.channel_names.is_empty()).then(|| header.channel_names.join(", ")).into()),
    ]
}

fn source_map(file: &MapFile) -> Result<Facts, Failure> {
    let map = &file.map;
    let ([h, w], [y, x]) = (map.domain().shape, map.domain().periodic);
    let tile = [(x, "x"), (y, "y")].into_iter().filter(|(tiles, _)| *tiles).map(|(_, axis)| axis).collect::<String>();
    let exemplars: Vec<Value> =
        file.exemplars.iter().map(|e: &Fingerprint| json!({"name": e.name, "blake3": e.blake3})).collect();
    let sources: Vec<Value> = map
        .table
        .sources()
        .iter()
        .map(|(origin, domain)| {
            let [h, w] = domain.shape;
            let mut source = json!({"exemplar": origin.exemplar, "size": format!("{w}x{h} px")});
            let (degrees, scale, mirror) = match origin.transform {
                Transform::Exact { quarter_turns, mirror } => (90.0 * f64::from(quarter_turns), 1.0, mirror),
                Transform::Resampled { degrees, scale, mirror } => (degrees, scale, mirror),
                _ => (0.0, 1.0, false),
            };
            // Only what was done to the exemplar.
            let done = [
                ("degrees", (degrees != 0.0).then(|| degrees.into())),
                ("scale", (scale != 1.0).then(|| scale.into())),
                ("mirror", mirror.then(|| mirror.into())),
            ];
            done.into_iter().for_each(|(name, value)| {
                if let Some(value) = value {
                    source[name] = value;
                }
            });
            source
        })
        .collect();
    Ok(vec![
        ("format", "source map".into()),
        ("size", format!("{w}x{h} px").into()),
        ("tile", (!tile.is_empty()).then_some(tile).into()),
        ("exemplar", exemplars.into()),
        ("source", sources.into()),
        ("percent at seams", percent(seams(map))),
        ("percent of exemplars used", percent(used(map)?)),
        ("unassigned", map.ids.plane(0).iter().filter(|id| !id.is_assigned()).count().into()),
    ])
}

fn association(association: Association) -> &'static str {
    match association {
        Association::Straight => "straight",
        Association::Premultiplied => "multiplied by it",
    }
}

/// To a tenth.
fn percent((part, of): (usize, usize)) -> Value {
    ((1000.0 * part as f64 / of.max(1) as f64).round() / 10.0).into()
}

/// Samples that the next one along some axis does not continue, and samples in all.
fn seams(map: &SourceMap<2>) -> (usize, usize) {
    let at_seam = |at: &[u32; 2]| (0..2).any(|axis| map.is_seam(*at, axis));
    (map.domain().positions().filter(at_seam).count(), map.domain().len())
}

/// Samples of the sources that stand somewhere in the map, and samples in all.
fn used(map: &SourceMap<2>) -> Result<(usize, usize), Failure> {
    // By what stands in the map: sources may be of any size that somebody claims.
    let mut seen = selvedge_core::try_vec(map.domain().len(), u32::MAX)?;
    for (to, id) in seen.iter_mut().zip(map.ids.plane(0)).filter(|(_, id)| id.is_assigned()) {
        *to = id.get();
    }
    seen.sort_unstable();
    seen.dedup();
    let none = usize::from(seen.last() == Some(&u32::MAX));
    Ok((seen.len() - none, map.table.len() as usize))
}

/// Code points of a cICP chunk, the known ones by name. `[H.273]`
fn code_points([primaries, transfer, matrix, full]: [u8; 4]) -> String {
    let primaries = match primaries {
        1 => "BT.709".into(),
        9 => "BT.2020".into(),
        12 => "Display P3".into(),
        other => format!("primaries {other}"),
    };
    let transfer = match transfer {
        1 => "BT.709".into(),
        8 => "linear".into(),
        13 => "sRGB".into(),
        16 => "PQ".into(),
        18 => "HLG".into(),
        other => format!("transfer {other}"),
    };
    let range = if full == 0 { "narrow" } else { "full" };
    format!("{primaries}, {transfer}, matrix {matrix}, {range} range")
}

/// What a file says besides its samples.
fn carried(metadata: &Metadata) -> Facts {
    let density = metadata.density.map(|d| {
        let unit = match d.unit {
            DensityUnit::Aspect => "(aspect only)",
            DensityUnit::Metre => "a metre",
            DensityUnit::Centimetre => "a centimetre",
            DensityUnit::Inch => "an inch",
        };
        format!("{} x {} {unit}", d.x, d.y)
    });
    let profile = metadata.icc.as_ref().map(|icc| format!("ICC, {} bytes", icc.len()));
    let mut facts: Facts = vec![
        ("profile", profile.into()),
        ("cicp", metadata.cicp.map(code_points).into()),
        ("srgb intent", metadata.srgb.into()),
        ("gamma", metadata.gamma.map(|g| f64::from(g) / 100_000.0).into()),
        ("chromaticities", metadata.chromaticities.map(|c| format!("{c:?}")).into()),
        ("density", density.into()),
    ];
    if let Some(made) = &metadata.provenance {
        let inputs: Vec<Value> = made.inputs.iter().map(|i| json!({"name": i.name, "blake3": i.blake3})).collect();
        let command = made::pasteable(made);
        let made = json!({"version": made.version, "seed": made.seed, "input": inputs, "command": command});
        facts.push(("made by selvedge", made));
    }
    facts
}
