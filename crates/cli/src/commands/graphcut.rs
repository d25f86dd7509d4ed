//! `selvedge graphcut`: graphcut textures. `[Kwatra03 3-6]`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use selvedge_core::{Encoder, Exemplars, Grid, Plane, Render, Role, Samples, SeamMeasure, Seed, SourceMap, Transform};
use selvedge_graphcut_textures::{Error, Feathered, Options, Placement, Splined, Stats, graphcut};
use serde_json::json;

use crate::args::Synthesis;
use crate::commands::Session;
use crate::failure::{Failure, shown};
use crate::files::{self, Input};
use crate::report::Report;
use crate::size::Tile;

/// Options of `graphcut`.
#[derive(Args, Debug)]
pub(crate) struct Graphcut {
    /// Pictures of the texture.
    #[arg(required = true, value_name = "EXEMPLAR")]
    exemplars: Vec<PathBuf>,
    #[command(flatten)]
    synthesis: Synthesis,
    /// How the next patch is found.
    #[arg(long, value_enum, default_value_t = PlacementArg::Auto)]
    placement: PlacementArg,
    /// How seams are priced: by their difference, or by difference over gradient.
    #[arg(long, value_enum, default_value_t = SeamArg::Gradient)]
    seam: SeamArg,
    /// Side of the regions that patches are found for, in pixels, or auto.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = number_or::<Auto>)]
    region: Auto,
    /// How far patches may reach beyond their region, in pixels; auto chooses, all is as far as the exemplar does.
    #[arg(long, value_name = "N|auto|all", default_value = "auto", value_parser = number_or::<Reach>)]
    reach: Reach,
    /// How freely patches are drawn among those that fit worse than the best; the paper uses 0.001 to 1.
    #[arg(long, value_name = "K", default_value_t = Options::default().randomness)]
    randomness: f64,
    /// How much patches avoid to stand to each other as others do already.
    #[arg(long, value_name = "V", default_value_t = Options::default().variety)]
    variety: f64,
    /// Patches laid over the worst seams at the end, or auto: until seams stop becoming cheaper.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = number_or::<Auto>)]
    refine: Auto,
    /// Refinements in a row that bring nothing before the seams count as settled.
    #[arg(long, value_name = "N", default_value_t = Options::default().patience)]
    patience: u32,
    /// Patches that are tried at each step, of which the best is taken.
    #[arg(long, value_name = "N", default_value_t = Options::default().tries)]
    tries: u32,
    /// Feather seams with a kernel of this many pixels (sigma).
    #[arg(long, value_name = "SIGMA", conflicts_with = "spline")]
    feather: Option<f64>,
    /// Spline seams over this many bands of detail, 1 to 5.
    #[arg(long, value_name = "BANDS")]
    spline: Option<u32>,
    /// Also write a picture of the patches and their seams.
    #[arg(long, value_name = "FILE")]
    explain: Option<PathBuf>,
    /// Use exemplars turned clockwise by these angles as well, in degrees.
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', allow_hyphen_values = true)]
    rotate: Vec<f64>,
    /// Use exemplars magnified by these factors as well.
    #[arg(long, value_name = "FACTOR", value_delimiter = ',')]
    scale: Vec<f64>,
    /// Turn exemplars as well, by quarter turns.
    #[arg(long)]
    turn: bool,
    /// Mirror exemplars as well.
    #[arg(long)]
    mirror: bool,
}

/// A number, or a choice by the program.
#[derive(Clone, Copy, Debug)]
struct Auto(Option<u32>);

/// The same, or the whole exemplar.
#[derive(Clone, Copy, Debug)]
struct Reach(Option<u32>);

/// What is written instead of a number, and what it stands for.
trait Words {
    const WORDS: &[(&str, Option<u32>)];
    fn of(value: Option<u32>) -> Self;
}

impl Words for Auto {
    const WORDS: &[(&str, Option<u32>)] = &[("auto", None)];
    fn of(value: Option<u32>) -> Self {
        Self(value)
    }
}

impl Words for Reach {
    const WORDS: &[(&str, Option<u32>)] = &[("auto", None), ("all", Some(u32::MAX))];
    fn of(value: Option<u32>) -> Self {
        Self(value)
    }
}

fn number_or<W: Words>(text: &str) -> Result<W, String> {
    if let Some((_, value)) = W::WORDS.iter().find(|(word, _)| *word == text) {
        return Ok(W::of(*value));
    }
    let words: Vec<&str> = W::WORDS.iter().map(|(word, _)| *word).collect();
    text.parse().map(|n| W::of(Some(n))).map_err(|_| format!("write a number, or {}", words.join(" or ")))
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PlacementArg {
    /// Entire where the exemplar repeats itself, else sub.
    Auto,
    /// Anywhere.
    Random,
    /// Where the whole exemplar agrees with what is there.
    Entire,
    /// Where the exemplar agrees with what is there in the region.
    Sub,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SeamArg {
    /// By the difference of the two patches.
    Difference,
    /// By that difference over their gradients.
    Gradient,
}

impl Graphcut {
    fn options(&self) -> Options {
        Options {
            placement: match self.placement {
                PlacementArg::Auto => Placement::Auto,
                PlacementArg::Random => Placement::Random,
                PlacementArg::Entire => Placement::Entire,
                PlacementArg::Sub => Placement::Sub,
            },
            seam: match self.seam {
                SeamArg::Difference => SeamMeasure::Difference,
                SeamArg::Gradient => SeamMeasure::Gradient,
            },
            region: self.region.0,
            reach: self.reach.0,
            randomness: self.randomness,
            variety: self.variety,
            refine: self.refine.0,
            patience: self.patience,
            tries: self.tries,
        }
    }

    /// The orientations asked for.
    fn transforms(&self) -> Vec<Transform> {
        let turns = if self.turn { 0..4 } else { 0..1 };
        let mirrors: &[bool] = if self.mirror { &[false, true] } else { &[false] };
        let exact = turns
            .flat_map(|quarter_turns| mirrors.iter().map(move |&mirror| Transform::Exact { quarter_turns, mirror }));
        let rotated = self.rotate.iter().map(|&degrees| Transform::Resampled { degrees, scale: 1.0 });
        let scaled = self.scale.iter().map(|&scale| Transform::Resampled { degrees: 0.0, scale });
        exact.chain(rotated).chain(scaled).collect()
    }

    /// The output's samples, with seams blended where that is asked for.
    fn render(&self, exemplars: &Exemplars<2>, map: SourceMap<2>, planes: &[&Plane<2>]) -> Result<Plane<2>, Failure> {
        Ok(match (self.feather, self.spline) {
            (Some(sigma), _) => Feathered::new(exemplars, map, sigma)?.render(planes)?,
            (None, Some(bands)) => Splined::new(exemplars, map, bands)?.render(planes)?,
            (None, None) => map.render(planes)?,
        })
    }

    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<u8, Failure> {
        let mut report = Report::new("graphcut");
        let options = self.options();
        options.validate()?;
        let output = self.synthesis.output.as_path();
        files::check_output(session, output, &self.exemplars.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let inputs = files::read_all(session, &self.exemplars, &mut report)?;
        let planes: Vec<&[Plane<2>]> = inputs.iter().map(|i| std::slice::from_ref(&i.picture.plane)).collect();
        let encoder = Encoder::fit(&planes).map_err(|e| about(&inputs, Failure::from(e)))?;
        let exemplars = Exemplars::new(&encoder, &planes, &self.transforms());
        let exemplars = exemplars.map_err(|e| about(&inputs, Failure::from(e)))?;
        let domain = Tile::domain(self.synthesis.tile, self.synthesis.size.shape(planes[0][0].domain().shape));
        files::check_size(session, domain)?;
        report.stage("read");

        let woven = graphcut(&exemplars, domain, &options, &session.run()).map_err(|e| failure(&inputs, e))?;
        session.check_complete(woven.complete)?;
        report.stage("synthesis");

        let payload: Vec<&Plane<2>> = planes.iter().map(|p| &p[0]).collect();
        let explained = self.explain.as_ref().map(|_| patches(&woven.result)).transpose()?;
        let plane = self.render(&exemplars, woven.result, &payload)?;
        report.stage("render");
        if !session.global.dry_run {
            if let (Some(path), Some(explained)) = (&self.explain, &explained) {
                files::write(session, path, explained, &inputs[0].picture.metadata, &mut report)?;
            }
            files::write(session, output, &plane, &inputs[0].picture.metadata, &mut report)?;
        }
        report.stage("write");

        let [h, w] = domain.shape;
        let stats = woven.stats;
        report.options = json!({
            "size": format!("{w}x{h}"),
            "tile": self.synthesis.tile.map(|t| format!("{t:?}").to_lowercase()),
            "placement": format!("{:?}", stats.placement).to_lowercase(),
            "seam": format!("{:?}", options.seam).to_lowercase(),
            "region": stats.region,
            "reach": stats.reach,
            "randomness": options.randomness,
            "variety": options.variety,
            "refine": options.refine,
            "patience": options.patience,
            "tries": options.tries,
            "turn": self.turn,
            "mirror": self.mirror,
            "rotate": self.rotate,
            "scale": self.scale,
            "feather": self.feather,
            "spline": self.spline,
        });
        report.stats = json!({
            "periodicity": stats.periodicity,
            "patches": stats.patches,
            "refinements": stats.refinements,
            "improvements": stats.improvements,
            "cuts": stats.cuts,
            "cut_nodes": stats.cut_nodes,
            "energy": stats.energy,
        });
        let line = line(output, [w, h], &stats, report.elapsed());
        session.finish(&mut report, &line);
        Ok(0)
    }
}

/// A picture of a map: each patch in a colour of its own, seams in black.
fn patches(map: &SourceMap<2>) -> Result<Plane<2>, Failure> {
    let domain = map.domain();
    let mut colours = Grid::try_filled(domain, 3, 0_u8)?;
    for at in domain.positions().filter(|&at| !(0..2).any(|axis| map.is_seam(at, axis))) {
        let Some((source, from)) = map.locate(at) else { continue };
        let offset = (0..2).fold(source as u64, |key, a| (key << 20) ^ u64::from(at[a].wrapping_sub(from[a])));
        let bytes = Seed(0).derive("explain/patch", offset).0.to_le_bytes();
        (0..3).for_each(|c| colours.set(c, at, bytes[c] / 2 + 96));
    }
    Ok(Plane::new(Role::Color, Samples::U8(colours)))
}

fn line(output: &Path, [w, h]: [u32; 2], stats: &Stats, seconds: f64) -> String {
    let (name, placement) = (shown(output), format!("{:?}", stats.placement).to_lowercase());
    let (patches, improvements) = (stats.patches, stats.improvements);
    format!(
        "{name}: {w}x{h} px from {patches} patches and {improvements} refinements, {placement} placement, in {seconds:.2} s"
    )
}

/// Errors about exemplars name the file.
fn failure(inputs: &[Input], error: Error) -> Failure {
    let from_exemplar = matches!(error, Error::RegionExceedsExemplar { .. });
    let failure = Failure::from(error);
    if from_exemplar { about(inputs, failure) } else { failure }
}

fn about(inputs: &[Input], failure: Failure) -> Failure {
    match inputs {
        [only] => failure.about(&only.path),
        _ => failure,
    }
}
