//! `selvedge hybrid`: adaptive and hybrid synthesis. `[Ding 3]`

mod choices;
mod splits;
mod told;

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Role};
use selvedge_hybrid::{Options, Plan, measuring, weighed};
use serde_json::json;

use self::choices::{LayoutArg, ResynthesizeArg, SearchArg, SplitArg, error, typed};
use super::quilt::ContinuationArg;
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::ground::StartArgs;
use crate::inputs::Input;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::{Spread, Turning, option};
use crate::output_size::OutputSize;
use crate::pairs::{GuidanceArgs, Pair};
use crate::repairing::Repairing;
use crate::session::Session;
use crate::setup::Setup;
use crate::values::{Auto, auto, sides};
use crate::weaving::{Sizing, Weaving};

const REPAIR: &str = "Repair seams that show: choose the pixels around them anew, as long as all seams become cheaper. \
    Default, but where something was there before";
const RADIUS: &str = "How far around bad seams pixels are chosen anew, 1 to 64; 0 repairs none. Default: 2";

/// Options of `hybrid`.
#[derive(Args, Debug)]
#[command(mut_args(option("repair", |arg| arg.help(REPAIR))))]
#[command(mut_args(option("radius", |arg| arg.help(RADIUS))))]
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
    /// Overlap of the first blocks, outside of them, as a part of their sides, 0.05 to 1. Split ones have half of it,
    /// and none less than 3 px. Default: a third.
    #[arg(long, value_name = "PART")]
    overlap: Option<f64>,
    /// Split blocks whose overlap has a larger error: from 0 to 1, a part of the error of random pixels such as 20%, or
    /// auto: 75%. Default: auto.
    #[arg(long, value_name = "D|P%|auto", value_parser = error)]
    max_error: Option<choices::Error>,
    /// Which of these blocks are split.
    #[arg(long, value_enum, value_name = "WHICH", default_value_t = SplitArg::Cheaper)]
    split: SplitArg,
    /// Re-synthesise pixels with a larger error, written in the same way; auto: 12%. Default: auto.
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
    /// Of the blocks that are drawn from, try so many, and lay the one whose seams are cheapest.
    #[arg(long, value_name = "N", default_value_t = Options::default().tries)]
    tries: u32,
    #[command(flatten)]
    spread: Spread,
    /// Whether the first blocks may continue what is around them verbatim.
    #[arg(long, value_enum, value_name = "WHETHER", default_value_t = ContinuationArg::Allow)]
    continuation: ContinuationArg,
    /// Let blocks reach around the borders of exemplars, which should tile.
    #[arg(long)]
    circular: bool,
    #[command(flatten)]
    guides: GuidanceArgs,
    /// The paper to the letter: --block 32 --overlap 0.2 --max-error 0.04 --pixel-error 0.02 --k 0.5, where they are
    /// not given, and --split always --search exact --resynthesize overlap --tolerance 0 --tries 1 --spread 0
    /// --continuation avoid --circular --radius 0.
    #[arg(long)]
    paper: bool,
    #[command(flatten)]
    turning: Turning,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
}

impl Method for Hybrid {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.options().validate()?;
        let setup = Setup::on("hybrid", &self.weaving, self.sizing, &self.start, session)?;
        let pairs = self.guides.pairs(&self.weaving)?;
        let files = pairs.iter().flat_map(Pair::files).chain(self.guides.mask()).cloned();
        let others = setup.others.into_iter().chain(files).collect();
        let size = match pairs.first() {
            // What is followed has the output's size, where nothing else decides it.
            Some(pair) if self.start.files().is_empty() && self.sizing.is_open() => {
                OutputSize::Picture(Input::new(session, &pair.target)?, 1)
            }
            _ => setup.size,
        };
        Ok(Setup {
            others,
            size,
            guides: pairs.len(),
            transforms: self.turning.transforms(),
            blending: self.blending,
            repairing: self.repairing(),
            ..setup
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let guide = |&domain: &Domain<2>| Bytes::of_samples(domain, 3 * self.guides.channels() as u64);
        let guides = sources.iter().chain([&output]).map(guide).sum::<Bytes>();
        self.start.bytes(output) + guides + self.repairing().bytes(sources, channels, output)
    }

    fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        measuring(sources, channels, masked, &self.options())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let (start, guidance, loom) = (loom.start()?, self.guides.guidance(loom, &self.weaving)?, &*loom);
        let (session, exemplars) = (loom.session, exemplars(loom)?);
        let plan = Plan::new(&exemplars, loom.domain, &self.options(), &session.run());
        let plan = match guidance {
            Some(guidance) => plan.and_then(|plan| plan.following(guidance)),
            None => plan,
        };
        let plan = plan.map_err(|e| told::failure(loom, e))?;
        let needed = self.admit(loom, &|output| plan.bytes_of(output))?;
        let blocks = plan.len();
        let how = format!("from {} of {} px", n("block", blocks as usize), typed(plan.block()));
        Ok(PlannedRun::new(self.used(loom, &plan), how, move || {
            let (kept, sources, whole) = (start.fixed.clone(), start.sources.clone(), start.map.holes() == 0);
            let woven = plan.weave_from(start, &session.run()).map_err(|e| told::failure(loom, e))?;
            let how = match (whole, self.repairing().is_on()) {
                (true, true) => "from what was there".to_owned(),
                (true, false) => "as it was: nothing is missing, and no --fixed makes holes".to_owned(),
                (false, _) => told::how(&woven.stats),
            };
            let told = (told::counts(&woven.stats), how);
            let splits = loom.is_explained().then(|| splits::drawn(&woven.stats, loom.domain)).transpose()?;
            let kept = (kept, sources);
            let mut outcome = self.repairing().outcome(session, &exemplars, woven, kept, told, splits.is_some())?;
            outcome.beside.heading = splits::HEADING;
            outcome.beside.pictures.extend(splits);
            Ok(outcome)
        })
        .needing(needed)
        .counting(json!({ "blocks": blocks })))
    }
}

impl Hybrid {
    fn options(&self) -> Options {
        let usual = Options::default();
        Options {
            block: self.block.map_or(usual.block, |block| block.0),
            overlap: self.overlap.unwrap_or(usual.overlap),
            max_error: self.max_error.map_or(usual.max_error, |error| error.0),
            split: self.split.into(),
            pixel_error: self.pixel_error.map_or(usual.pixel_error, |error| error.0),
            k: self.k,
            layout: self.layout.into(),
            search: self.search.into(),
            resynthesize: self.resynthesize.into(),
            tolerance: self.tolerance,
            tries: self.tries,
            spread: self.spread.spread,
            continuation: self.continuation.into(),
            circular: self.circular,
        }
    }

    /// What is no seam to the blocks is none to repair.
    fn repairing(&self) -> Repairing {
        self.repairing.around(self.circular).always(self.start.files().is_empty())
    }
}

/// The exemplars, their colours weighed as the eye does.
fn exemplars(loom: &Loom<'_>) -> Result<Exemplars<2>, Failure> {
    let exemplars = &loom.loaded.exemplars;
    let in_color = loom.loaded.payload.iter().all(|plane| plane.role == Role::Color);
    Ok(if in_color { weighed(exemplars)? } else { exemplars.clone() })
}
