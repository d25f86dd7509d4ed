//! `selvedge video`: video textures.

mod blended;
mod bytes;
mod checks;
mod choices;
mod fade;
mod jumping;
mod look;
mod modes;
mod read;
mod rendered;
mod reread;
mod still;
mod surfaces;
mod told;
mod transition;
mod weave;
mod woven;
mod written;

use clap::Args;
use selvedge_core::{Bytes, Plane, SourceMap};
use selvedge_graphcut_textures::video::CLOSES;
use serde_json::Value;

use self::modes::{ModeArgs, Way};
use self::read::ReadArgs;
use self::still::{Still, StillArgs};
use self::transition::TransitionArgs;
use self::woven::{Material, Under, WovenArgs};
use self::written::WriteArgs;
use crate::clip_maps::ClipMaps;
use crate::clips::{Clip, ClipInput};
use crate::failure::{Failure, shown};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;
use crate::values::name_of;
use crate::{inputs, memory};

/// Options of `video`.
#[derive(Args, Clone, Debug)]
pub(crate) struct Video {
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    mode: ModeArgs,
    #[command(flatten)]
    transition: TransitionArgs,
    #[command(flatten)]
    still: StillArgs,
    #[command(flatten)]
    woven: WovenArgs,
    /// The paper to the letter: whole clips, the first that is drawn, a window of 60 frames around a jump: --reach all
    /// --variety 0 --tries 1 --window 60 --seam gradient --levels 1. With '--loop fixed' it keeps 10 frames, as is the
    /// default of clips of 30.
    #[arg(long)]
    paper: bool,
    #[command(flatten)]
    write: WriteArgs,
}

/// What a mode made.
struct ClipOutcome {
    /// `None` where samples were mixed.
    map: Option<SourceMap<3>>,
    /// Frames that were mixed.
    mixed: Option<Plane<3>>,
    /// Frames of it.
    frames: u32,
    /// Whether it begins again after them.
    loops: bool,
    /// Frames that are written of what is played on.
    played: Option<u32>,
    options: Used,
    stats: Value,
    how: String,
    /// The largest step of a whole frame over the seam of a jump, beside what is usual in the clip.
    step: Option<f64>,
    /// Pictures beside it.
    surface: Option<Plane<2>>,
    preview: Option<Plane<2>>,
    complete: bool,
}

/// Threads on which is told what memory holds, how many frames, or whether to weave where no jump closes: the map
/// follows from that, and must not depend on how many there are. On more of them what is told may not fit, and is
/// refused.
const CHOSEN_ON: usize = 16;

impl Video {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let (mut report, clip) = (Report::new("video"), &self.read.clip);
        let mut others: Vec<_> = self.transition.file().into_iter().chain(self.still.file()).cloned().collect();
        inputs::check_streams(self.read.paths().chain(&others))?;
        self.write.check_names(self.read.paths().count())?;
        let clips = self.read.open(session, self.write.rate, &self.write.beside())?;
        let start = self.woven.begun(session, &clips[0], &mut report)?;
        others.extend(self.woven.files()?);
        let way = self.way(session, &clips[0], start.as_ref())?;
        self.write.check(session, &self.read, (&clips, &way), &others)?;
        let most = self.write.most(&way, &clips[0]);
        let (way, needed, is_read_again) = self.affordable(session, &clips, way)?;
        let streams = self.streams(session, &way);
        memory::check_fixed(&session.limits, needed).map_err(|e| e.about(clip))?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        let used = session.options.clone().unless("with", Value::Null).unless("fixed", Value::Null);
        let used = used.unless("still-frame", Value::Null).unless("encode", Value::Null);
        let used = self.write.blending.used_if_any(used);
        let name = shown(&self.write.output);
        if session.global.dry_run {
            report.options = used;
            report.inputs.extend(clips.iter().map(|clip| clip.noted(None)));
            let line = format!("{name}: would be {}, with about {needed} of memory", self.would(&clips[0], &way)?);
            return Ok(Done::would(report, line, self.write.planned(&self.read, &way, self.frames(&clips[0], &way)?)));
        }
        match (is_read_again, way.jumps()) {
            (true, true) => return self.reread(session, report, (clips, &way, most), used),
            (true, false) => return self.rendered_again(session, report, (clips, start.as_ref()), (&way, most), used),
            (false, _) => {}
        }
        let clips = clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()?;
        report.stage("read");
        let still = self.still.read(session, clips[0].plane.domain().shape, &mut report)?;
        let made = self.made(session, &clips[0], (way, still.as_ref(), start.as_ref()), used)?;
        session.watch.finish();
        report.stage("synthesis");
        (report.options, report.stats) = (made.options.clone(), made.stats.clone());
        if !made.complete {
            return Err(self.write.interrupted(session, &mut report, &clips, &made));
        }
        session.check_signal()?;
        self.write.tell_left_over(session, clips.iter().map(|clip| &*clip.path), (most, &made))?;
        let outputs = self.write.outputs(&mut report, session, (&clips, still.as_ref()), (&made, streams))?;
        let line = self.told(&made, &report);
        Ok(Done::made(report, line, outputs))
    }

    /// What was made, in a line.
    fn told(&self, made: &ClipOutcome, report: &Report) -> String {
        let name = shown(&self.write.output);
        let (more, of) = (self.write.more(made), self.read.between(&made.stats["jump"]));
        format!("{name}: {}{of}{more}, in {:.2} s", made.how, report.elapsed())
    }

    /// The way, what it holds at once, and whether the clip is read again instead of being held: a jump alone where one
    /// may close and what would be woven in its place is too large, and no more than the frames around it where the
    /// clip is too large as well.
    fn affordable(&self, session: &Session<'_>, clips: &[ClipInput], way: Way) -> Result<(Way, Bytes, bool), Failure> {
        let fits = |needed: &Bytes| needed.0 <= session.limits.memory;
        if !way.jumps() {
            let held = self.in_windows(session, clips, way.clone())?;
            let again = Way { is_read_again: true, ..way };
            if fits(&held.1) || !self.may_be_streamed(session) {
                return Ok((held.0, held.1, false));
            }
            let (way, needed) = self.in_windows(session, clips, again)?;
            if !fits(&needed) || way.at_once.is_none() {
                return Ok((held.0, held.1, false));
            }
            session.detail(&format!("the clip is read again for what is written: to hold it takes about {}", held.1));
            return Ok((way, needed, true));
        }
        let needed = self.need(session, clips, &way)?;
        // Only whether it may weave decides about the output.
        let chosen = match way.or_woven {
            true => self.need_on(session, clips, &way, Some(&chosen_on()?))?,
            false => needed,
        };
        if fits(&chosen) {
            return Ok((way, needed, false));
        }
        let alone = Way { or_woven: false, ..way.clone() };
        let of_jump =
            Some((self.need(session, clips, &alone)?, false)).filter(|(needed, _)| way.or_woven && fits(needed));
        let of_frames =
            || Some((self.need_of_frames(clips, &alone), true)).filter(|_| self.may_read_again(session, clips, &alone));
        let Some((less, again)) = of_jump.or_else(of_frames) else { return Ok((way, needed, false)) };
        if way.or_woven && fits(&less) {
            let what = format!("is of a jump even if it does not close, since to weave instead takes about {chosen}");
            session.warn(&self.write.output, &what);
        }
        if again && fits(&less) {
            let whole = self.need(session, clips, &alone)?;
            session.detail(&format!("the clip is read again for each step: to hold it takes about {whole}"));
        }
        Ok((alone, less, again))
    }

    /// As many frames at once as memory holds on [`CHOSEN_ON`] threads, of what is woven, and what they take on these,
    /// or on those that there are, whichever is more.
    fn in_windows(&self, session: &Session<'_>, clips: &[ClipInput], way: Way) -> Result<(Way, Bytes), Failure> {
        let options = self.woven.options(&way, self.transition.measure(), self.transition.levels())?;
        let Some(may) = self.woven.may_be_at_once(clips[0].domain(), &way, &options) else {
            return self.need(session, clips, &way).map(|needed| (way, needed));
        };
        let pool = chosen_on()?;
        let fits = |needed: &Bytes| needed.0 <= session.limits.memory;
        let need = |way: &Way| self.need_on(session, clips, way, Some(&pool));
        let whole = need(&way)?;
        let by = |frames: u32| {
            let way = Way { at_once: Some(frames), ..way.clone() };
            need(&way).map(|needed| (way, needed))
        };
        let (mut best, mut least, mut most) = (by(*may.start())?, *may.start(), *may.end());
        let here = |(way, told): (Way, Bytes)| self.need(session, clips, &way).map(|needed| (way, needed.max(told)));
        if fits(&whole) || whole <= best.1 {
            return here((way, whole));
        }
        while least < most {
            let middle = least + (most - least).div_ceil(2);
            let tried = by(middle)?;
            if fits(&tried.1) { (best, least) = (tried, middle) } else { most = middle - 1 }
        }
        if fits(&best.1) {
            let what = format!(
                "is woven {least} frames at once, since all of them take about {whole}; with more memory it is another \
                 clip, with --at-once {least} the same"
            );
            session.warn(&self.write.output, &what);
        }
        here(best)
    }

    /// Goes that way; weaves where no jump closes, if it may.
    fn made(
        &self,
        session: &Session<'_>,
        clip: &Clip,
        (mut way, still, start): (Way, Option<&Still>, Option<&ClipMaps>),
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let mut refused = None;
        if way.jumps() {
            let period = self.period(&way);
            let used = of_jump(used.clone(), &way, self.transition.levels_of(clip.plane.domain()));
            let made = self.transition.made(session, clip, (&way, period, still), &self.write, used)?;
            let step = made.step.filter(|step| way.or_woven && made.complete && CLOSES < *step);
            let Some(step) = step else { return Ok(made) };
            way.fall_back(format!("the best jump makes steps {step:.2} times the largest that is usual"));
            refused = Some((step, made));
        }
        let exemplars = clip.exemplars()?;
        let material =
            Material { exemplars: &exemplars, path: &clip.path, fingerprint: &clip.fingerprint, frames: &clip.frames };
        let woven = self.weave(session, material, (&way, still, start), used)?;
        Ok(better(refused, woven))
    }

    /// Weaves.
    fn weave(
        &self,
        session: &Session<'_>,
        clip: Material<'_>,
        (way, still, start): (&Way, Option<&Still>, Option<&ClipMaps>),
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let [frames, height, width] = way.output.shape;
        let used = told::of_mode(used, false).set("mode", name_of(way.mode)).set("frames", frames);
        let used = used.set("size", format!("{width}x{height}")).set("keep", (0 < way.keep).then_some(way.keep));
        let seam = self.transition.measure();
        let under = Under { way, seam, levels: self.transition.levels(), still, start };
        self.woven.made(session, clip, under, &self.write, used)
    }
}

/// Threads on which what memory holds is told.
fn chosen_on() -> Result<rayon::ThreadPool, Failure> {
    let refused = |e| Failure::new(6, format!("the system starts no threads ({e})")).remedy("free some memory");
    rayon::ThreadPoolBuilder::new().num_threads(CHOSEN_ON).build().map_err(refused)
}

/// Without the options that do nothing for a jump.
fn of_jump(used: Used, way: &Way, levels: Option<u32>) -> Used {
    let used = told::of_mode(used, true).without("mode").set("levels", levels).unless("levels", Value::Null);
    if way.play.is_some() { used } else { used.without("play").without("frames") }
}

/// What was woven, unless the jump that was refused for it steps less.
fn better(refused: Option<(f64, ClipOutcome)>, woven: ClipOutcome) -> ClipOutcome {
    match (refused, woven.step) {
        (Some((step, mut jump)), Some(worst)) if woven.complete && step <= worst => {
            jump.how += &format!(" (it does not close, but temporal makes steps of {worst:.2})");
            jump.stats["why"] = format!("temporal makes steps {worst:.2} times the largest that is usual").into();
            jump
        }
        _ => woven,
    }
}
