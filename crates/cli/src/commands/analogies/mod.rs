//! What the commands of constrained synthesis share: knobs, the run, what is told of it. `[CMS]`

pub(crate) mod analogy;
pub(crate) mod detail;
pub(super) mod fit;
pub(crate) mod numbers;
pub(super) mod palette;
pub(super) mod told;

use std::path::{Path, PathBuf};

use clap::Args;
use selvedge_cms_analogies::{Constraint, Options, Plan, Sizes, estimate, fitness};
use selvedge_core::{Bytes, Domain};
use serde_json::Value;

use self::told::{failure, outcome};
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::inputs::Input;
use crate::loom::Loom;
use crate::memory;
use crate::method::{Method, Planned};
use crate::options::Turning;
use crate::options::option;
use crate::outcome::Beside;
use crate::pairs::{GuideArgs, Pair};
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::sweep::Sweep;
use crate::used::Used;
use crate::values::{Auto, count};
use crate::weaving::Weaving;

/// Options of all commands of constrained synthesis.
#[derive(Args, Debug)]
#[command(mut_args(option("guide", |arg| arg
    .help("Follow a further pair of pictures: one that lies under the exemplar, and one that lies under the output. With \
        several exemplars write theirs as one list, separated by commas. May be given several times"))))]
pub(crate) struct Knobs {
    /// How much the constraints count against seams: large values follow them, small ones keep the texture whole.
    #[arg(short = 'K', long, value_name = "K")]
    constraint_weight: Option<f64>,
    /// Half the side of the neighborhoods that are compared, in pixels of the constraint: large ones keep structures,
    /// small ones follow curves.
    #[arg(short = 'N', long, value_name = "N")]
    neighborhood: Option<u32>,
    #[command(flatten)]
    guides: GuideArgs,
    #[command(flatten)]
    turning: Turning,
    /// Use exemplars upright alone: detail turns them by quarter turns otherwise.
    #[arg(long, overrides_with = "turn")]
    no_turn: bool,
    /// Labels that are tried for a bad place.
    #[arg(long, value_name = "N", default_value_t = Options::paper().candidates)]
    candidates: u32,
    /// Least distance of these labels in pixels.
    #[arg(long, value_name = "N", default_value_t = Options::paper().apart)]
    apart: u32,
    /// Bad places in a row that are tried in vain before the run ends.
    #[arg(long, value_name = "N", default_value_t = Options::paper().history)]
    history: u32,
    /// What an improvement has to gain. Default: 5 (K + 2).
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// How much the output spreads over all of the exemplars, so that no part of them shows over and over: what a pixel
    /// costs that shows as often as all do. 0 lets the flattest show everywhere. Default: what suits the task.
    #[arg(long, value_name = "S")]
    spread: Option<f64>,
    /// At how many sizes the output is solved, each half of the one before, or auto: up to three, as constraints and
    /// exemplars allow. Large structures are placed where they are small.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = count())]
    levels: Auto<u32>,
    /// Make a run for each of several K, each of several N, or each pair of both, and show them by --sheet, a row for
    /// each K, with K/N below each: K=.05,.2,1,5 N=1,3,5,9. '{n}' in names is the run's number.
    #[arg(long, num_args = 1..=2, value_name = "LIST")]
    sweep: Vec<Sweep>,
    /// Draw this many labels at random instead of searching for them, to compare with.
    #[arg(long, value_name = "N")]
    random_labels: Option<u32>,
    #[command(flatten)]
    blending: Blending,
}

/// What is not typed.
#[derive(Clone, Copy)]
struct Task {
    weight: f64,
    neighborhood: u32,
    spread: f64,
    turn: bool,
}

impl Knobs {
    fn turning(&self, task: Task) -> Turning {
        let turn = self.turning.turn || task.turn && !self.no_turn;
        Turning { turn, ..self.turning }
    }

    fn options(&self, task: Task) -> Options {
        Options {
            constraint_weight: self.constraint_weight.unwrap_or(task.weight),
            neighborhood: self.neighborhood.unwrap_or(task.neighborhood),
            candidates: self.candidates,
            apart: self.apart,
            history: self.history,
            tolerance: self.tolerance,
            spread: self.spread.unwrap_or(task.spread),
            levels: self.levels.0,
            random_labels: self.random_labels,
        }
    }
}

/// Makes the constraint of a command.
type Read<'a> = dyn Fn(&Job<'_>, &mut Loom<'_>) -> Result<Constraint, Failure> + 'a;

/// A command of constrained synthesis whose options were understood.
struct Job<'a> {
    name: &'static str,
    weaving: &'a Weaving,
    knobs: &'a Knobs,
    task: Task,
    options: Options,
    /// The picture of the command's own constraint: the output has its size, or follows from it.
    first: &'a Path,
    /// How many times larger the output is than that.
    ratio: u32,
    /// Channels of its own constraint at most.
    channels: usize,
    /// All other files.
    others: Vec<PathBuf>,
    read: &'a Read<'a>,
    /// What its canonical command has where other commands have their exemplars.
    files: Option<Vec<PathBuf>>,
}

impl Method for Job<'_> {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        let pairs = self.knobs.guides.pairs(self.weaving)?;
        self.options.validate()?;
        let first = Input::new(session, self.first)?;
        Ok(Setup {
            others: self.others.iter().chain(pairs.iter().flat_map(Pair::files)).cloned().collect(),
            transforms: self.knobs.turning(self.task).transforms(),
            blending: self.knobs.blending,
            guides: pairs.len(),
            files: self.files.clone(),
            ..Setup::new(self.name, self.weaving, OutputSize::Picture(first, self.ratio))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.bytes_with(self.channels, sources, channels, output)
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<Planned<'l>, Failure> {
        let mut followed = vec![self.first.to_path_buf()];
        let mut constraints = vec![(self.read)(self, loom)?];
        for pair in self.knobs.guides.pairs(self.weaving)? {
            constraints.push(Constraint { guide: pair.read(loom)?, ratio: 1, weight: pair.weight });
            followed.push(pair.target);
        }
        let loom = &*loom;
        self.planned(loom, &constraints)?;
        let fits = fitness(&loom.loaded.exemplars, &constraints, &self.options).map_err(failure)?;
        followed.iter().zip(&fits).for_each(|(path, fit)| fit::warn(loom.session, path, fit));
        let how = format!("under {}", n("constraint", constraints.len()));
        Ok(Planned::new(self.used(loom), how, move || {
            let woven = self.planned(loom, &constraints)?.weave(&loom.session.run()).map_err(failure)?;
            let mut outcome = outcome(woven);
            outcome.stats["fitness"] = fits.iter().map(fit::json).collect();
            if loom.args.explain.is_some() || loom.args.report.is_some() {
                let guides = followed.iter().zip(&constraints).zip(&fits);
                let drawn = guides.map(|((path, constraint), fit)| fit::drawn(path, constraint.guide.target(), fit));
                let pictures = drawn.collect::<Result<_, _>>()?;
                outcome.beside =
                    Beside { heading: "Followed, red where nothing under the exemplars is like it", pictures };
            }
            Ok(outcome)
        }))
    }
}

/// Bytes of a sample of the pictures that a constraint is made of: four channels of 16 bits, three of a map, and its
/// label.
const OF_PICTURE: u64 = 8 + 3 + 1;

impl Job<'_> {
    /// The method's memory where its own constraint has so many channels.
    fn bytes_with(&self, own: usize, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let constraints: Vec<_> =
            std::iter::once((own, self.ratio)).chain((0..self.knobs.guides.len()).map(|_| (3, 1))).collect();
        let sizes = Sizes { sources, channels, constraints: &constraints, output };
        let orientations = self.knobs.turning(self.task).transforms().len();
        // Maps lie under every source, the pictures that they are made of under the exemplars, both under the output.
        let of = |domain: &Domain<2>, each: u64| Bytes::of_samples(*domain, each);
        let maps = constraints.iter().map(|&(channels, _)| channels as u64).sum::<u64>();
        let pictures = maps + OF_PICTURE * constraints.len() as u64;
        let held: Bytes = sources.iter().chain(std::iter::once(&output)).map(|domain| of(domain, maps)).sum();
        let made: Bytes = sources
            .iter()
            .step_by(orientations)
            .chain(std::iter::once(&output))
            .map(|domain| of(domain, pictures))
            .sum();
        estimate(&sizes, &self.options) + held + made
    }

    /// Refuses constraints of more channels than were known before anything was read, where there is no room for them.
    fn admit(&self, loom: &mut Loom<'_>, channels: usize) -> Result<(), Failure> {
        let exemplars = &loom.loaded.exemplars;
        let sources: Vec<Domain<2>> = exemplars.table().sources().iter().map(|s| s.1).collect();
        let of = |own| self.bytes_with(own, &sources, exemplars.channels(), loom.domain);
        let known = loom.report.estimate.unwrap_or_default();
        let needed = known.saturating_add(of(channels).0.saturating_sub(of(self.channels).0));
        memory::check_fixed(&loom.session.limits, Bytes(needed))?;
        loom.report.estimate = Some(needed);
        Ok(())
    }

    fn planned<'l>(&'l self, loom: &'l Loom<'_>, constraints: &'l [Constraint]) -> Result<Plan<'l>, Failure> {
        Plan::new(&loom.loaded.exemplars, constraints, &self.options, &loom.session.run()).map_err(failure)
    }

    /// The options as used.
    fn used(&self, loom: &Loom<'_>) -> Used {
        let (knobs, options) = (self.knobs, &self.options);
        let turn = knobs.turning(self.task).turn;
        let used = if self.task.turn {
            loom.used().set("no-turn", !turn).without("turn")
        } else {
            loom.used().set("turn", turn).without("no-turn")
        };
        let used = used
            .set("constraint-weight", options.constraint_weight)
            .set("neighborhood", options.neighborhood)
            .set("spread", options.spread)
            .set("levels", options.levels)
            .unless("tolerance", Value::Null)
            .unless("spread", 0.0)
            .unless("levels", Value::Null)
            .unless("random-labels", Value::Null);
        knobs.guides.used(loom, used).unless("weight", Vec::<Value>::new())
    }
}
