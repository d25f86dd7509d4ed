//! `selvedge video`: video textures.

mod choices;
mod fade;
mod look;
mod maps;
mod modes;
mod read;
mod still;
mod transition;
mod woven;
mod written;

use clap::Args;
use selvedge_core::{Bytes, Domain, Plane, SourceMap};
use selvedge_graphcut_textures::video::{self, FrameDistances};
use serde_json::Value;

use self::modes::{ModeArgs, PlayArg, Way};
use self::read::ReadArgs;
use self::still::{Still, StillArgs};
use self::transition::TransitionArgs;
use self::woven::WovenArgs;
use self::written::WriteArgs;
use crate::clips::{Clip, ClipInput};
use crate::failure::{Failure, n, shown};
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
    #[command(flatten)]
    write: WriteArgs,
}

/// What a mode made.
struct Made {
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

impl Video {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let (mut report, clip) = (Report::new("video"), &self.read.clip);
        let others: Vec<_> = self.transition.file().into_iter().chain(self.still.file()).cloned().collect();
        inputs::check_streams(self.read.paths().chain(&others))?;
        self.write.check_names(self.read.paths().count())?;
        let clips = self.read.open(session, self.write.rate)?;
        let way = self.way(&clips[0])?;
        self.write.check(session, &self.read, (&clips, &way), &others)?;
        let needed = self.need(&clips, &way)?;
        memory::check_fixed(&session.limits, needed).map_err(|e| e.about(clip))?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        let used = session.options.clone().unless("with", Value::Null).unless("fixed", Value::Null);
        let used = used.unless("still-frame", Value::Null);
        let name = shown(&self.write.output);
        if session.global.dry_run {
            report.options = used;
            let line = format!("{name}: would be {}, with about {needed} of memory", self.would(&clips[0], &way));
            return Ok(Done::would(report, line));
        }
        let clips = clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()?;
        report.stage("read");
        let still = self.still.read(session, clips[0].plane.domain().shape, &mut report)?;
        let made = self.made(session, &clips[0], (way, still.as_ref()), used)?;
        session.watch.finish();
        report.stage("synthesis");
        (report.options, report.stats) = (made.options.clone(), made.stats.clone());
        if !made.complete {
            return Err(self.write.interrupted(session, &mut report, &clips, &made));
        }
        session.check_signal()?;
        let outputs = self.write.outputs(&mut report, session, &clips, &made)?;
        let line = format!("{name}: {}, in {:.2} s", made.how, report.elapsed());
        Ok(Done::made(report, line, outputs))
    }

    /// Which way the clip goes on.
    fn way(&self, clip: &ClipInput) -> Result<Way, Failure> {
        let of_jumps = self.transition.typed().or(self.write.surface.is_some().then_some("--surface"));
        let way = self.mode.way(clip, self.write.filled(), (of_jumps, self.woven.typed()))?;
        self.still.check(clip, way.output)?;
        if !way.loops() && (1 < self.write.repeat || self.write.closing_frame) {
            let what = "--repeat and --closing-frame are for loops that are written whole";
            return Err(Failure::new(2, what).remedy("leave them out, or use --loop periodic without --play"));
        }
        if let (Some(PlayArg::Random), Some(surface)) = (way.play, &self.write.surface) {
            let failure = Failure::new(2, "a walk by several jumps has no one surface").about(surface);
            return Err(failure.remedy("leave --surface out, or use --play loop"));
        }
        if way.jumps() && way.play.is_none() && self.mode.frames().is_some() && self.transition.says_period() {
            let what = "--frames and --period or --jump both say how long the loop is";
            return Err(Failure::new(2, what).remedy("leave one of them out"));
        }
        Ok(way)
    }

    /// Goes that way; weaves where no jump closes, if it may.
    fn made(
        &self,
        session: &Session<'_>,
        clip: &Clip,
        (mut way, still): (Way, Option<&Still>),
        used: Used,
    ) -> Result<Made, Failure> {
        let seam = self.transition.measure();
        if way.jumps() {
            let period = way.period(self.mode.frames().or(self.write.filled()).is_some());
            let used = of_mode(used.clone(), true).without("mode");
            let used = if way.play.is_some() { used } else { used.without("play").without("frames") };
            let made = self.transition.made(session, clip, (&way, period, still), &self.write, used)?;
            let step = made.step.filter(|step| way.or_woven && made.complete && CLOSES < *step);
            let Some(step) = step else { return Ok(made) };
            way.fall_back(format!("the best jump makes steps {step:.2} times the largest that is usual"));
        }
        let [frames, height, width] = way.output.shape;
        let used = of_mode(used, false).set("mode", name_of(way.mode)).set("frames", frames);
        let used = used.set("size", format!("{width}x{height}")).set("keep", (0 < way.keep).then_some(way.keep));
        self.woven.made(session, clip, (&way, seam, still), &self.write, used)
    }

    /// What a run would make, in words.
    fn would(&self, clip: &ClipInput, way: &Way) -> String {
        let [frames, h, w] = if way.jumps() { clip.domain().shape } else { way.output.shape };
        if way.play.is_some() {
            return format!("{} of {w}x{h} px by jumps", n("frame", way.output.shape[0] as usize));
        }
        match (way.jumps(), way.loops()) {
            (true, _) => format!("a loop of at most {frames} frames of {w}x{h} px by a jump"),
            (false, true) => format!("a loop of {frames} frames of {w}x{h} px, {}", name_of(way.mode)),
            (false, false) => format!("a clip of {frames} frames of {w}x{h} px, {}", name_of(way.mode)),
        }
    }

    /// An upper bound of the memory of a run.
    fn need(&self, clips: &[ClipInput], way: &Way) -> Result<Bytes, Failure> {
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let kept: Bytes = clips.iter().map(ClipInput::bytes).sum();
        let colors = info.channels - usize::from(info.alpha);
        let features = memory::sources(&[domain], colors);
        let mut work = Bytes(0);
        if way.jumps() {
            let options = self.transition.options();
            work = video::estimate(domain, colors, &options) + FrameDistances::bytes(domain.shape[0]);
            // A walk keeps the surface of each jump.
            work += Bytes::of_samples(domain, 2) * u64::from(way.play.is_some());
        }
        if way.weaves() {
            let options = self.woven.options(way, self.transition.measure())?;
            work = work.max(self.woven.bytes(domain, colors, way, &options));
        }
        // The map, one rendered clip, and all of them as files that were not compressed.
        let longest = Bytes::of_samples(Domain::open(way.most(domain)), 1);
        work += self.still.bytes(longest);
        let times = |bytes: Bytes| Bytes(bytes.0.saturating_mul(longest.0) / Bytes::of_samples(domain, 1).0.max(1));
        let most = clips.iter().map(ClipInput::bytes).max().unwrap_or_default();
        let maps = if self.write.map.is_some() { longest * 12 } else { Bytes(0) };
        let output = longest * 4 + times(most) + times(kept) * u64::from(self.write.repeat) + maps + Bytes(64 << 20);
        Ok(memory::PROGRAM + kept + features * 2 + work.max(output))
    }
}

/// A jump closes if no step of a whole frame over its seam is larger than what is usual by more than this: less is not
/// told from chance with a hundredth of some dozens of steps.
const CLOSES: f64 = 1.05;

/// Without the options that do nothing for what is cut at a jump, or for what is woven.
fn of_mode(used: Used, jumps: bool) -> Used {
    const OF_JUMPS: [&str; 7] = ["period", "window", "jumps", "jump", "surface-from", "blend", "play"];
    const OF_WOVEN: [&str; 12] = [
        "size",
        "tile",
        "loop",
        "keep",
        "placement",
        "region",
        "reach",
        "randomness",
        "variety",
        "refine",
        "patience",
        "tries",
    ];
    let idle: &[&str] = if jumps { &OF_WOVEN } else { &OF_JUMPS };
    idle.iter().fold(used, |used, option| used.without(option))
}
