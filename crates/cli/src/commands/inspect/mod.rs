//! `selvedge inspect`: what an exemplar is like, and what to try.

mod clip;
mod offsets;

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_analysis::{Kind, Lattice, Texture};
use selvedge_cms_analogies::{Constraint, Fitness, Options, fitness};
use selvedge_core::{Bytes, Domain, Exemplars, Grid, Guide, Role};
use selvedge_graphcut_textures::labels::{FillOptions, estimate_fill};
use selvedge_guides::encode_together;
use selvedge_io::{Info, ReadOptions};
use selvedge_quilting::suggest_block;
use serde_json::{Value, json};

use crate::clips::ClipInput;
use crate::commands::analogies::fit;
use crate::commands::analogies::palette::Palette;
use crate::failure::{Failure, shown};
use crate::followed::{Followed, seen};
use crate::ground::check_size;
use crate::harmonise::Layout;
use crate::inputs::{self, Input};
use crate::memory;
use crate::options::NonFinite;
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::quoted;

/// Options of `inspect`.
#[derive(Args, Debug)]
pub(crate) struct Inspect {
    /// A picture of the texture, or a clip: 'name.####.png', a folder, a quoted glob, an animation, a y4m file.
    #[arg(value_name = "EXEMPLAR", value_hint = ValueHint::FilePath)]
    exemplar: PathBuf,
    #[command(flatten)]
    nonfinite: NonFinite,
    /// Tell how well a picture that lies under the exemplar covers one that an output is to follow: what share of the
    /// second one is like nothing in the first. May be given several times.
    #[arg(long, num_args = 2, value_names = ["SRC", "TGT"], value_hint = ValueHint::FilePath)]
    guide: Vec<PathBuf>,
    /// Tell by which offsets the picture comes again most often, across and down: fill copies by these. Up to seconds.
    #[arg(long)]
    offsets: bool,
}

impl Inspect {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("inspect");
        let read: Vec<PathBuf> = std::iter::once(&self.exemplar).chain(&self.guide).cloned().collect();
        outputs::check::<&Path>(session, &[], &read)?;
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        if let Some(clip) = ClipInput::found(&self.exemplar, &options)? {
            return self.clip(session, report, clip);
        }
        let about = |failure: Failure| failure.about(&self.exemplar);
        let input = Input::new(session, &self.exemplar)?;
        let needed = need(&input.probe(&options)?, self.offsets);
        memory::check_fixed(&session.limits, needed).map_err(about)?;
        report.estimate = Some(needed.0);
        let picture = input.read(session, &options, &mut report)?;
        let plane = &picture.plane;
        let exemplars = Exemplars::of(&[std::slice::from_ref(plane)]).map_err(|e| about(e.into()))?;
        report.stage("read");
        let source = &exemplars.sources()[0];
        session.watch.busy("inspect");
        let texture = Texture::of(&source.features, source.valid.as_deref(), exemplars.weights());
        let texture = texture.map_err(|e| about(Failure::of(e.kind(), &e, e.remedy())))?;
        let block = suggest_block(&exemplars).map_err(|e| about(e.into()))?;
        let pairs = self
            .guide
            .chunks(2)
            .map(|pair| followed(session, (&self.exemplar, &exemplars), pair, &options, &mut report));
        let pairs = pairs.collect::<Result<Vec<_>, Failure>>()?;
        let found = if self.offsets { Some(offsets::offsets(&exemplars).map_err(about)?) } else { None };
        report.stage("inspect");
        let ([h, w], format) = (plane.domain().shape, picture.format.name());
        let (channels, depth) = (plane.samples.channels(), plane.samples.depth().name());
        let command = self.command(&texture);
        report.stats = json!({
            "format": format,
            "width": w,
            "height": h,
            "channels": channels,
            "alpha": plane.alpha,
            "depth": depth,
            "kind": kind(texture.kind),
            "lattice": texture.lattice.as_ref().map(lattice_json),
            "feature_size": texture.feature_size,
            "lines": {"rows": of_1(texture.lines.rows), "columns": of_1(texture.lines.columns),
                "upright": of_1(texture.lines.upright)},
            "shade": of_1(texture.shade),
            "grain": of_1(texture.grain),
            "body": of_1(texture.body),
            "block": block,
            "command": command,
        });
        if !pairs.is_empty() {
            report.stats["guides"] = pairs.iter().map(|(json, _)| json.clone()).collect();
        }
        if let Some(found) = &found {
            report.stats["offsets"] = json!(found);
        }
        let text = [
            format!("{}\n", shown(&self.exemplar)),
            format!("  {format}, {w}x{h} px, {channels} channel(s), {depth}\n"),
            format!("  kind: {}\n", described(&texture)),
            format!("  lattice: {}\n", words(texture.lattice.as_ref())),
            format!("  structures: {}; quilt's block: {block} px\n", structures(&texture)),
            found.map_or(String::new(), |found| format!("  comes again at: {} (x,y)\n", offsets::told(&found))),
            format!("  try: {}\n", selvedge_io::one_line(&command)),
        ];
        Ok(Done::answered(report, text.concat() + &pairs.into_iter().map(|(_, text)| text).collect::<String>()))
    }

    /// A command line to begin with: the method that serves this kind, about twice the size, without losses.
    fn command(&self, texture: &Texture) -> String {
        let name = self.exemplar.to_string_lossy();
        let stem = self.exemplar.file_stem().unwrap_or_default().to_string_lossy();
        let [h, w] = [0, 1].map(|axis| closing(texture, axis, texture.shape[axis] * 2));
        let output = quoted(&format!("{stem}-{w}x{h}.png"));
        let method = if serves_graphcut(texture) { "graphcut" } else { "quilt" };
        let tile = if texture.is_orderly() { " --tile xy" } else { "" };
        format!("selvedge {method} {} -o {output} --size {w}x{h}{tile}", quoted(&name))
    }
}

/// How well a picture under the exemplar covers one to follow, also by label if it has some: for programs, and for
/// people.
fn followed(
    session: &Session<'_>,
    (exemplar, exemplars): (&Path, &Exemplars<2>),
    pair: &[PathBuf],
    options: &ReadOptions,
    report: &mut Report,
) -> Result<(Value, String), Failure> {
    let [source, target] = [0, 1].map(|i| {
        let input = Input::new(session, &pair[i])?;
        memory::check_fixed(&session.limits, need(&input.probe(options)?, false)).map_err(|e| e.about(&pair[i]))?;
        Followed::new(input.read(session, options, report)?.plane, &pair[i])
    });
    let (source, target) = (source?, target?);
    let (of, expected) = (format!("{} has", shown(exemplar)), exemplars.sources()[0].domain().shape);
    check_size(&pair[0], source.plane.domain().shape, Some(expected), &of, "give a guide of the same size")?;
    let mut maps = encode_together(&[&source.plane, &target.plane]).map_err(|e| Failure::from(e).about(&pair[1]))?;
    let over = maps.pop().expect("the target's");
    let guide = Guide::new(exemplars, &maps, over).map_err(|e| Failure::from(e).about(&pair[0]))?;
    let guide = seen(guide, &[source], &target).map_err(|e| e.about(&pair[0]))?;
    let constraints = [Constraint::new(guide)];
    let small = |e: selvedge_cms_analogies::Error| match e {
        selvedge_cms_analogies::Error::Neighborhood { .. } => Failure::from(e).remedy("use larger pictures"),
        e => Failure::from(e),
    };
    let found = fitness(exemplars, &constraints, &Options::default()).map_err(|e| small(e).about(&pair[1]))?;
    let (fit, target) = (&found[0], constraints[0].guide.target());
    let name = selvedge_io::display_name(&pair[1]);
    let (mut json, mut text) = (fit::json(fit), format!("  guide {name}: {}\n", fit::told(fit)));
    (json["source"], json["target"]) = (selvedge_io::display_name(&pair[0]).into(), name.into());
    if let Some(palette) = Palette::of(&[target]).ok().filter(|palette| palette.is_exact) {
        let mut labels = serde_json::Map::new();
        for (label, share) in by_label(&palette, target, fit)? {
            text += &format!("    {label}: {:.0} %\n", 100.0 * share);
            labels.insert(label, ((share * 1e3).round() / 1e3).into());
        }
        json["labels"] = labels.into();
    }
    Ok((json, text))
}

/// By label, which share of its samples lies where nothing under the exemplar is like the target.
fn by_label(palette: &Palette, target: &Grid<u8, 2>, fit: &Fitness) -> Result<Vec<(String, f64)>, Failure> {
    let (labels, _) = palette.nearest(target)?;
    let mut counts: Vec<(String, [usize; 2])> = palette.names().map(|name| (name, [0, 0])).collect();
    for (at, label) in target.domain().positions().zip(labels) {
        let [far, all] = &mut counts[usize::from(label)].1;
        (*far, *all) = (*far + usize::from(fit.is_uncovered(at)), *all + 1);
    }
    Ok(counts.into_iter().map(|(name, [far, all])| (name, far as f64 / all.max(1) as f64)).collect())
}

/// An upper bound of what it takes: the picture, its features, and what is made of them.
fn need(info: &Info, offsets: bool) -> Bytes {
    let (domain, layout) = (Domain::open([info.height, info.width]), Layout::of(info));
    let kept = memory::pictures(std::slice::from_ref(info), layout.channels(), info.depth);
    let analysis = selvedge_analysis::estimate_texture(domain, layout.colors, info.alpha);
    let options = FillOptions::default();
    let found = if offsets { estimate_fill(&[domain], layout.colors, domain, &options) } else { Bytes(0) };
    let worked = memory::sources(&[domain], layout.colors) + analysis.then(found);
    memory::PROGRAM + kept + memory::reading([info]).then(worked)
}

/// Things are better kept whole by patches of any shape, and what has an order by patches laid along it: of 15
/// textures of things readers preferred the graph cut to the quilt on 12 and 14. Grain is as well quilted, in a
/// tenth of the time.
fn serves_graphcut(texture: &Texture) -> bool {
    texture.is_orderly() || matches!(texture.kind, Kind::Scene | Kind::Objects)
}

/// The length next to this one that closes the texture's lattice, where it has a clear one.
fn closing(texture: &Texture, axis: usize, length: u32) -> u32 {
    texture.order().map_or(length, |l| l.closing(axis, length))
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Lattice => "lattice",
        Kind::Text => "text",
        Kind::Lines => "lines",
        Kind::Objects => "objects",
        Kind::Scene => "scene",
        _ => "stochastic",
    }
}

fn described(texture: &Texture) -> String {
    let words = match texture.kind {
        Kind::Lattice => "lattice (comes again in two directions)",
        Kind::Text => "text (rows of signs)",
        Kind::Lines => "lines (planks, courses, stripes)",
        Kind::Objects => "objects (bodies in no order)",
        Kind::Scene => "scene (few large things: hardly a texture)",
        _ => "stochastic (grain)",
    };
    if texture.is_uneven() { format!("{words}, uneven light") } else { words.to_owned() }
}

/// How large what is in it is.
fn structures(texture: &Texture) -> String {
    let [h, w] = texture.shape;
    match texture.feature_size {
        // Likeness that is lost nowhere is no length.
        size if h.min(w) <= size => "as large as the picture".to_owned(),
        size => format!("up to about {size} px"),
    }
}

/// Thousandths.
fn of_1(share: u32) -> f64 {
    f64::from(share) / 1000.0
}

fn lattice_json(lattice: &Lattice) -> Value {
    let vectors = lattice.vectors.map(|[y, x]| json!({"x": x, "y": y}));
    let along = lattice.along.map(|way| way.map(|(samples, times)| f64::from(samples) / f64::from(times)));
    json!({"vectors": vectors, "along_x": along[1], "along_y": along[0], "strength": of_1(lattice.strength)})
}

fn words(lattice: Option<&Lattice>) -> String {
    // Fainter ones are chance.
    const FAINT: u32 = 350;
    let Some(lattice) = lattice.filter(|l| FAINT <= l.strength) else { return "none that is clear".to_owned() };
    let one = |vector: [i32; 2]| match vector {
        [0, x] => format!("{x} px along x"),
        [y, 0] => format!("{y} px along y"),
        [y, x] => format!("x={x} y={y} px"),
    };
    let [a, b] = lattice.vectors.map(one);
    format!("{a}, {b} ({:.2})", of_1(lattice.strength))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_is_told_by_its_two_ways() {
        let lattice = Lattice { vectors: [[0, 8], [12, 4]], along: [Some((24, 1)), Some((8, 1))], strength: 700 };
        assert_eq!(words(Some(&lattice)), "8 px along x, x=4 y=12 px (0.70)");
        assert_eq!(words(Some(&Lattice { strength: 200, ..lattice })), "none that is clear");
        assert_eq!(words(None), "none that is clear");
    }
}
