//! `selvedge inspect CLIP`: whether it closes, where it could jump, and what its frames are like.

use selvedge_analysis::{Kind, Texture};
use selvedge_core::{Domain, Role};
use selvedge_graphcut_textures::video::{DistanceOptions, FrameDistances, JumpOptions};
use selvedge_io::clip::ClipOptions;
use serde_json::{Value, json};

use super::{Inspect, described, kind, of_1};
use crate::clips::{self, ClipInput};
use crate::failure::{Failure, n, shown};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::steps::{Closure, Usual, step};
use crate::used::quoted;
use crate::{inputs, memory};

/// Jumps that are told: what cannot be used of the first may be of another.
const JUMPS: usize = 3;

impl Inspect {
    /// Runs the command on a clip.
    pub(super) fn clip(&self, session: &Session<'_>, mut report: Report) -> Result<Done, Failure> {
        if !self.guide.is_empty() {
            let failure = Failure::new(2, "--guide is about pictures, and this is a clip").about(&self.exemplar);
            return Err(failure.remedy("leave it out, or give one frame"));
        }
        let about = |failure: Failure| failure.about(&self.exemplar);
        let frame = inputs::options(session.limits, Role::Color, self.nonfinite);
        let clip = ClipInput::open(session, &self.exemplar, &ClipOptions { frame, ..ClipOptions::default() })?;
        let (domain, info) = (clip.domain(), clip.info().clone());
        let [frames, h, w] = domain.shape;
        let colors = info.channels - usize::from(info.alpha);
        let looked = selvedge_analysis::estimate_texture(Domain::open([h, w]), colors, info.alpha);
        let worked = memory::sources(&[domain], colors) + FrameDistances::bytes(frames).max(looked);
        let needed = memory::PROGRAM + clip.bytes() + worked;
        memory::check_fixed(&session.limits, needed).map_err(about)?;
        report.estimate = Some(needed.0);
        let clip = clip.read(session, &mut report)?;
        report.stage("read");
        session.watch.busy("inspect");
        let exemplars = clip.exemplars()?;
        let source = &exemplars.sources()[0];
        let usual = Usual::of_clip(&source.features, &self.exemplar)?;
        let over = |from, to| usual.closure(std::iter::once(step(&source.features, from, to)));
        let distances = FrameDistances::new(&exemplars, &DistanceOptions::default(), &session.run());
        let distances = distances.or_else(|e| session.check_signal().and(Err(about(e.into()))))?;
        // Clips of a few frames have no loop in them.
        let jumps = distances.best(&JumpOptions { count: JUMPS, ..JumpOptions::default() }).unwrap_or_default();
        let jumps: Vec<_> = jumps.into_iter().map(|jump| (jump, over(jump.from, jump.to))).collect();
        let texture = Texture::of(&source.features, source.valid.as_deref(), exemplars.weights());
        let texture = texture.map_err(|e| about(Failure::of(e.kind(), &e, e.remedy())))?;
        report.stage("inspect");
        let closure = over(frames - 1, 0);
        let command = self.command_of(&closure);
        let rate = info.rate.map(|rate| rate.to_string());
        report.stats = json!({
            "container": info.container,
            "frames": frames,
            "width": w,
            "height": h,
            "channels": info.channels,
            "alpha": info.alpha,
            "depth": info.depth.name(),
            "rate": rate,
            "closes": closure.closes(),
            "end": beside(&closure),
            "jumps": jumps.iter().map(|(jump, over)| {
                let mut told = beside(over);
                (told["from"], told["to"], told["period"]) = (jump.from.into(), jump.to.into(), jump.period().into());
                told
            }).collect::<Value>(),
            "kind": kind(texture.kind),
            "shade": of_1(texture.shade),
            "feature_size": texture.feature_size,
            "everywhere": is_everywhere(&texture),
            "command": command,
        });
        let jumps = jumps.iter().map(|(jump, over)| {
            format!("{},{} ({}, {:.2})", jump.from, jump.to, n("frame", jump.period() as usize), over.whole)
        });
        let jumps: Vec<String> = jumps.collect();
        let rate = rate.map_or(String::new(), |rate| format!(", {rate} a second"));
        let (kind, depth) = (described(&texture), info.depth.name());
        let elsewhere = if is_everywhere(&texture) {
            "alike everywhere: --mode spacetime makes other sizes"
        } else {
            "not alike everywhere: loops keep them"
        };
        let text = [
            format!("{}\n", shown(&self.exemplar)),
            format!(
                "  {}, {frames} frames of {w}x{h} px{rate}, {} channel(s), {depth}\n",
                info.container, info.channels
            ),
            format!(
                "  closes: {}; over its end {:.2} of what is usual, {:.2} in the worst block\n",
                if closure.closes() { "yes" } else { "no" },
                closure.whole,
                closure.block
            ),
            format!("  jumps: {}\n", if jumps.is_empty() { "none".to_owned() } else { jumps.join(", ") }),
            format!("  frames: {kind}, structures up to about {} px; {elsewhere}\n", texture.feature_size),
            format!("  try: {}\n", selvedge_io::one_line(&command)),
        ];
        Ok(Done::answered(report, text.concat()))
    }

    /// A command line to begin with: a loop, or more of one that is there.
    fn command_of(&self, closure: &Closure) -> String {
        let plane = clips::plane_name(&self.exemplar);
        let stem = if self.exemplar.is_dir() { self.exemplar.file_name() } else { plane.file_stem() };
        let stem = stem.unwrap_or_default().to_string_lossy();
        let name = quoted(&self.exemplar.to_string_lossy());
        if closure.closes() {
            return format!("selvedge video {name} -o {} --repeat 2", quoted(&format!("{stem}-twice.####.png")));
        }
        format!("selvedge video {name} -o {}", quoted(&format!("{stem}-loop.####.png")))
    }
}

/// What a step is beside what is usual.
fn beside(closure: &Closure) -> Value {
    json!({ "whole": closure.whole, "block": closure.block })
}

/// True if frames are a texture: what is in one place could be in another.
fn is_everywhere(texture: &Texture) -> bool {
    !texture.is_uneven() && matches!(texture.kind, Kind::Stochastic | Kind::Objects | Kind::Lattice)
}
