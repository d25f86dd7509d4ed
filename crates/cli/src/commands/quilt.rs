//! `selvedge quilt`: image quilting. `[Efros01 2]`

use clap::{Args, ValueEnum};
use selvedge_core::Domain;
use selvedge_quilting::{Continuation, Error, Options, Plan, Stage, Stats, estimate};
use serde_json::json;

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::{Loom, Outcome};
use crate::method::{Method, OutputSize};
use crate::repairing::{self, Repairing, with_repair};
use crate::used::Used;
use crate::weaving::{Sizing, Weaving};
use crate::wrong::Wrong;

/// Options of `quilt`.
#[derive(Args, Debug)]
pub(crate) struct Quilt {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// Side of the blocks in pixels, or auto; it should hold the largest structure of the texture.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = auto_or_number)]
    block: Auto,
    /// Width of the overlap of blocks in pixels, or auto: a fourth of the block, of --paper a sixth.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = auto_or_number)]
    overlap: Auto,
    /// Draw among blocks whose overlap error is up to this fraction above the least, both as --spread makes them count.
    #[arg(long, value_name = "T", default_value_t = 0.1)]
    tolerance: f64,
    /// How far to go: random blocks, agreeing blocks, or agreeing blocks with cut edges.
    #[arg(long, value_enum, value_name = "STAGE", default_value_t = StageArg::Cut)]
    stage: StageArg,
    /// Whether blocks may continue their neighbours verbatim.
    #[arg(long, value_enum, value_name = "WHETHER", default_value_t = ContinuationArg::Allow)]
    continuation: ContinuationArg,
    /// How evenly the exemplar is used: 0 takes whatever fits best.
    #[arg(long, value_name = "S", default_value_t = Options::default().spread)]
    spread: f64,
    /// The paper to the letter: --tolerance 0.1 --stage cut --continuation allow --spread 0.
    #[arg(long, conflicts_with_all = ["tolerance", "stage", "continuation", "spread"])]
    paper: bool,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
}

/// A number, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Auto(pub(super) Option<u32>);

pub(super) fn auto_or_number(text: &str) -> Result<Auto, Wrong> {
    match text {
        "auto" => Ok(Auto(None)),
        _ => text
            .parse()
            .map(|n| Auto(Some(n)))
            .map_err(|_| Wrong::new(format!("'{text}' is no number of pixels"), "write a number of pixels, or auto")),
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StageArg {
    /// Random blocks, tiled without overlap.
    Random,
    /// Overlapping blocks that agree with their neighbours.
    Overlap,
    /// The same with a minimum error boundary cut.
    Cut,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ContinuationArg {
    /// Not if there is any other.
    Avoid,
    /// As the paper has it.
    Allow,
}

impl From<StageArg> for Stage {
    fn from(stage: StageArg) -> Self {
        match stage {
            StageArg::Random => Self::Random,
            StageArg::Overlap => Self::Overlap,
            StageArg::Cut => Self::Cut,
        }
    }
}

impl From<ContinuationArg> for Continuation {
    fn from(continuation: ContinuationArg) -> Self {
        match continuation {
            ContinuationArg::Avoid => Self::Avoid,
            ContinuationArg::Allow => Self::Allow,
        }
    }
}

impl Method for Quilt {
    type Read = ();

    fn name(&self) -> &'static str {
        "quilt"
    }

    fn weaving(&self) -> &Weaving {
        &self.weaving
    }

    fn validate(&self) -> Result<(), Failure> {
        self.options().validate()?;
        self.repairing.validate()
    }

    fn blending(&self) -> Blending {
        self.blending
    }

    fn size(&self) -> OutputSize<'_> {
        OutputSize::Exemplar(self.sizing)
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        let method = estimate(sources, channels, output, &self.options());
        method.saturating_add(self.repairing.bytes(sources, channels, output))
    }

    fn read(&self, _: &mut Loom<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn plan(&self, loom: &Loom<'_>, (): ()) -> Result<(Used, String), Failure> {
        let plan = self.planned(loom)?;
        Ok((self.used(loom, &plan), format!("from blocks of {} px", plan.block())))
    }

    fn weave(&self, loom: &Loom<'_>, (): ()) -> Result<Outcome, Failure> {
        let plan = self.planned(loom)?;
        let mut woven = plan.weave(&loom.session.run()).map_err(|e| failure(loom, e))?;
        let repair = self.repairing.mend(loom.session, &loom.loaded.exemplars, &mut woven, (None, None))?;
        Ok(Outcome {
            woven: Box::new(woven.result),
            complete: woven.complete,
            kept: None,
            options: self.used(loom, &plan),
            stats: with_repair(counts(&woven.stats), repair.as_ref()),
            how: how(&woven.stats) + &repairing::how(repair.as_ref()),
            course: None,
        })
    }
}

impl Quilt {
    fn planned<'l>(&self, loom: &'l Loom<'_>) -> Result<Plan<'l>, Failure> {
        let plan = Plan::new(&loom.loaded.exemplars, loom.domain, &self.options(), &loom.session.run());
        plan.map_err(|e| failure(loom, e))
    }

    /// The options as used: what was left to the program, and what --paper stands for.
    fn used(&self, loom: &Loom<'_>, plan: &Plan<'_>) -> Used {
        let (options, lower) = (self.options(), |name: String| name.to_lowercase());
        let used = loom
            .used()
            .set("block", plan.block())
            .set("overlap", plan.overlap())
            .set("tolerance", options.tolerance)
            .set("stage", lower(format!("{:?}", options.stage)))
            .set("continuation", lower(format!("{:?}", options.continuation)))
            .set("spread", options.spread);
        self.blending.used_if_any(self.repairing.used_if_any(used))
    }

    fn options(&self) -> Options {
        let options = Options { block: self.block.0, overlap: self.overlap.0, ..Options::paper() };
        if self.paper {
            return options;
        }
        Options {
            tolerance: self.tolerance,
            stage: self.stage.into(),
            continuation: self.continuation.into(),
            spread: self.spread,
            overlap_part: Options::default().overlap_part,
            ..options
        }
    }
}

fn counts(stats: &Stats) -> serde_json::Value {
    json!({
        "blocks": stats.blocks,
        "candidates": stats.candidates,
        "overlap_error": stats.overlap_error,
        "cut_error": stats.cut_error,
    })
}

fn how(stats: &Stats) -> String {
    format!("from {} of {} px, overlap {} px", n("block", stats.blocks as usize), stats.block, stats.overlap)
}

/// Errors about exemplars name the file, and options by their flags.
pub(super) fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    let remedy = match &error {
        Error::BlockExceedsExemplar { limit, .. } => format!("use --block {limit} or a larger exemplar"),
        Error::Masked { .. } => "use a smaller --block or mask less".to_owned(),
        _ => return Failure::from(error),
    };
    loom.loaded.about(Failure::from(error).remedy(remedy))
}
