//! `selvedge optimize`: texture optimization. `[Kwatra05 3]`

mod control;
mod init;
mod levels;

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use selvedge_core::{Bytes, Domain, Render, SourceMap};
use selvedge_texture_optimization::{Control, Finish, Level, LevelStats, Options, Plan, Stats, estimate};
use serde_json::{Value, json};

use self::control::ControlArgs;
use self::init::{Init, init};
use self::levels::{Levels, levels, typed};
use crate::failure::{Failure, n};
use crate::ground::{Ground, StartArgs};
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::report::Done;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::used::Used;
use crate::weaving::{Sizing, Weaving};
use crate::wrong::Wrong;

/// Options of `optimize`.
#[derive(Args, Debug)]
pub(crate) struct Optimize {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// What is optimised, at the resolution where the schedule begins: auto, quilt, graphcut, random, or a source map
    /// of the same exemplars. auto is a graph cut of exemplars that repeat themselves, of others a quilt.
    #[arg(long, value_name = "WHAT", default_value = "auto", value_parser = init)]
    init: Init,
    /// Polish a source map of the same exemplars: what of the schedule is at full resolution.
    #[arg(long, value_name = "MAP.exr", value_hint = ValueHint::FilePath, conflicts_with = "init")]
    start: Option<PathBuf>,
    /// Resolutions and sizes of neighborhoods from coarse to fine: 4:8 is 8 px at a fourth of the resolution. What does
    /// not fit is left out.
    #[arg(long, value_name = "SCALE:SIZE,...", default_value_t = typed(&Options::default().schedule))]
    schedule: String,
    /// Iterations at a level, if it does not settle before.
    #[arg(long, value_name = "N", default_value_t = Options::default().iterations)]
    iterations: u32,
    /// How much parts of the exemplars are preferred that the output lacks: 0 makes it as complete as can be, 1 hardly,
    /// none takes whatever is nearest.
    #[arg(long, value_name = "A|none", default_value_t = Complete(Options::default().complete),
        value_parser = complete, allow_negative_numbers = true)]
    complete: Complete,
    /// What the output is made of: samples of the exemplars, which makes it sharp and gives it a source map, or
    /// averages.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = FinishArg::Coherent)]
    finish: FinishArg,
    /// Exponent of the robust energy, from above 0 to 2: the less it is, the less neighborhoods pull that fit badly.
    #[arg(long, value_name = "R", default_value_t = Options::default().robust)]
    robust: f64,
    #[command(flatten)]
    control: ControlArgs,
    /// The paper to the letter: --init random --iterations 100 --complete none --finish average --robust 0.8.
    #[arg(long, conflicts_with_all = ["init", "start", "iterations", "complete", "finish", "robust"])]
    paper: bool,
}

/// How complete the output becomes; `None` for as it comes.
#[derive(Clone, Copy, Debug)]
struct Complete(Option<f64>);

fn complete(text: &str) -> Result<Complete, Wrong> {
    match text {
        "none" => Ok(Complete(None)),
        _ => text
            .parse()
            .map(|v| Complete(Some(v)))
            .map_err(|_| Wrong::new(format!("'{text}' is no completeness"), "write a number from 0 on, or none")),
    }
}

impl fmt::Display for Complete {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(alpha) => write!(f, "{alpha}"),
            None => f.write_str("none"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FinishArg {
    /// Samples that continue each other.
    Coherent,
    /// Averages, as the paper has it.
    Average,
}

impl From<FinishArg> for Finish {
    fn from(finish: FinishArg) -> Self {
        match finish {
            FinishArg::Coherent => Self::Coherent,
            FinishArg::Average => Self::Average,
        }
    }
}

/// A run whose options were understood, and whose map was read.
struct Job<'a> {
    args: &'a Optimize,
    options: Options,
    init: Init,
    ground: Ground,
}

impl Optimize {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let options = self.options(levels(&self.schedule).map_err(wrong)?)?;
        let init = match &self.start {
            Some(path) => Init::Map(path.clone()),
            None if self.paper => Init::Random,
            None => self.init.clone(),
        };
        let ground = StartArgs::of_map(init.map().cloned()).ground(session)?;
        Job { args: self, options, init, ground }.run(session)
    }

    fn options(&self, Levels(mut schedule): Levels) -> Result<Options, Failure> {
        if self.start.is_some() {
            schedule.retain(|level| level.scale == 1);
        }
        let chosen = if self.paper {
            Options { schedule, ..Options::paper() }
        } else {
            Options {
                schedule,
                iterations: self.iterations,
                complete: self.complete.0,
                finish: self.finish.into(),
                robust: self.robust,
                ..Options::default()
            }
        };
        chosen.validate()?;
        Ok(chosen)
    }
}

fn wrong(wrong: Wrong) -> Failure {
    Failure::new(2, wrong.what).remedy(wrong.remedy)
}

impl Method for Job<'_> {
    /// The map to start from, if that was read, and constraints.
    type Read = (Option<SourceMap<2>>, Control);

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        self.args.control.validate(self.init.map().is_some())?;
        self.options.validate()?;
        let others = self.init.map().into_iter().cloned().chain(self.args.control.files()).collect();
        let size = OutputSize::Ground(&self.ground, self.args.sizing);
        Ok(Setup { others, ..Setup::new("optimize", &self.args.weaving, size) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let map = Bytes::of_samples(output, 4);
        let method = Bytes(estimate(sources, channels, output, &self.options));
        let wishes = self.args.control.bytes(channels, output);
        self.init.bytes(sources, channels, output).then(method + map) + wishes
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Self::Read, Failure> {
        let control = self.args.control.read(loom)?;
        Ok((self.ground.map(loom)?, control))
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, (read, control): Self::Read) -> Result<Planned<'l>, Failure> {
        let (exemplars, run) = (&loom.loaded.exemplars, loom.session.run());
        let plan = Plan::new(exemplars, loom.domain, &self.options, &run).map_err(|e| failure(loom, e))?;
        let init = self.init.chosen(exemplars)?;
        let how = format!("from {} at {}", told(&init), n("level", plan.levels().len()));
        Ok(Planned::new(self.used(loom, &init), how, move || {
            let outcome = |woven: Box<dyn Render<2>>, complete, stats: &Stats| {
                Outcome::new(woven, complete, counts(stats), how_woven(&init, stats))
            };
            let start = match init.made(exemplars, loom.domain, &run)? {
                Some(made) if !made.complete => {
                    return Ok(outcome(Box::new(made.result), false, &Stats::default()));
                }
                Some(made) => Some(made.result),
                None => read,
            };
            let woven = plan.weave(start.as_ref(), &control, &run).map_err(|e| failure(loom, e))?;
            Ok(outcome(Box::new(woven.result), woven.complete, &woven.stats))
        }))
    }
}

impl Job<'_> {
    /// The options as used: what was left to the program, and what --paper stands for.
    fn used(&self, loom: &Loom<'_>, init: &Init) -> Used {
        let used = loom
            .used()
            .set("schedule", typed(&self.options.schedule))
            .set("iterations", self.options.iterations)
            .set("complete", self.options.complete.map_or_else(|| Value::from("none"), Value::from))
            .set("finish", if self.options.finish == Finish::Coherent { "coherent" } else { "average" })
            .set("robust", self.options.robust);
        let used = self.args.control.used(used);
        match &self.args.start {
            Some(_) => used.without("init"),
            None => used.set("init", init.typed()),
        }
    }
}

/// For people.
fn told(init: &Init) -> &'static str {
    match init {
        Init::Quilt => "a quilt",
        Init::Graphcut => "a graph cut",
        Init::Random => "noise",
        Init::Auto | Init::Map(_) => "a map",
    }
}

fn counts(stats: &Stats) -> Value {
    let level = |l: &LevelStats| {
        json!({
            "level": typed(&[l.level]),
            "neighborhoods": l.neighborhoods,
            "energy": l.energy,
            "robust_energy": l.robust,
            "searched": l.searched,
            "rises": l.rises,
            "settled": l.settled,
        })
    };
    json!({
        "levels": stats.levels.iter().map(level).collect::<Vec<_>>(),
        "left_out": stats.left_out.iter().map(|l: &Level| typed(&[*l])).collect::<Vec<_>>(),
    })
}

fn how_woven(init: &Init, stats: &Stats) -> String {
    let (iterations, levels) = (n("iteration", stats.iterations()), n("level", stats.levels.len()));
    let energy = stats.energy().map_or(String::new(), |e| format!(", energy {e:.1}"));
    format!("from {} by {iterations} at {levels}{energy}", told(init))
}

/// Errors about exemplars name the file, and options by their flags.
fn failure(loom: &Loom<'_>, error: selvedge_texture_optimization::Error) -> Failure {
    use selvedge_texture_optimization::Error;
    match &error {
        Error::NothingFits { output: false, .. } => {
            let remedy = "use a larger exemplar, mask less, or add a smaller size to --schedule, such as 1:4";
            loom.loaded.about(Failure::from(error).remedy(remedy))
        }
        Error::NothingFits { least, .. } => {
            let remedy = format!("use --size {least} or more, or a smaller size in --schedule, such as 1:4");
            Failure::from(error).remedy(remedy)
        }
        Error::Masked { .. } => loom.loaded.about(Failure::from(error)),
        _ => Failure::from(error),
    }
}
