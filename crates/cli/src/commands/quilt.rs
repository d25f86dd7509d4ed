//! `selvedge quilt`: image quilting. `[Efros01 2]`

use clap::Args;
use selvedge_core::{Bytes, Domain};
use selvedge_quilting::{Continuation, Error, Options, Plan, SearchBy, Stage, Stats, estimate};
use serde_json::{Value, json};

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, Planned};
use crate::repairing::Repairing;
use crate::setup::{OutputSize, Setup};
use crate::values::{Auto, auto, choices, name_of, parsed};
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
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = pixels())]
    block: Auto<u32>,
    /// Width of the overlap of blocks in pixels, or auto: a fourth of the block, of --paper a sixth.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = pixels())]
    overlap: Auto<u32>,
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
    /// Where blocks are looked for: everywhere, or, in exemplars from 384 px on, at a fraction of the size first.
    #[arg(long, value_enum, value_name = "WHERE", default_value_t = SearchArg::Auto)]
    search: SearchArg,
    /// The paper to the letter: --tolerance 0.1 --stage cut --continuation allow --spread 0 --search exact.
    #[arg(long, conflicts_with_all = ["tolerance", "stage", "continuation", "spread", "search"])]
    paper: bool,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
}

choices!(StageArg for Stage {
    /// Random blocks, tiled without overlap.
    Random,
    /// Overlapping blocks that agree with their neighbours.
    Overlap,
    /// The same with a minimum error boundary cut.
    Cut,
});

choices!(ContinuationArg for Continuation {
    /// Not if there is any other.
    Avoid,
    /// As the paper has it.
    Allow,
});

choices!(SearchArg for SearchBy {
    /// At a fraction of the size first where exemplars are large.
    Auto,
    /// At every place.
    Exact,
});

impl Method for Quilt {
    type Read = ();

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        self.options().validate()?;
        self.repairing.validate()?;
        let size = OutputSize::Exemplar(self.sizing);
        Ok(Setup { blending: self.blending, block: self.block.0, ..Setup::new("quilt", &self.weaving, size) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let method = Bytes(estimate(sources, channels, output, &self.options()));
        method + self.repairing.bytes(sources, channels, output)
    }

    fn read(&self, _: &mut Loom<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, (): ()) -> Result<Planned<'l>, Failure> {
        let (exemplars, session) = (&loom.loaded.exemplars, loom.session);
        let options = self.options();
        let plan = Plan::new(exemplars, loom.domain, &options, &session.run()).map_err(|e| failure(loom, e))?;
        // What --paper stands for is told, too.
        let used = loom
            .used()
            .set("block", plan.block())
            .set("overlap", plan.overlap())
            .set("tolerance", options.tolerance)
            .set("stage", name_of(options.stage))
            .set("continuation", name_of(options.continuation))
            .set("spread", options.spread);
        // Small ones are searched alike.
        let exact = options.search == SearchBy::Exact && 0 < plan.halvings();
        let used = if exact { used.set("search", name_of(options.search)) } else { used.without("search") };
        let used = self.blending.used_if_any(self.repairing.used_if_any(used));
        Ok(Planned::new(used, format!("from blocks of {} px", plan.block()), move || {
            let woven = plan.weave(&session.run()).map_err(|e| failure(loom, e))?;
            let told = told(&woven.stats);
            self.repairing.outcome(session, exemplars, woven, (None, None), told)
        }))
    }
}

impl Quilt {
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
            search: self.search.into(),
            overlap_part: Options::default().overlap_part,
            ..options
        }
    }
}

/// What was done, as numbers and for people.
fn told(stats: &Stats) -> (Value, String) {
    let counts = json!({
        "blocks": stats.blocks,
        "candidates": stats.candidates,
        "overlap_error": stats.overlap_error,
        "cut_error": stats.cut_error,
    });
    let blocks = n("block", stats.blocks as usize);
    (counts, format!("from {blocks} of {} px, overlap {} px", stats.block, stats.overlap))
}

/// A length in pixels, or a choice by the program.
pub(super) fn pixels() -> impl Fn(&str) -> Result<Auto<u32>, Wrong> + Clone {
    auto("number of pixels", "write a number of pixels, or auto", parsed)
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
