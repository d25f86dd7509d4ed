//! `selvedge quilt`: image quilting. `[Efros01 2]`

use clap::Args;
use selvedge_core::{Bytes, Domain};
use selvedge_quilting::{Continuation, Error, Options, Plan, SearchBy, Stage, Stats, measuring};
use serde_json::{Value, json};

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::Spread;
use crate::output_size::OutputSize;
use crate::repairing::Repairing;
use crate::session::Session;
use crate::setup::Setup;
use crate::values::{Auto, choices, counts, pixels};
use crate::weaving::{Sizing, Weaving};

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
    #[command(flatten)]
    spread: Spread,
    /// Where blocks are looked for: everywhere, or, in exemplars from 384 px on, at a fraction of the size first.
    #[arg(long, value_enum, value_name = "WHERE", default_value_t = SearchArg::Auto)]
    search: SearchArg,
    /// The paper to the letter: --tolerance 0.1 --stage cut --continuation allow --spread 0 --search exact.
    #[arg(long)]
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
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.options().validate()?;
        Ok(Setup {
            repairing: self.repairing,
            blending: self.blending,
            block: self.block.0,
            ..Setup::new("quilt", &self.weaving, OutputSize::Exemplar(self.sizing))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.repairing.bytes(sources, channels, output)
    }

    fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        measuring(sources, channels, masked, &self.options())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let (loom, exemplars, session) = (&*loom, &loom.loaded.exemplars, loom.session);
        let options = self.options();
        let plan = Plan::new(exemplars, loom.domain, &options, &session.run()).map_err(|e| failure(loom, e))?;
        let needed = self.admit(loom, &|output| plan.bytes_of(output))?;
        let used = loom.used().set("block", plan.block()).set("overlap", plan.overlap());
        // Small ones are searched alike.
        let exact = options.search == SearchBy::Exact && 0 < plan.halvings();
        let used = if exact { used } else { used.without("search") };
        let blocks = plan.blocks();
        let how = format!("from {} of {} px", n("block", blocks as usize), plan.block());
        Ok(PlannedRun::new(used, how, move || {
            let woven = plan.weave(&session.run()).map_err(|e| failure(loom, e))?;
            let told = told(&woven.stats);
            self.repairing.outcome(session, exemplars, woven, (None, None), told, loom.is_explained())
        })
        .needing(needed)
        .counting(json!({ "blocks": blocks })))
    }
}

impl Quilt {
    fn options(&self) -> Options {
        let usual = if self.paper { Options::paper() } else { Options::default() };
        Options {
            block: self.block.0,
            overlap: self.overlap.0,
            tolerance: self.tolerance,
            stage: self.stage.into(),
            continuation: self.continuation.into(),
            spread: self.spread.spread,
            search: self.search.into(),
            ..usual
        }
    }
}

/// What was done, as numbers and for people.
fn told(stats: &Stats) -> (Value, String) {
    let counts = counts!(stats, blocks, candidates, overlap_error, cut_error);
    let blocks = n("block", stats.blocks as usize);
    (counts, format!("from {blocks} of {} px, overlap {} px", stats.block, stats.overlap))
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
