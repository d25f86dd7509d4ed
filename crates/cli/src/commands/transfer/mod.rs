//! `selvedge transfer`: texture transfer. `[Efros01 3]`

mod by_cms;
mod followed;

use std::borrow::Cow;

use clap::{Args, ValueEnum};
use selvedge_core::{Bytes, Domain, Guide};
use selvedge_quilting::{PassStats, SearchBy, TransferOptions, TransferPlan, TransferStats};
use serde_json::json;

use self::followed::FollowArgs;
use crate::blending::Blending;
use crate::commands::quilt::{SearchArg, failure};
use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::{Following, option};
use crate::outcome::Outcome;
use crate::session::Session;
use crate::setup::Setup;
use crate::sweep::Sweep;
use crate::used::Used;
use crate::values::{Auto, counts, pixels};
use crate::weaving::Weaving;

/// Options of `transfer`.
#[derive(Args, Debug)]
#[command(mut_args(option("constraint_weight", |arg| arg
    .help("With --method cms, how much what is followed counts against seams"))))]
#[command(mut_args(option("neighborhood", |arg| arg
    .help("With --method cms, half the side of the neighborhoods that are compared, in pixels"))))]
pub(crate) struct Transfer {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    followed: FollowArgs,
    /// By which method.
    #[arg(long, value_name = "METHOD", default_value = "quilt")]
    method: By,
    #[command(flatten)]
    following: Following,
    /// With --method cms, make a run for each of several K, each of several N, or each pair of both, and show them by
    /// --sheet, a row for each K, with K/N below each: K=.05,.2,1,5 N=1,3,5,9. An n in braces in names is the run's
    /// number.
    #[arg(long, num_args = 1..=2, value_name = "LIST")]
    sweep: Vec<Sweep>,
    /// Side of the first pass's blocks in pixels, or auto; each pass takes them smaller by a third. auto is a ninth of
    /// the target's shorter side, 12 to 36; where small features such as eyes are lost, give about half of that.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = pixels())]
    block: Auto<u32>,
    /// Passes over the output; the paper took 3 to 5.
    #[arg(long, value_name = "N", default_value_t = TransferOptions::default().passes)]
    passes: u32,
    /// Share of the texture, 0 to 1, in every pass. Default: from 0.1 in the first to 0.9 in the last.
    #[arg(long, value_name = "A")]
    alpha: Option<f64>,
    /// Draw among blocks whose error is up to this fraction above the least.
    #[arg(long, value_name = "T", default_value_t = TransferOptions::default().tolerance)]
    tolerance: f64,
    /// How evenly the exemplar is used: 0 takes whatever fits best. Default: 0.1 by blocks, and 0.05 by labels, of
    /// which each sample is counted.
    #[arg(long, value_name = "S")]
    spread: Option<f64>,
    /// Where blocks are looked for: everywhere, or, in exemplars from 384 px on, at a fraction of the size first.
    #[arg(long, value_enum, value_name = "WHERE", default_value_t = SearchArg::Auto)]
    search: SearchArg,
    /// The paper to the letter: --tolerance 0.1 --spread 0 --search exact.
    #[arg(long)]
    paper: bool,
    #[command(flatten)]
    blending: Blending,
}

/// Options of one method alone.
const OF_BLOCKS: [&str; 5] = ["block", "passes", "alpha", "tolerance", "search"];
const OF_LABELS: [&str; 2] = ["constraint-weight", "neighborhood"];

/// What a picture is put together from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// Blocks, in several passes of smaller and smaller ones.
    Quilt,
    /// Labels of any shape that lower one energy, where it is highest; exemplars are turned by quarter turns as well.
    Cms,
}

impl Method for Transfer {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.check_method(session)?;
        self.options().validate()?;
        self.blending.validate()?;
        let setup = self.followed.setup("transfer", &self.weaving, session)?;
        let setup = Setup { blending: self.blending, ..setup };
        match self.method {
            By::Quilt => Ok(Setup { block: self.block.0, ..setup }),
            By::Cms => self.setup_labels(setup),
        }
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        match self.method {
            By::Quilt => self.followed.bytes(sources, output, Bytes(0)),
            By::Cms => self.bytes_of_labels(sources, channels, output, false),
        }
    }

    fn masking(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let of = |holes| match self.method {
            By::Quilt => Bytes(0),
            By::Cms => self.bytes_of_labels(sources, channels, output, holes),
        };
        Bytes(of(true).0.saturating_sub(of(false).0))
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let guide = self.followed.guide(loom, &self.weaving)?;
        self.admit_holes(loom, &[&guide])?;
        let loom = &*loom;
        match self.method {
            By::Quilt => self.plan_blocks(loom, guide),
            By::Cms => self.plan_labels(loom, guide),
        }
    }
}

impl Transfer {
    /// Refuses options of the other method.
    fn check_method(&self, session: &Session<'_>) -> Result<(), Failure> {
        let typed = |options: &[&str]| session.first_typed(options);
        let (option, of, has_none, remedy) = match self.method {
            By::Quilt => (typed(&OF_LABELS), "labels", "quilt", "cms"),
            By::Cms => (typed(&["paper"]).or_else(|| typed(&OF_BLOCKS)), "blocks", "cms", "quilt"),
        };
        let Some(option) = option else { return Ok(()) };
        let what = format!("{option} is of {of}, and --method {has_none} has none");
        Err(Failure::new(2, what).remedy(format!("leave it out, or use --method {remedy}")))
    }

    fn plan_blocks<'l>(&'l self, loom: &'l Loom<'_>, guide: Guide<2>) -> Result<PlannedRun<'l>, Failure> {
        let (exemplars, run, options) = (&loom.loaded.exemplars, loom.session.run(), self.options());
        if guide.exemplars().validity() != exemplars.validity() {
            let what = "a picture of --guide under an exemplar is transparent in places, which blocks cannot leave out";
            return Err(Failure::new(3, what).remedy("use --method cms, or give a --mask that leaves them out"));
        }
        let plan = TransferPlan::new(exemplars, Cow::Owned(guide), &options, &run).map_err(|e| failure(loom, e))?;
        let (sources, _) = loom.sources();
        let needed = loom.admit(&|output| self.followed.bytes(&sources, output, plan.bytes_of(output)))?;
        let sides: Vec<u32> = plan.blocks().collect();
        let used = self.followed.used(loom).set("block", sides.first().copied()).set("spread", options.spread);
        let used = OF_LABELS.into_iter().fold(used.without("method"), Used::without);
        // Small ones are searched alike.
        let exact = options.search == SearchBy::Exact && 0 < plan.halvings();
        let used = if exact { used } else { used.without("search") };
        let blocks = plan.total();
        let how = how(blocks, &sides);
        Ok(PlannedRun::new(used, how.clone(), move || {
            let woven = plan.weave(&run).map_err(|e| failure(loom, e))?;
            Ok(Outcome::new(Box::new(woven.result), woven.complete, counts(&woven.stats), how))
        })
        .needing(needed)
        .counting(json!({ "blocks": blocks })))
    }

    fn options(&self) -> TransferOptions {
        TransferOptions {
            block: self.block.0,
            passes: self.passes,
            alpha: self.alpha,
            tolerance: self.tolerance,
            spread: self.spread.unwrap_or(TransferOptions::default().spread),
            search: self.search.into(),
        }
    }
}

fn counts(stats: &TransferStats) -> serde_json::Value {
    let pass = |p: &PassStats| counts!(p, block, overlap, alpha, blocks, candidates, cut_error, guide_error);
    json!({ "passes": stats.passes.iter().map(pass).collect::<Vec<_>>() })
}

fn how(blocks: u64, sides: &[u32]) -> String {
    let sides: Vec<String> = sides.iter().map(u32::to_string).collect();
    format!("from {blocks} blocks of {} px", sides.join(", "))
}
