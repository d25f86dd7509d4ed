//! Jumps of clips that are not held: they are read again for each step, of which each needs a few frames at once.

use selvedge_core::{Bytes, Domain};
use selvedge_graphcut_textures::video::{self, DistanceOptions, Footage, FrameDistances, Loop, LoopOptions};

use super::modes::{PlayArg, Way};
use super::transition::TransitionArgs;
use super::written::WriteArgs;
use super::{ClipOutcome, Video, of_jump};
use crate::clips::{self, ClipInput};
use crate::failure::Failure;
use crate::memory;
use crate::reel::Reel;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;

impl Video {
    /// Whether a few frames at once are enough.
    pub(super) fn may_read_again(&self, session: &Session<'_>, clips: &[ClipInput], way: &Way) -> bool {
        let one_jump = way.play != Some(PlayArg::Random) && self.still.file().is_none() && !self.transition.is_faded();
        one_jump && !session.global.keep_partial && self.write.needs_few_frames() && clips.iter().all(Reel::holds)
    }

    /// Cuts a jump of a clip that is read again for each step.
    pub(super) fn reread(
        &self,
        session: &Session<'_>,
        mut report: Report,
        (clips, way, most): (Vec<ClipInput>, &Way, u32),
        used: Used,
    ) -> Result<Done, Failure> {
        let options = self.read.options(session, self.write.rate);
        let reels = clips.into_iter().map(|clip| Reel::new(session, clip, &options)).collect::<Result<Vec<_>, _>>()?;
        let clip = reels[0].table().sources()[0].1;
        let used = of_jump(used, way, self.transition.levels_of(clip));
        let period = self.period(way);
        let (made, looped) = self.transition.reread(session, &reels[0], (way, period), &self.write, used)?;
        session.watch.finish();
        report.stage("synthesis");
        (report.options, report.stats) = (made.options.clone(), made.stats.clone());
        reels[1..].iter().try_for_each(Reel::pass)?;
        let noted = reels.iter().map(|reel| reel.noted(&mut report)).collect::<Result<Vec<_>, _>>()?;
        self.write.tell_left_over(session, reels.iter().map(|reel| &*reel.path), (most, &made))?;
        let outputs =
            self.write.reread(session, (&reels, &noted), &made, &mut |number, t| reels[number].of_loop(&looped, t))?;
        report.stage("encode");
        let line = self.told(&made, &report);
        Ok(Done::made(report, line, outputs))
    }

    /// The same where no more of a clip is held than the frames around a jump: those that are compared at once take no
    /// more than its cut. What is written in one file is made there.
    pub(super) fn need_of_frames(&self, clips: &[ClipInput], way: &Way) -> Bytes {
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let colors = info.channels - usize::from(info.alpha);
        let work =
            video::estimate(domain, colors, &self.transition.options(domain)) + FrameDistances::bytes(domain, colors);
        let readers: Bytes = clips.iter().map(Reel::bytes).sum();
        let frames = self.write.written(way.most(domain)[0]).max(domain.shape[0]);
        let file = |clip: &ClipInput| Bytes(clip.bytes().0 / u64::from(domain.shape[0]) * u64::from(frames) * 2);
        let files: Bytes = if clips::is_pattern(&self.write.output) { Bytes(0) } else { clips.iter().map(file).sum() };
        memory::PROGRAM + work.max(files) + readers + Bytes(8 << 20)
    }
}

impl TransitionArgs {
    /// The same of a clip of which no more is held than the frames around a jump, and the loop.
    pub(super) fn reread(
        &self,
        session: &Session<'_>,
        reel: &Reel<'_>,
        (way, period): (&Way, Option<u32>),
        write: &WriteArgs,
        used: Used,
    ) -> Result<(ClipOutcome, Loop), Failure> {
        let held = held(reel, &self.options(reel.table().sources()[0].1));
        let run = session.run();
        let compare = || FrameDistances::new(reel, &DistanceOptions { held }, &run);
        let distances = self.compares(reel, false).then(compare).transpose().or_else(|e| {
            session.check_signal()?;
            Err(reel.failure(e))
        })?;
        let jumps = self.found(session, distances.as_ref(), period).map_err(|e| e.about(&reel.path))?;
        let woven = self.looped(session, reel, &jumps).map_err(|e| reel.failure(e))?;
        session.check_signal()?;
        let (result, stats) = (woven.result, woven.stats);
        let closure = match stats.tried.get(stats.chosen) {
            Some(tried) => tried.closure,
            None => result.closure(reel).map_err(|e| reel.failure(e))?,
        };
        let closes = distances.is_some_and(|d| d.closes() && result.jump.period() == d.frames());
        let made = self.outcome((&result, &stats), (Some(closure), closes), (way, write), used)?;
        Ok((made, result))
    }
}

/// Frames of a clip that take no more than the cut of a jump will.
fn held(reel: &Reel<'_>, options: &LoopOptions) -> u32 {
    let (clip, channels) = (reel.table().sources()[0].1, reel.weights().len());
    let frame = Bytes::of_samples(Domain::open([1, clip.shape[1], clip.shape[2]]), channels as u64 + 1);
    (video::estimate(clip, channels, options).0 / frame.0.max(1)).clamp(1, u64::from(u32::MAX)) as u32
}
