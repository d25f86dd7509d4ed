//! `selvedge quilt`: image quilting. `[Efros01 2]`

use clap::{Args, ValueEnum};
use selvedge_core::Transform;
use selvedge_quilting::{Continuation, Error, Options, Stage, Stats, estimate};
use serde_json::json;

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::report::Done;
use crate::session::Session;
use crate::used::Used;
use crate::weaving::{Loom, Outcome, Plan, Sizing, Weaving};
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
enum ContinuationArg {
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

impl Quilt {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let options = self.options();
        options.validate()?;
        self.blending.validate()?;
        let loom = self.weaving.begin(
            session,
            &Plan {
                command: "quilt",
                others: Vec::new(),
                domain: &|exemplars| Ok(self.weaving.tiled(self.sizing.shape(exemplars[0].shape))),
                transforms: &[Transform::IDENTITY],
                backdrop: None,
                estimate: &|exemplars, channels, output| {
                    let method = estimate(exemplars, channels, output, &options);
                    method.saturating_add(self.blending.memory(output, channels + 1, false))
                },
            },
        )?;
        let exemplars = &loom.loaded.exemplars;
        let plan = selvedge_quilting::Plan::new(exemplars, loom.domain, &options, &session.run());
        let plan = plan.map_err(|e| failure(&loom, e))?;
        if loom.is_dry() {
            let used = self.blending.used_if_any(used(&loom, &options, &plan));
            let how = format!("from blocks of {} px", plan.block());
            return Ok(loom.would(used, &how));
        }
        let woven = plan.weave(&session.run()).map_err(|e| failure(&loom, e))?;
        let stats = woven.stats;
        let outcome = Outcome {
            woven: Box::new(woven.result),
            complete: woven.complete,
            blending: self.blending,
            kept: None,
            options: self.blending.used_if_any(used(&loom, &options, &plan)),
            stats: counts(&stats),
            how: how(&stats),
            course: None,
        };
        loom.finish(outcome)
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

/// The options as used.
fn used(loom: &Loom<'_>, options: &Options, plan: &selvedge_quilting::Plan<'_>) -> Used {
    let lower = |name: String| name.to_lowercase();
    loom.used(loom.sized())
        .with("block", plan.block())
        .with("overlap", plan.overlap())
        .with("tolerance", options.tolerance)
        .with("stage", lower(format!("{:?}", options.stage)))
        .with("continuation", lower(format!("{:?}", options.continuation)))
        .with("spread", options.spread)
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
