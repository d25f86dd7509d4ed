//! `selvedge inspect CLIP`: whether it closes, where it could jump, and what its frames are like.

use selvedge_analysis::{Kind, Texture};
use selvedge_core::{Bytes, Domain, Exemplars};
use selvedge_graphcut_textures::video::{Closure, DistanceOptions, FrameDistances, Jump, JumpOptions, step};
use selvedge_io::clip::{ClipInfo, frame_of};
use serde_json::{Value, json};

use super::{Inspect, described, kind, of_1, structures};
use crate::clips::{self, Clip, ClipInput};
use crate::failure::{Failure, n, shown};
use crate::memory;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::quoted;

/// Jumps that are told: what cannot be used of the first may be of another.
const JUMPS: usize = 3;

/// What a clip is like.
struct Look {
    /// The step over its end beside what is usual.
    end: Closure,
    /// The best jumps, and their steps.
    jumps: Vec<(Jump, Closure)>,
    /// The frame in the middle.
    frame: Texture,
}

impl Inspect {
    /// Runs the command on a clip.
    pub(super) fn clip(&self, session: &Session<'_>, mut report: Report, clip: ClipInput) -> Result<Done, Failure> {
        if !self.guide.is_empty() {
            let failure = Failure::new(2, "--guide is about pictures, and this is a clip").about(&self.exemplar);
            return Err(failure.remedy("leave it out, or give one frame"));
        }
        let needed = need(&clip);
        memory::check_fixed(&session.limits, needed).map_err(|e| e.about(&self.exemplar))?;
        report.estimate = Some(needed.0);
        let clip = clip.read(session, &mut report)?;
        report.stage("read");
        session.watch.busy("inspect");
        let look = Look::at(session, &clip)?;
        report.stage("inspect");
        let command = self.command_of(&look.end);
        report.stats = look.json(&clip.info, &command);
        let text = format!("{}\n{}", shown(&self.exemplar), look.text(&clip.info));
        Ok(Done::answered(report, format!("{text}  try: {}\n", selvedge_io::one_line(&command))))
    }

    /// A command line to begin with: a loop, or more of one that is there.
    fn command_of(&self, end: &Closure) -> String {
        let plane = clips::plane_name(&self.exemplar);
        let stem = if self.exemplar.is_dir() { self.exemplar.file_name() } else { plane.file_stem() };
        let stem = stem.unwrap_or_default().to_string_lossy();
        let name = quoted(&self.exemplar.to_string_lossy());
        if end.closes() {
            return format!("selvedge video {name} -o {} --repeat 2", quoted(&format!("{stem}-twice.####.png")));
        }
        format!("selvedge video {name} -o {}", quoted(&format!("{stem}-loop.####.png")))
    }
}

impl Look {
    fn at(session: &Session<'_>, clip: &Clip) -> Result<Self, Failure> {
        let about = |failure: Failure| failure.about(&clip.path);
        let exemplars = clip.exemplars()?;
        let features = &exemplars.sources()[0].features;
        let usual = clip.usual(features)?;
        let over = |from, to| usual.closure(std::iter::once(step(features, from, to)));
        let (run, of_jumps) = (session.run(), JumpOptions { count: JUMPS, ..JumpOptions::default() });
        let distances = FrameDistances::new(&exemplars, &DistanceOptions::default(), &run);
        // A signal is why, or nothing is.
        let jumps = distances.and_then(|distances| distances.best(&of_jumps, &run));
        let jumps = jumps
            .or_else(|e| session.check_signal().and(Err(about(e.into()))))?
            .into_iter()
            .map(|jump| (jump, over(jump.from, jump.to)));
        // What is measured of space is no matter of time.
        let frame = frame_of(&clip.plane, clip.info.frames / 2).map_err(|e| about(e.into()))?;
        let frame = Exemplars::of(&[std::slice::from_ref(&frame)]).map_err(|e| about(e.into()))?;
        let source = &frame.sources()[0];
        let texture = Texture::of(&source.features, source.valid.as_deref(), frame.weights());
        let texture = texture.map_err(|e| about(Failure::of(e.kind(), &e, e.remedy())))?;
        Ok(Self { end: over(clip.info.frames - 1, 0), jumps: jumps.collect(), frame: texture })
    }

    /// True if frames are a texture: what is in one place could be in another.
    fn is_everywhere(&self) -> bool {
        !self.frame.is_uneven() && matches!(self.frame.kind, Kind::Stochastic | Kind::Objects | Kind::Lattice)
    }

    /// For programs.
    fn json(&self, info: &ClipInfo, command: &str) -> Value {
        let beside = |closure: &Closure| json!({ "whole": closure.whole, "block": closure.block });
        let jump = |(jump, over): &(Jump, Closure)| {
            let mut told = beside(over);
            (told["from"], told["to"], told["period"]) = (jump.from.into(), jump.to.into(), jump.period().into());
            told
        };
        json!({
            "container": info.container,
            "frames": info.frames,
            "width": info.width,
            "height": info.height,
            "channels": info.channels,
            "alpha": info.alpha,
            "depth": info.depth.name(),
            "rate": info.rate.map(|rate| rate.to_string()),
            "closes": self.end.closes(),
            "end": beside(&self.end),
            "jumps": self.jumps.iter().map(jump).collect::<Value>(),
            "kind": kind(self.frame.kind),
            "shade": of_1(self.frame.shade),
            "feature_size": self.frame.feature_size,
            "everywhere": self.is_everywhere(),
            "command": command,
        })
    }

    /// For people.
    fn text(&self, info: &ClipInfo) -> String {
        let ClipInfo { width, height, frames, channels, container, .. } = info;
        let rate = info.rate.map_or(String::new(), |rate| format!(", {rate} a second"));
        let jump = |(jump, over): &(Jump, Closure)| {
            format!("{},{} ({}, {:.2})", jump.from, jump.to, n("frame", jump.period() as usize), over.whole)
        };
        let jumps: Vec<String> = self.jumps.iter().map(jump).collect();
        let (closes, whole, block) = (if self.end.closes() { "yes" } else { "no" }, self.end.whole, self.end.block);
        let elsewhere = match self.is_everywhere() {
            true => "alike everywhere: --mode spacetime makes other sizes",
            false => "not alike everywhere: loops keep them",
        };
        let lines = [
            format!(
                "{container}, {frames} frames of {width}x{height} px{rate}, {channels} channel(s), {}",
                info.depth.name()
            ),
            format!("closes: {closes}; over its end {whole:.2} of what is usual, {block:.2} in the worst block"),
            format!("jumps: {}", jumps.join(", ")),
            format!("frames: {}, structures {}; {elsewhere}", described(&self.frame), structures(&self.frame)),
        ];
        lines.map(|line| format!("  {line}\n")).concat()
    }
}

/// An upper bound of what it takes: the clip, its features, and what is made of them.
fn need(clip: &ClipInput) -> Bytes {
    let (domain, info) = (clip.domain(), clip.info());
    let [_, h, w] = domain.shape;
    let (frame, colors) = (Domain::open([h, w]), info.channels - usize::from(info.alpha));
    let looked = memory::picture(frame, info.channels, info.depth)
        + memory::sources(&[frame], colors)
        + selvedge_analysis::estimate_texture(frame, colors, info.alpha);
    memory::PROGRAM
        + clip.bytes()
        + memory::sources(&[domain], colors)
        + FrameDistances::bytes(domain, colors).max(looked)
}
