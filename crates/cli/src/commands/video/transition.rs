//! Loops of one clip: a jump back, at which each pixel makes the step when it is seen least. `[Kwatra03 7A]`

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Exemplars, Role, SeamMeasure};
use selvedge_graphcut_textures::video::{
    self, CLOSES, Closure, DistanceOptions, Footage, FrameDistances, Jump, Loop, LoopStats, Surface, Trial, Usual,
    looped, over_seams,
};
use serde_json::{Value, json};

use super::choices::{JumpArg, Period};
use super::look::Cut;
use super::modes::{PlayArg, Way};
use super::still::Still;
use super::surfaces::{self, times, whole_numbers};
use super::written::WriteArgs;
use super::{ClipOutcome, fade};
use crate::args::NonFiniteArg;
use crate::clip_look::{Shown, features};
use crate::clips::Clip;
use crate::failure::{Failure, n};
use crate::inputs::{self, Input};
use crate::options::{Seams, option};
use crate::report::Report;
use crate::session::Session;
use crate::used::Used;
use crate::values::{Auto, auto, parsed};

/// Frames around a jump, as in the paper.
const WINDOW: u32 = 60;
/// Jumps that are cut: those of least error mostly have the best seam, but not always the very first. A guess.
const JUMPS: u32 = 8;
/// So many times as many are cut where none of these closes. Of seven clips that have as many two close by one of the
/// 9th to 24th jump, and two more come closer; none of the 25th to 46th was better. All are looked at before one is
/// taken: the first that closed had edges in three frames of a fire, and the cheapest that closes has none.
pub(super) const MORE: u32 = 3;

/// A jump whose steps over its seam are larger than those of the best by more is not played: of a whole frame, by what
/// still closes; of the worst block, by a guess, since one in a walk is seen less often than that of a loop.
const WORSE: [f64; 2] = [CLOSES, 2.0];

/// A walk from jump to jump.
struct Walk<'a> {
    frames: u32,
    still: Option<&'a Still>,
    preview: bool,
}

/// Where the clip jumps, and how.
#[derive(Args, Clone, Debug)]
#[command(mut_args(option("seam", |arg| arg.help("How seams are priced"))))]
pub(super) struct TransitionArgs {
    /// Frames of the loop: auto, a number, or a range.
    #[arg(long, value_name = "PERIOD", default_value = "auto")]
    pub(super) period: Period,
    /// Frames around the jump in which pixels may jump.
    #[arg(long, value_name = "FRAMES", default_value_t = WINDOW, value_parser = clap::value_parser!(u32).range(1..=65_534))]
    pub(super) window: u32,
    /// Jumps that are cut, of which the one is taken whose seam is seen least; where none of them closes, up to three
    /// times as many.
    #[arg(long, value_name = "N", default_value_t = JUMPS, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) jumps: u32,
    /// At how many sizes seams are looked for, 1 to 5, each of frames half as wide and high as the one before; from the
    /// second on only near what was found. Of a jump 1 finds the cheapest seam, 2 takes less time and memory and is
    /// mostly near it. auto: 2 for jumps where frames times --window are 8 million samples or more, else 1, and of
    /// frames of 320x240 and more jumps are chosen at half the size first; for what is woven as many as leave 24 px of
    /// frames and 7 of regions, but 1 where it goes on from a map or a checkpoint, or may be gone on from.
    #[arg(long, value_name = "N|auto", default_value = "auto",
        value_parser = auto("number of sizes", "write 1 to 5, or auto",
            |text| parsed::<u32>(text).filter(|n| (1..=5).contains(n))))]
    pub(super) levels: Auto<u32>,
    /// Loop over this jump alone: its last and its first frame, counted from 0.
    #[arg(long, value_name = "LAST,FIRST", conflicts_with = "period")]
    pub(super) jump: Option<JumpArg>,
    #[command(flatten)]
    pub(super) seams: Seams,
    /// Take the seam that another run wrote with --surface; its jump is given by --jump.
    #[arg(long, value_name = "FILE.png", requires = "jump", value_hint = ValueHint::FilePath)]
    surface_from: Option<PathBuf>,
    /// Fade over so many frames instead of a seam, to compare with.
    #[arg(long, value_name = "FRAMES", conflicts_with_all = ["surface_from", "with", "surface", "preview"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=65_534))]
    blend: Option<u32>,
}

impl TransitionArgs {
    /// True if the loop's length is said.
    pub(super) fn says_period(&self) -> bool {
        self.period.0.is_some() || self.jump.is_some()
    }

    /// How seams are priced.
    pub(super) fn measure(&self) -> SeamMeasure {
        self.seams.measure()
    }

    /// True for frames that are mixed.
    pub(super) fn is_faded(&self) -> bool {
        self.blend.is_some()
    }

    /// A file that is read.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        self.surface_from.as_ref()
    }

    /// Finds the jumps, cuts them, and says what came out.
    pub(super) fn made(
        &self,
        session: &Session<'_>,
        clip: &Clip,
        (way, period, still): (&Way, Option<u32>, Option<&Still>),
        write: &WriteArgs,
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let about = |failure: Failure| failure.or_about(&clip.path);
        let exemplars = clip.exemplars()?;
        let run = session.run();
        let pictures = write.preview.is_some() || write.report.is_some();
        let compare = || FrameDistances::new(&exemplars, &DistanceOptions::default(), &run);
        let distances = self.compares(&exemplars, pictures).then(compare).transpose().or_else(|e| {
            // A signal is why, or nothing is.
            session.check_signal()?;
            Err(about(e.into()))
        })?;
        let jumps = self.found(session, distances.as_ref(), period).map_err(about)?;
        if let Some(frames) = self.blend {
            return self.faded(clip, &exemplars, &jumps[0], frames, used);
        }
        if way.play == Some(PlayArg::Random) {
            let walk = Walk { frames: way.output.shape[0], still, preview: pictures };
            let jumps = &jumps[..jumps.len().min(self.jumps as usize)];
            return self.walked(session, &exemplars, (jumps, &walk), used).map_err(about);
        }
        let woven = self.looped(session, &exemplars, &jumps).map_err(about)?;
        let (result, stats) = (woven.result, woven.stats);
        let map = result.map().map_err(|e| about(e.into()))?;
        let map = match still.filter(|_| woven.complete) {
            Some(still) => still.held(session, &exemplars, &map, self.measure())?,
            None => map,
        };
        let output = features(&exemplars, &map)?;
        let closure = Usual::of(&exemplars.sources()[0].features).map(|usual| usual.closure(over_seams(&map, &output)));
        let tried: Vec<Jump> = stats.tried.iter().map(|tried| tried.jump).collect();
        let cut = |distances| Cut { looped: &result, distances, jumps: &tried };
        let shown = Shown { output: &output, map: &map, in_space: false };
        let preview = distances.as_ref().filter(|_| pictures).map(cut).map(|cut| shown.picture(cut.panels()));
        let preview = preview.transpose()?;
        let closes = distances.is_some_and(|d| d.closes() && result.jump.period() == d.frames());
        let told = self.outcome((&result, &stats), (closure, closes), (way, write), used)?;
        Ok(ClipOutcome { preview, map: Some(map), complete: woven.complete, ..told })
    }

    /// What came out of a loop, without its map.
    pub(super) fn outcome(
        &self,
        (result, stats): (&Loop, &LoopStats),
        (closure, closes): (Option<Closure>, bool),
        (way, write): (&Way, &WriteArgs),
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let period = result.jump.period();
        let used = of_one(used, &result.jump);
        Ok(ClipOutcome {
            frames: period,
            loops: true,
            played: way.play.map(|_| way.output.shape[0]),
            how: self.told(result, stats, closure.as_ref(), closes),
            stats: told(result, stats, closure.as_ref(), closes),
            options: used,
            surface: write.surface.as_ref().map(|path| times(&result.surface, path)).transpose()?,
            preview: None,
            map: None,
            mixed: None,
            step: closure.filter(|_| !closes).map(|closure| closure.whole),
            complete: true,
        })
    }

    /// Whether frames are compared: not where the jump is known, no picture shows how much they differ, and the loop
    /// is not the whole clip, which may close.
    pub(super) fn compares(&self, clip: &impl Footage, pictures: bool) -> bool {
        let frames = clip.table().sources()[0].1.shape[0];
        pictures || self.jump.is_none_or(|JumpArg(jump)| jump.period() == frames)
    }

    /// The jumps to cut: the one that was typed, or the best.
    pub(super) fn found(
        &self,
        session: &Session<'_>,
        distances: Option<&FrameDistances<'_>>,
        filled: Option<u32>,
    ) -> Result<Vec<Jump>, Failure> {
        let (None, Some(distances)) = (self.jump, distances) else {
            return Ok(self.jump.iter().map(|JumpArg(jump)| *jump).collect());
        };
        distances.best(&self.asked(filled), &session.run()).or_else(|e| session.check_signal().and(Err(e.into())))
    }

    /// Cuts the jumps, or takes a surface that was cut before.
    pub(super) fn looped(
        &self,
        session: &Session<'_>,
        clip: &impl Footage,
        jumps: &[Jump],
    ) -> Result<selvedge_core::Woven<Loop, LoopStats>, Failure> {
        if let Some(path) = &self.surface_from {
            let options = inputs::options(session.limits, Role::Scalar, NonFiniteArg::Error);
            // Its entry stands in the options.
            let picture = Input::new(session, path)?.read(session, &options, &mut Report::new("video"))?;
            surfaces::check(picture.metadata.provenance.as_ref(), &jumps[0]).map_err(|e| e.about(path))?;
            let time = whole_numbers(&picture.plane).map_err(|e| e.about(path))?;
            let result = Loop::new(clip, jumps[0], Surface { time }).map_err(|e| Failure::from(e).about(path))?;
            return Ok(selvedge_core::Woven { result, stats: LoopStats::default(), complete: true });
        }
        let options = self.options(clip.table().sources()[0].1);
        Ok(looped(clip, jumps, &options, &session.run())?)
    }

    /// Cuts all jumps, and walks from one to the next.
    fn walked(
        &self,
        session: &Session<'_>,
        exemplars: &Exemplars<3>,
        (jumps, walk): (&[Jump], &Walk<'_>),
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let (mut loops, mut complete) = (Vec::new(), true);
        for jump in jumps {
            let woven = self.looped(session, exemplars, std::slice::from_ref(jump))?;
            complete &= woven.complete;
            loops.push((woven.result, woven.stats.tried.into_iter().next()));
        }
        let measures: [fn(&Closure) -> f64; 2] = [|closure| closure.whole, |closure| closure.block];
        for (of, worse) in measures.into_iter().zip(WORSE) {
            let step = |tried: &Option<Trial>| tried.as_ref().map_or(0.0, |tried| of(&tried.closure));
            let least = loops.iter().map(|(_, tried)| step(tried)).fold(f64::INFINITY, f64::min);
            loops.retain(|(_, tried)| step(tried) <= worse * least.max(1.0));
        }
        let (taken, tried): (Vec<Loop>, Vec<Option<Trial>>) = loops.into_iter().unzip();
        let map = video::walk(exemplars, &taken, walk.frames, &session.run())?;
        let map = walk.still.map_or(Ok(map.clone()), |still| still.held(session, exemplars, &map, self.measure()))?;
        let output = features(exemplars, &map)?;
        let closure = Usual::of(&exemplars.sources()[0].features).map(|usual| usual.closure(over_seams(&map, &output)));
        let preview = walk
            .preview
            .then(|| Shown { output: &output, map: &map, in_space: false }.picture(Vec::new()))
            .transpose()?;
        let of_each = taken.iter().zip(&tried).map(|(result, tried)| {
            let (price, steps) = tried.as_ref().map(|tried| (tried.price, closure_json(&tried.closure))).unzip();
            json!({"jump": jump_json(&result.jump), "price": price, "closure": steps})
        });
        let stats = json!({
            "mode": "transition",
            "play": "random",
            "loops": of_each.collect::<Vec<_>>(),
            "closure": closure.map(|closure| closure_json(&closure)),
        });
        let step = closure.map_or(0.0, |closure| closure.whole);
        let how = format!(
            "{} frames by {}, steps over them at most {step:.2} of what is usual",
            walk.frames,
            n("jump", taken.len())
        );
        let (surface, mixed, played) = (None, None, None);
        let (options, map, step) = (used, Some(map), None);
        let (frames, loops) = (walk.frames, false);
        Ok(ClipOutcome { map, mixed, frames, loops, played, options, stats, how, surface, preview, step, complete })
    }

    fn faded(
        &self,
        clip: &Clip,
        exemplars: &Exemplars<3>,
        jump: &Jump,
        frames: u32,
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let (mixed, faded) = fade::faded(&clip.plane, jump, frames).map_err(|e| e.about(&clip.path))?;
        let features = &exemplars.sources()[0].features;
        let steps = Usual::of(features).map(|usual| usual.closure(std::iter::empty()));
        debug_assert!(steps.is_none_or(|closure| closure.steps == 0));
        let period = jump.period();
        let capped = if faded < frames { format!(", since there are no {frames} beside it") } else { String::new() };
        let how = format!("a loop of {period} frames, {} to {}, faded over {faded}{capped}", jump.to, jump.from);
        let stats = json!({"mode": "blend", "period": period, "jump": jump_json(jump), "faded": faded});
        let options = of_one(used, jump);
        let (surface, preview, step) = (None, None, None);
        let (frames, loops, played) = (period, true, None);
        Ok(ClipOutcome {
            map: None,
            mixed: Some(mixed),
            frames,
            loops,
            played,
            options,
            stats,
            how,
            surface,
            preview,
            step,
            complete: true,
        })
    }

    /// For people.
    fn told(&self, result: &Loop, stats: &LoopStats, closure: Option<&Closure>, closes: bool) -> String {
        let Jump { from, to, .. } = result.jump;
        let period = result.jump.period();
        if closes {
            return format!("the clip closes already: a loop of all its {period} frames (--period asks for a jump)");
        }
        let seam = match stats.tried.get(stats.chosen) {
            Some(tried) if 0 < tried.straight => {
                let share = 100.0 * tried.price as f64 / tried.straight as f64;
                format!(
                    ", a seam of {share:.0} % of the straight cut's price, the best of {}",
                    stats.tried.len().max(stats.halved.len())
                )
            }
            _ => String::new(),
        };
        let step = closure.map_or(String::new(), |closure| {
            format!(", steps over it at most {:.2} of what is usual", closure.whole.max(closure.block))
        });
        format!("a loop of {period} frames, {to} to {from}{seam}{step}")
    }
}

/// Options of a loop over this jump: of those that have its period another may be the best.
fn of_one(used: Used, jump: &Jump) -> Used {
    used.without("period").set("jump", format!("{},{}", jump.from, jump.to))
}

/// Counts of a run.
fn told(result: &Loop, stats: &LoopStats, closure: Option<&Closure>, closes: bool) -> Value {
    let tried = |tried: &Trial| {
        json!({
            "from": tried.jump.from,
            "to": tried.jump.to,
            "error": tried.jump.error,
            "window": [tried.window.start, tried.window.end],
            "price": tried.price,
            "straight": tried.straight,
            "shortened_bits": tried.shift,
            "whole": tried.closure.whole,
            "block": tried.closure.block,
        })
    };
    json!({
        "mode": "transition",
        "closes_already": closes,
        "period": result.jump.period(),
        "jump": jump_json(&result.jump),
        "price": stats.tried.get(stats.chosen).map(|tried| tried.price),
        "straight": stats.tried.get(stats.chosen).map(|tried| tried.straight),
        "tried": stats.tried.iter().map(tried).collect::<Vec<_>>(),
        "tried_at_half_size": stats.halved.iter().map(tried).collect::<Vec<_>>(),
        "closure": closure.map(|closure| {
            let mut told = closure_json(closure);
            // The step over its end is one of the clip's own.
            told["closes"] = (closes || closure.closes()).into();
            told
        }),
    })
}

fn closure_json(closure: &Closure) -> Value {
    json!({"steps": closure.steps, "whole": closure.whole, "block": closure.block, "closes": closure.closes()})
}

fn jump_json(jump: &Jump) -> Value {
    json!({"from": jump.from, "to": jump.to, "error": jump.error})
}
