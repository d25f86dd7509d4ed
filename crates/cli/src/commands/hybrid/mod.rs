//! `selvedge hybrid`: adaptive and hybrid synthesis. `[Ding 3]`

mod choices;

use std::path::PathBuf;

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Grid, Role, Start, Transform};
use selvedge_hybrid::{Error, Options, Plan, Stats, estimate, weighed};
use serde_json::json;

use self::choices::{Block, LayoutArg, ResynthesizeArg, SearchArg, block, error, typed};
use super::graphcut::start::{Begun, StartArgs};
use super::quilt::ContinuationArg;
use crate::backdrop::Backdrop;
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::{Loom, Outcome};
use crate::method::{Method, OutputSize};
use crate::repairing::{self, Repairing, with_repair};
use crate::report::Done;
use crate::session::Session;
use crate::used::Used;
use crate::weaving::{Sizing, Weaving};

/// Options of `hybrid`.
#[derive(Args, Debug)]
pub(crate) struct Hybrid {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// Size of the first blocks in pixels, powers of two: 32, 64x32 (width by height), or auto. They are split where they
    /// do not fit.
    #[arg(long, value_name = "SIZE|auto", default_value = "auto", value_parser = block)]
    block: Block,
    /// Split blocks whose overlap has a larger error: from 0 to 1, a part of the error of random pixels such as 20%, or auto:
    /// 75%.
    #[arg(long, value_name = "D|P%|auto", default_value = "auto", value_parser = error)]
    max_error: choices::Error,
    /// Re-synthesise pixels with a larger error, written in the same way; auto: 12%.
    #[arg(long, value_name = "D|P%|auto", default_value = "auto", value_parser = error)]
    pixel_error: choices::Error,
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
    /// The paper to the letter: --block 32 --max-error 0.04 --pixel-error 0.02, where they are not given, and --search exact
    /// --resynthesize overlap --tolerance 0 --spread 0 --continuation avoid --circular.
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
    begun: &'a Begun<'a>,
    domain: &'a dyn Fn(&[Domain<2>]) -> Result<Domain<2>, Failure>,
}

impl Method for Job<'_> {
    type Read = Start<2>;

    fn name(&self) -> &'static str {
        "hybrid"
    }

    fn weaving(&self) -> &Weaving {
        &self.args.weaving
    }

    fn validate(&self) -> Result<(), Failure> {
        self.args.options().validate()?;
        self.args.repairing.validate()
    }

    fn blending(&self) -> Blending {
        self.args.blending
    }

    fn keeps(&self) -> bool {
        true
    }

    fn size(&self) -> OutputSize<'_> {
        OutputSize::Start(self.domain)
    }

    fn others(&self) -> Vec<PathBuf> {
        self.args.start.files()
    }

    fn transforms(&self) -> Vec<Transform> {
        let turns = if self.args.turn { 0..4 } else { 0..1 };
        let mirrors = if self.args.mirror { &[false, true][..] } else { &[false] };
        let exact = |quarter_turns| mirrors.iter().map(move |&mirror| Transform::Exact { quarter_turns, mirror });
        turns.flat_map(exact).collect()
    }

    fn backdrop(&self) -> Option<Backdrop<'_>> {
        self.args.start.backdrop()
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        let method = Bytes(estimate(sources, channels, output, &self.args.options()));
        let field = if self.backdrop().is_some() { Bytes::of_samples(output, 8) } else { Bytes(0) };
        let repair = Bytes(self.args.repairing.bytes(sources, channels, output));
        (method.then(repair) + field).0
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        let (map, fixed) = self.begun.stand(loom)?;
        // A picture stands where it is, and nowhere else.
        let others = loom.loaded.exemplars.sources().len() - 1;
        let sources = self.backdrop().map(|_| Grid::try_filled(loom.domain, 1, (1 << others) - 1)).transpose()?;
        Ok(Start { map, fixed, sources })
    }

    fn plan(&self, loom: &Loom<'_>, _: Start<2>) -> Result<(Used, String), Failure> {
        let plan = self.args.planned(loom)?;
        Ok((self.args.used(loom, &plan), format!("from blocks of {} px", typed(plan.block()))))
    }

    fn weave(&self, loom: &Loom<'_>, start: Start<2>) -> Result<Outcome, Failure> {
        let (args, plan) = (self.args, self.args.planned(loom)?);
        let (kept, sources) = (start.fixed.clone(), start.sources.clone());
        let whole = start.map.holes() == 0;
        let mut woven = plan.weave_from(start, &loom.session.run()).map_err(|e| failure(loom, e))?;
        let repair = args.repairing.mend(loom.session, &exemplars(loom)?, &mut woven, (kept.as_ref(), sources))?;
        let how = match (&repair, whole) {
            (None, true) => "as it was: nothing is missing, and no --fixed makes holes".to_owned(),
            (Some(_), true) => format!("as it was{}", repairing::how(repair.as_ref())),
            _ => how(&woven.stats) + &repairing::how(repair.as_ref()),
        };
        Ok(Outcome {
            woven: Box::new(woven.result),
            complete: woven.complete,
            kept,
            options: args.used(loom, &plan),
            stats: with_repair(counts(&woven.stats), repair.as_ref()),
            how,
            course: None,
        })
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
        let begun = self.start.begin(session)?;
        let domain = |exemplars: &[Domain<2>]| {
            let (first, sizing) = (exemplars[0].shape, self.sizing);
            begun.domain(exemplars, sizing.typed(first), self.weaving.tiled(sizing.shape(first)))
        };
        Job { args: self, begun: &begun, domain: &domain }.run(session)
    }

    fn planned(&self, loom: &Loom<'_>) -> Result<Plan, Failure> {
        let plan = Plan::new(&exemplars(loom)?, loom.domain, &self.options(), &loom.session.run());
        plan.map_err(|e| failure(loom, e))
    }

    /// The options as used: what was left to the program, and what --paper stands for.
    fn used(&self, loom: &Loom<'_>, plan: &Plan) -> Used {
        let (options, lower) = (self.options(), |name: String| name.to_lowercase());
        let used = loom
            .used()
            .set("block", typed(plan.block()))
            .set("max-error", choices::Error(options.max_error).to_string())
            .set("pixel-error", choices::Error(options.pixel_error).to_string())
            .set("search", lower(format!("{:?}", options.search)))
            .set("resynthesize", lower(format!("{:?}", options.resynthesize)))
            .set("tolerance", options.tolerance)
            .set("spread", options.spread)
            .set("continuation", lower(format!("{:?}", options.continuation)))
            .set("circular", options.circular);
        let used = if self.start.is_blended_in() { used } else { used.without("blend-in") };
        self.blending.used_if_any(self.repairing.used_if_any(used))
    }

    fn options(&self) -> Options {
        let typed = Options {
            block: self.block.0,
            max_error: self.max_error.0,
            pixel_error: self.pixel_error.0,
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
        let paper = Options::paper();
        let given =
            |one: choices::Error, of_paper| if one.0 == Options::default().max_error { of_paper } else { one.0 };
        Options {
            block: typed.block.or(paper.block),
            max_error: given(self.max_error, paper.max_error),
            pixel_error: given(self.pixel_error, paper.pixel_error),
            k: typed.k,
            layout: typed.layout,
            ..paper
        }
    }
}

/// The exemplars, their colours weighed as the eye does.
fn exemplars(loom: &Loom<'_>) -> Result<Exemplars<2>, Failure> {
    let exemplars = &loom.loaded.exemplars;
    let in_color = loom.loaded.payload.iter().all(|plane| plane.role == Role::Color);
    Ok(if in_color { weighed(exemplars)? } else { exemplars.clone() })
}

fn counts(stats: &Stats) -> serde_json::Value {
    let of = |level: &selvedge_hybrid::Level| json!({ "blocks": level.blocks, "splits": level.splits, "error": level.error });
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

fn how(stats: &Stats) -> String {
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
