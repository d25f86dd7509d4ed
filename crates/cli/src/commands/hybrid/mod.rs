//! `selvedge hybrid`: adaptive and hybrid synthesis. `[Ding 3]`

mod choices;

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Role, Start};
use selvedge_hybrid::{Error, Options, Plan, Stats, estimate, weighed};
use serde_json::json;

use self::choices::{LayoutArg, ResynthesizeArg, SearchArg, error, typed};
use super::quilt::ContinuationArg;
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::ground::{Ground, StartArgs};
use crate::loom::Loom;
use crate::method::{Method, Planned};
use crate::repairing::Repairing;
use crate::report::Done;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::used::Used;
use crate::values::{Auto, auto, name_of, orientations, sides};
use crate::weaving::{Sizing, Weaving};

/// Options of `hybrid`.
#[derive(Args, Debug)]
pub(crate) struct Hybrid {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// Size of the first blocks in pixels, powers of two: 32, 64x32 (width by height), or auto. They are split where
    /// they do not fit. Default: auto.
    #[arg(long, value_name = "SIZE|auto",
        value_parser = auto("block", "write 32, 64x32 (width by height), or auto", sides))]
    block: Option<Auto<[u32; 2]>>,
    /// Split blocks whose overlap has a larger error: from 0 to 1, a part of the error of random pixels such as 20%, or
    /// auto: 75%. Default: auto.
    #[arg(long, value_name = "D|P%|auto", value_parser = error)]
    max_error: Option<choices::Error>,
    /// Re-synthesise pixels with a larger error, written in the same way; auto: 12%.
    /// Default: auto.
    #[arg(long, value_name = "D|P%|auto", value_parser = error)]
    pixel_error: Option<choices::Error>,
    /// Blocks are cut where their error is below this part of --max-error, else re-synthesised: 1 never, 0 always.
    #[arg(short, long, value_name = "K", default_value_t = Options::default().k)]
    k: f64,
    /// How the first blocks lie.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = LayoutArg::Grid)]
    layout: LayoutArg,
    /// Which pixels of the exemplar are tried where pixels are re-synthesised.
    #[arg(long, value_enum, value_name = "WHICH", default_value_t = SearchArg::Coherent)]
    search: SearchArg,
    /// What is re-synthesised of a block that fits badly.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = ResynthesizeArg::Seam)]
    resynthesize: ResynthesizeArg,
    /// Draw among blocks whose error is up to this fraction above the least, both as --spread makes them count.
    #[arg(long, value_name = "T", default_value_t = Options::default().tolerance)]
    tolerance: f64,
    /// How evenly the exemplar is used: 0 takes whatever fits best.
    #[arg(long, value_name = "S", default_value_t = Options::default().spread)]
    spread: f64,
    /// Whether the first blocks may continue what is around them verbatim.
    #[arg(long, value_enum, value_name = "WHETHER", default_value_t = ContinuationArg::Allow)]
    continuation: ContinuationArg,
    /// Let blocks reach around the borders of exemplars, which should tile.
    #[arg(long)]
    circular: bool,
    /// The paper to the letter: --block 32 --max-error 0.04 --pixel-error 0.02, where they are not given, and --search
    /// exact --resynthesize overlap --tolerance 0 --spread 0 --continuation avoid --circular.
    #[arg(long, conflicts_with_all = ["tolerance", "spread", "search", "resynthesize", "continuation", "circular"])]
    paper: bool,
    /// Turn exemplars by quarter turns as well.
    #[arg(long)]
    turn: bool,
    /// Mirror exemplars as well.
    #[arg(long)]
    mirror: bool,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
}

/// A run whose map to begin with was read.
struct Job<'a> {
    args: &'a Hybrid,
    ground: Ground,
}

impl Method for Job<'_> {
    type Read = Start<2>;

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        let Hybrid { weaving, sizing, start, blending, .. } = self.args;
        Ok(Setup {
            others: start.files(),
            transforms: orientations(self.args.turn, self.args.mirror),
            backdrop: start.backdrop(),
            blending: *blending,
            keeps: true,
            ..Setup::new("hybrid", weaving, OutputSize::Ground(&self.ground, *sizing))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let method = Bytes(estimate(sources, channels, output, &self.args.options()));
        let repair = self.args.repairing().bytes(sources, channels, output);
        method.then(repair) + self.args.start.bytes(output)
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        self.ground.start(loom)
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, start: Start<2>) -> Result<Planned<'l>, Failure> {
        let (args, session, exemplars) = (self.args, loom.session, exemplars(loom)?);
        let plan = Plan::new(&exemplars, loom.domain, &args.options(), &session.run()).map_err(|e| failure(loom, e))?;
        let (used, how) = (args.used(loom, &plan), format!("from blocks of {} px", typed(plan.block())));
        Ok(Planned::new(used, how, move || {
            let (kept, sources, whole) = (start.fixed.clone(), start.sources.clone(), start.map.holes() == 0);
            let woven = plan.weave_from(start, &session.run()).map_err(|e| failure(loom, e))?;
            let how = match (whole, args.repairing.is_on()) {
                (true, true) => "as it was".to_owned(),
                (true, false) => "as it was: nothing is missing, and no --fixed makes holes".to_owned(),
                (false, _) => how_woven(&woven.stats),
            };
            let told = (counts(&woven.stats), how);
            args.repairing().outcome(session, &exemplars, woven, (kept, sources), told)
        }))
    }
}

impl Hybrid {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        self.options().validate()?;
        self.blending.validate()?;
        self.repairing.validate()?;
        let sources =
            self.weaving.input.exemplars.len() * if self.turn { 4 } else { 1 } * if self.mirror { 2 } else { 1 };
        if self.start.backdrop().is_some() && 63 < sources {
            let what = format!("{sources} exemplars and orientations are more than --over tells apart");
            return Err(Failure::new(2, what).remedy("use at most 63"));
        }
        Job { args: self, ground: self.start.ground(session)? }.run(session)
    }

    /// The options as used: what was left to the program, and what --paper stands for.
    fn used(&self, loom: &Loom<'_>, plan: &Plan) -> Used {
        let options = self.options();
        let used = loom
            .used()
            .set("block", typed(plan.block()))
            .set("max-error", choices::Error(options.max_error).to_string())
            .set("pixel-error", choices::Error(options.pixel_error).to_string())
            .set("search", name_of(options.search))
            .set("resynthesize", name_of(options.resynthesize))
            .set("tolerance", options.tolerance)
            .set("spread", options.spread)
            .set("continuation", name_of(options.continuation))
            .set("circular", options.circular);
        self.blending.used_if_any(self.repairing.used_if_any(self.start.used(used)))
    }

    fn options(&self) -> Options {
        let usual = if self.paper { Options::paper() } else { Options::default() };
        let typed = Options {
            block: self.block.map_or(usual.block, |block| block.0),
            max_error: self.max_error.map_or(usual.max_error, |error| error.0),
            pixel_error: self.pixel_error.map_or(usual.pixel_error, |error| error.0),
            k: self.k,
            layout: self.layout.into(),
            search: self.search.into(),
            resynthesize: self.resynthesize.into(),
            tolerance: self.tolerance,
            spread: self.spread,
            continuation: self.continuation.into(),
            circular: self.circular,
        };
        if !self.paper {
            return typed;
        }
        Options {
            block: typed.block,
            max_error: typed.max_error,
            pixel_error: typed.pixel_error,
            k: typed.k,
            layout: typed.layout,
            ..usual
        }
    }

    /// What is no seam to the blocks is none to repair.
    fn repairing(&self) -> Repairing {
        self.repairing.around(self.options().circular)
    }
}

/// The exemplars, their colours weighed as the eye does.
fn exemplars(loom: &Loom<'_>) -> Result<Exemplars<2>, Failure> {
    let exemplars = &loom.loaded.exemplars;
    let in_color = loom.loaded.payload.iter().all(|plane| plane.role == Role::Color);
    Ok(if in_color { weighed(exemplars)? } else { exemplars.clone() })
}

fn counts(stats: &Stats) -> serde_json::Value {
    let of = |l: &selvedge_hybrid::Level| json!({ "blocks": l.blocks, "splits": l.splits, "error": l.error });
    json!({
        "levels": stats.levels.iter().map(of).collect::<Vec<_>>(),
        "max_error": stats.max_error,
        "pixel_error": stats.pixel_error,
        "unsplittable": stats.unsplittable,
        "cuts": stats.cuts,
        "resyntheses": stats.resyntheses,
        "pixels": stats.pixels,
    })
}

fn how_woven(stats: &Stats) -> String {
    let blocks: u64 = stats.levels.iter().map(|level| level.blocks - level.splits).sum();
    let (blocks, pixels) = (n("block", blocks as usize), n("pixel", stats.pixels as usize));
    format!("from {blocks} of {} px and smaller, {pixels} re-synthesised", typed(stats.block))
}

/// Errors about exemplars name the file, and options by their flags.
fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    match &error {
        Error::BlockExceedsExemplar { limit, .. } => {
            let remedy = format!("use --block {limit} or a larger exemplar");
            loom.loaded.about(Failure::from(error).remedy(remedy))
        }
        _ => Failure::from(error),
    }
}
