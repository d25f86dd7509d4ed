//! `selvedge optimize`: texture optimization. `[Kwatra05 3]`

mod control;
mod init;
mod levels;
mod shown;
mod told;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Render, Run};
use selvedge_texture_optimization::{Finish, Options, Plan, Search, Stats, estimate};

use self::control::ControlArgs;
pub(super) use self::init::{Beginning, Init, init};
use self::levels::{Complete, complete, schedule};
pub(super) use self::levels::{Levels, levels, typed};
use self::shown::Film;
pub(super) use self::told::failure;
use crate::failure::{Failure, n};
use crate::ground::StartArgs;
use crate::inputs::Input;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::pairs::Pair;
use crate::session::Session;
use crate::setup::Setup;
use crate::values::{Auto, choices};
use crate::weaving::{Sizing, Weaving};

/// Options of `optimize`.
#[derive(Args, Debug)]
pub(crate) struct Optimize {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// What is optimised, at the resolution where the schedule begins: auto, quilt, graphcut, random, or a source map
    /// of the same exemplars. auto is a graph cut.
    #[arg(long, value_name = "WHAT", default_value = "auto", value_parser = init)]
    init: Init,
    /// Polish a source map of the same exemplars: what of the schedule is at full resolution.
    #[arg(long, value_name = "MAP.exr", value_hint = ValueHint::FilePath, conflicts_with = "init")]
    start: Option<PathBuf>,
    /// Resolutions and sizes of neighborhoods from coarse to fine, or auto: 4:8 is 8 px at a fourth of the resolution.
    /// What does not fit is left out. auto is 4:8,2:16,2:8,1:32,1:16,1:8, and 1:16,1:8 where a graph cut placed
    /// everything already, and nothing is wanted or followed.
    #[arg(long, value_name = "SCALE:SIZE,...|auto", default_value = "auto", value_parser = schedule)]
    schedule: Auto<Levels>,
    /// Iterations at a level, if it does not settle before.
    #[arg(long, value_name = "N", default_value_t = Options::default().iterations)]
    iterations: u32,
    /// How neighborhoods are found: among all places of the exemplars each time, or once a level, after which they
    /// continue each other.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = SearchArg::Coherent)]
    search: SearchArg,
    /// How much parts of the exemplars are preferred that the output lacks: 0 makes it as complete as can be, 1 hardly,
    /// none takes whatever is nearest. auto is 0.2, and none of a tree, and from a graph cut where nothing is wanted or
    /// followed.
    #[arg(long, value_name = "A|none|auto", default_value = "auto", value_parser = complete)]
    complete: Auto<Complete>,
    /// How evenly the exemplar is used: 0 takes whatever fits best.
    #[arg(long, value_name = "S", default_value_t = Options::default().spread)]
    spread: f64,
    /// What the output is made of: samples of the exemplars, which makes it sharp and gives it a source map, or
    /// averages.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = FinishArg::Coherent)]
    finish: FinishArg,
    /// Exponent of the robust energy, from above 0 to 2: the less it is, the less neighborhoods pull that fit badly.
    #[arg(long, value_name = "R", default_value_t = Options::default().robust)]
    robust: f64,
    /// How much differences between pixels beside each other count, where colours count 1, up to 100. Each step
    /// takes longer for it.
    #[arg(long, value_name = "MU", default_value_t = Options::default().gradient, allow_negative_numbers = true)]
    gradient: f64,
    #[command(flatten)]
    control: ControlArgs,
    /// The paper, but for its tree: --init random --iterations 100 --search exact --complete none --finish average
    /// --robust 0.8 --gradient 10.
    #[arg(long, conflicts_with = "start")]
    paper: bool,
}

choices!(FinishArg for Finish {
    /// Samples that continue each other.
    Coherent,
    /// Averages, as the paper has it.
    Average,
});

choices!(SearchArg for Search {
    /// All places, each time.
    Exact,
    /// All places once a level.
    Coherent,
    /// The paper's tree, which finds something near: with --complete none, to compare with.
    Tree,
});

impl Method for Optimize {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.options().validate().map_err(told::by_flags)?;
        self.control.validate(self.init().map().is_some())?;
        let ground = StartArgs::of_map(self.init().map().cloned()).ground(session)?.into();
        let pairs = self.control.pairs(&self.weaving)?;
        let followed = pairs.iter().flat_map(Pair::files).cloned();
        let others = self.init().map().into_iter().cloned().chain(self.control.files()).chain(followed).collect();
        let size = match pairs.first() {
            // What is followed has the output's size, where nothing else decides it.
            Some(pair) if self.init().map().is_none() && self.sizing.is_open() => {
                OutputSize::Picture(Input::new(session, &pair.target)?, 1)
            }
            _ => OutputSize::Ground(ground, self.sizing),
        };
        Ok(Setup { others, guides: pairs.len(), ..Setup::new("optimize", &self.weaving, size) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.bytes_from(Bytes(0), (sources, channels), output, &self.options())
    }

    fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        self.init().choosing(sources, channels, masked)
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let (control, read, loom) = (self.control.read(loom, &self.weaving)?, loom.start_map()?, &*loom);
        let (exemplars, run) = (&loom.loaded.exemplars, loom.session.run());
        if self.weaving.with.is_blind() {
            let what = "it comes along undecided, and may have crumbs where seams were mended; give it to --match too";
            loom.session.warn(&self.weaving.with.with[0], &what);
        }
        let init = self.init().chosen();
        let options = self.options_from(&init);
        let plan = Plan::new(exemplars, loom.domain, &options, &run).map_err(|e| told::failure(&loom.loaded, e))?;
        let (sources, channels) = loom.sources();
        // What of the start grows with the output is told for the one that is wanted.
        let beginning = init.planned(exemplars, loom.domain, &run)?;
        let needed =
            loom.admit(&|output| self.bytes_from(beginning.bytes(), (&sources, channels), output, &options))?;
        let how = format!("from {} at {}", told::start(&init), n("level", plan.levels().len()));
        Ok(PlannedRun::new(self.used(loom, &init, &options), how, move || {
            let outcome = |woven: Box<dyn Render<2>>, complete, stats: &Stats| {
                Outcome::new(woven, complete, told::counts(stats), told::how(&init, stats))
            };
            let start = match beginning.weave(&run)? {
                Some(made) if !made.complete => return Ok(outcome(Box::new(made.result), false, &Stats::default())),
                Some(made) => Some(made.result),
                None => read,
            };
            let colors = loom.loaded.payload[0].color_channels();
            let film = self.weaving.report.is_some().then(|| Film::new(&loom.session.watch, exemplars, colors));
            let run = film.as_ref().map_or(run, |film| Run { observer: film, ..run });
            let woven = plan.weave(start.as_ref(), &control, &run).map_err(|e| told::failure(&loom.loaded, e))?;
            let mut outcome = outcome(Box::new(woven.result), woven.complete, &woven.stats);
            outcome.course = film.map(|film| film.course(&woven.stats));
            outcome.stats["washed_out"] = told::washed_out(loom, &init, &*outcome.woven)?.into();
            Ok(outcome)
        })
        .needing(needed))
    }
}

impl Optimize {
    /// Bytes of the work, with what its start takes before it.
    fn bytes_from(
        &self,
        start: Bytes,
        (sources, channels): (&[Domain<2>], usize),
        output: Domain<2>,
        options: &Options,
    ) -> Bytes {
        let map = Bytes::of_samples(output, 4);
        let method = estimate(sources, channels + self.control.channels(), output, options);
        let shown = if self.weaving.report.is_some() { shown::bytes(output) } else { Bytes(0) };
        start.then(method + map + shown) + self.control.bytes(sources, channels, output)
    }

    fn init(&self) -> Init {
        self.start.clone().map_or_else(|| self.init.clone(), Init::Map)
    }

    /// The options where it is known what it starts from: what was typed is as it was typed.
    fn options_from(&self, init: &Init) -> Options {
        let options = self.options();
        if self.control.steers() {
            return options;
        }
        let Some(suited) = init.suited() else { return options };
        let schedule = if self.schedule.0.is_none() { suited.schedule } else { options.schedule };
        let complete = if self.complete.0.is_none() { suited.complete } else { options.complete };
        Options { schedule, complete, ..options }
    }

    fn options(&self) -> Options {
        let mut schedule =
            self.schedule.0.as_ref().map_or_else(|| Options::default().schedule, |levels| levels.0.clone());
        if self.start.is_some() {
            schedule.retain(|level| level.scale == 1);
        }
        let search: Search = self.search.into();
        let usual = Options::default().complete.filter(|_| search != Search::Tree);
        Options {
            schedule,
            iterations: self.iterations,
            complete: self.complete.0.map_or(usual, |typed| typed.0),
            spread: self.spread,
            finish: self.finish.into(),
            robust: self.robust,
            gradient: self.gradient,
            search,
        }
    }
}
