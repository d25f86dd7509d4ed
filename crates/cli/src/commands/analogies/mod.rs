//! What the commands of constrained synthesis share: knobs here, the run, its memory, what is told of it. `[CMS]`

pub(crate) mod analogy;
mod bytes;
pub(crate) mod detail;
pub(super) mod fit;
mod frames;
mod job;
pub(crate) mod numbers;
pub(super) mod palette;
pub(super) mod shown;
pub(super) mod told;
mod used;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_cms_analogies::Options;

use crate::blending::Blending;
use crate::ground::StartArgs;
use crate::options::{Following, Turning, option};
use crate::pairs::GuideArgs;
use crate::sweep::Sweep;
use crate::values::{Auto, count};

/// Options of all commands of constrained synthesis.
#[derive(Args, Clone, Debug)]
#[command(mut_args(option("guide", |arg| arg
    .help("Follow a further pair of pictures: one that lies under the exemplar, and one that lies under the output. With \
        several exemplars write theirs as one list, separated by commas. May be given several times"))))]
pub(crate) struct Knobs {
    #[command(flatten)]
    following: Following,
    #[command(flatten)]
    guides: GuideArgs,
    /// Follow what is asked for only where this picture is white; elsewhere the texture goes on as it likes.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    follow_where: Option<PathBuf>,
    /// Write what lies under the exemplars as the output has it, 8 bits: it should look like what is followed.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    mapped: Option<PathBuf>,
    #[command(flatten)]
    start: StartArgs,
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
    /// each K, with K/N below each: K=.05,.2,1,5 N=1,3,5,9. An n in braces in names is the run's number.
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
            constraint_weight: self.following.constraint_weight.unwrap_or(task.weight),
            neighborhood: self.following.neighborhood.unwrap_or(task.neighborhood),
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
