//! `selvedge graphcut`: graphcut textures. `[Kwatra03 3-6]`

use clap::{Args, ValueEnum};
use selvedge_core::{Domain, Run, SeamMeasure, Transform};
use selvedge_graphcut_textures::{Error, Options, Placement, Stats, graphcut};
use serde_json::json;

use crate::failure::Failure;
use crate::report::Done;
use crate::session::Session;
use crate::used::Used;
use crate::weaving::{Loom, Plan, Sizing, Weaving};

/// Options of `graphcut`.
#[derive(Args, Debug)]
pub(crate) struct Graphcut {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
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
        turns
            .flat_map(|quarter_turns| mirrors.iter().map(move |&mirror| Transform::Exact { quarter_turns, mirror }))
            .collect()
    }

    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let options = self.options();
        options.validate()?;
        let loom = self.weaving.begin(
            session,
            &Plan {
                command: "graphcut",
                others: Vec::new(),
                shape: &|exemplar| self.sizing.shape(exemplar),
                transforms: &self.transforms(),
                estimate: &estimate,
            },
        )?;
        let exemplars = &loom.loaded.exemplars;
        if loom.is_dry() {
            // The least output tells whether options and exemplars go together.
            let one = graphcut(exemplars, Domain::open([1, 1]), &options, &Run::seeded(0));
            one.map_err(|e| failure(&loom, e))?;
            let used = self.used(&loom, &options, None);
            return Ok(loom.would(used, "from patches"));
        }
        let woven = graphcut(exemplars, loom.domain, &options, &session.run()).map_err(|e| failure(&loom, e))?;
        let stats = woven.stats;
        let used = self.used(&loom, &options, Some(&stats));
        loom.finish(woven.result, woven.complete, used, counts(&stats), &how(&stats))
    }

    /// The options as used; what the program chose is known after the run.
    fn used(&self, loom: &Loom<'_>, options: &Options, stats: Option<&Stats>) -> Used {
        let lower = |name: String| name.to_lowercase();
        let placement = stats.map_or(options.placement, |s| s.placement);
        loom.used(loom.sized())
            .with("placement", lower(format!("{placement:?}")))
            .with("seam", lower(format!("{:?}", options.seam)))
            .with("region", stats.map_or(options.region, |s| Some(s.region)))
            .with("reach", stats.map_or(options.reach, |s| Some(s.reach)))
            .with("randomness", options.randomness)
            .with("variety", options.variety)
            .with("refine", options.refine)
            .with("patience", options.patience)
            .with("tries", options.tries)
            .with("turn", self.turn)
            .with("mirror", self.mirror)
    }
}

/// A rough upper bound of what the method holds: searches over sources and output, the graph, old seams.
fn estimate(sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
    let len = |domain: &Domain<2>| domain.shape.iter().fold(1, |n, &side| u64::saturating_mul(n, side.into()));
    let sources = sources.iter().map(len).fold(0, u64::saturating_add);
    let all = sources.saturating_add(len(&output));
    all.saturating_mul(128).saturating_add(all.saturating_mul(64 * channels as u64))
}

fn counts(stats: &Stats) -> serde_json::Value {
    json!({
        "periodicity": stats.periodicity,
        "patches": stats.patches,
        "refinements": stats.refinements,
        "improvements": stats.improvements,
        "cuts": stats.cuts,
        "cut_nodes": stats.cut_nodes,
        "energy": stats.energy,
    })
}

fn how(stats: &Stats) -> String {
    let placement = format!("{:?}", stats.placement).to_lowercase();
    let (patches, improvements) = (stats.patches, stats.improvements);
    format!("from {patches} patches and {improvements} refinements, {placement} placement")
}

/// Errors about exemplars name the file.
fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    let from_exemplar = matches!(error, Error::RegionExceedsExemplar { .. });
    let failure = Failure::from(error);
    if from_exemplar { loom.loaded.about(failure) } else { failure }
}
