//! `selvedge video`: video textures.

mod choices;
mod fade;
mod look;
mod read;
mod transition;
mod written;

use clap::Args;
use selvedge_core::{Bytes, Plane, SourceMap};

use self::read::ReadArgs;
use self::transition::TransitionArgs;
use self::written::WriteArgs;
use crate::clips::ClipInput;
use crate::failure::{Failure, shown};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;
use crate::{inputs, memory};

/// Options of `video`.
#[derive(Args, Clone, Debug)]
pub(crate) struct Video {
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    transition: TransitionArgs,
    #[command(flatten)]
    write: WriteArgs,
}

/// What a mode made.
struct Made {
    /// `None` where samples were mixed.
    map: Option<SourceMap<3>>,
    /// Frames that were mixed.
    mixed: Option<Plane<3>>,
    /// Frames after which it begins again.
    period: u32,
    options: Used,
    stats: serde_json::Value,
    how: String,
    /// Pictures beside it.
    surface: Option<Plane<2>>,
    preview: Option<Plane<2>>,
    complete: bool,
}

impl Video {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let (mut report, clip) = (Report::new("video"), &self.read.clip);
        let others: Vec<_> = self.transition.file().into_iter().cloned().collect();
        inputs::check_streams(self.read.paths().chain(&others))?;
        self.write.check_names(self.read.paths().count())?;
        let clips = self.read.open(session, self.write.rate)?;
        self.write.check(session, &self.read, &clips, &others)?;
        let needed = self.need(&clips);
        memory::check_fixed(&session.limits, needed).map_err(|e| e.about(clip))?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        let used = session.options.clone().unless("with", serde_json::Value::Null);
        let name = shown(&self.write.output);
        if session.global.dry_run {
            let [frames, h, w] = clips[0].domain().shape;
            report.options = used;
            let line =
                format!("{name}: would be a loop of {frames} frames of {w}x{h} px, with about {needed} of memory");
            return Ok(Done::would(report, line));
        }
        let clips = clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()?;
        report.stage("read");
        let made = self.transition.made(session, &clips[0], &self.write, used)?;
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

    /// An upper bound of the memory of a run.
    fn need(&self, clips: &[ClipInput]) -> Bytes {
        // For each voxel of the window: the graph, the prices of both sides of the seam, and features.
        const WINDOW: u64 = 110;
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let [frames, height, width] = domain.shape.map(u64::from);
        let kept: Bytes = clips.iter().map(ClipInput::bytes).sum();
        let colors = info.channels - usize::from(info.alpha);
        let features = memory::sources(&[domain], colors);
        let window =
            Bytes(WINDOW) * frames.min(self.transition.window.into()).saturating_mul(height).saturating_mul(width);
        let distances = Bytes(8) * frames.saturating_mul(frames);
        // The map, one rendered clip, and all of them as files that were not compressed.
        let most = clips.iter().map(ClipInput::bytes).max().unwrap_or_default();
        let output = memory::places(domain) + most + kept * u64::from(self.write.repeat) + Bytes(64 << 20);
        memory::PROGRAM + kept + features * 2 + distances + window.max(output)
    }
}
