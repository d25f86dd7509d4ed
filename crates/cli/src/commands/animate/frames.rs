//! Frame after frame.

use std::path::Path;

use selvedge_core::{Domain, Event, Exemplars, Observer, Plane, Render as _, Run, SourceMap};
use selvedge_io::Metadata;
use selvedge_io::clip::ClipWriter;
use selvedge_texture_optimization::{Animation, Animator, Beside, FrameStats, Optimized, Options, Plan};
use serde_json::{Value, json};

use super::begun::{self, Begun};
use super::body::Body;
use super::flow::Flows;
use super::{Animate, drift};
use crate::commands::optimize::{self, Beginning};
use crate::failure::Failure;
use crate::kept::Kept;
use crate::loaded::ExemplarSet;
use crate::outputs::{self, Outputs};
use crate::report::Report;
use crate::session::Session;
use crate::stdio::STREAM;
use crate::watch::Watch;
use crate::{clips, made, stdio};

/// Sees each frame as one step.
struct Quiet<'w>(&'w Watch);

impl Observer<2> for Quiet<'_> {
    fn event(&self, _: &Event<'_, 2>) {}

    fn cancelled(&self) -> bool {
        Observer::<2>::cancelled(self.0)
    }
}

/// What is done with a frame, of an animator that has come to it, with the counts of all frames so far.
type Taken<'t> = dyn FnMut(Plane<2>, &Animator<'_>, &[Value]) -> Result<(), Failure> + 't;

impl Animate {
    /// Makes the frames and writes them: those of a sequence one by one, so that what is there stays if the run is
    /// ended.
    pub(super) fn frames(
        &self,
        session: &Session<'_>,
        (loaded, textures): (&ExemplarSet, &[Exemplars<2>]),
        (begun, kept): (Begun, &Kept<'_>),
        (output, flows, body, frames, options): (Domain<2>, &Flows, Option<&Body>, u32, &Animation),
        report: &mut Report,
    ) -> Result<Outputs, Failure> {
        let path = self.path();
        let others = flows.fingerprint.iter().chain(body.map(|body| &body.fingerprint)).cloned();
        let fingerprints = loaded.all_fingerprints().into_iter().chain(others).collect();
        let own = ("animate", session.global.seed());
        let provenance = made::provenance(own, report.options.clone(), loaded.given(), fingerprints);
        let metadata = Metadata { provenance: Some(provenance), ..loaded.metadata.clone() };
        let mut writer = ClipWriter::create(&path, frames, metadata, self.write_options())?;
        begun.lead(&mut writer)?;
        // A frame that was written after the last checkpoint is written once more.
        let no_clobber = session.global.no_clobber && !self.kept.is_resumed();
        let (mut counts, mut written) = (begun.counts(), 0);
        let making = (begun, flows, body, (output, options));
        let mut take = |plane, animator: &Animator<'_>, counts: &[Value]| {
            let Some((path, bytes)) = writer.encoded(&plane)? else { return Ok(()) };
            if written == 0 {
                forget(&writer)?;
            }
            selvedge_io::write_bytes(&path, &bytes, no_clobber)?;
            written += 1;
            // There is nothing to go on to after the last one.
            if writer.taken() < frames {
                begun::keep(kept, animator, (counts, &writer));
            }
            Ok(())
        };
        let made = self.each(session, (loaded, textures), making, (frames, &mut counts), &mut take);
        if let Err(failure) = made {
            return Err(match session.watch.signal() {
                Some(signal) if written == 0 => partial(session, signal, (&path, writer)).unwrap_or(failure),
                signal => failure.among(signal.is_some(), "frame", written),
            });
        }
        report.stage("synthesis");
        if let Some(drift) = drift::told(&counts) {
            session.warn(&path, &drift);
        }
        report.stats = json!({ "frames": counts });
        let mut outputs = Outputs::default();
        outputs.clip_end(&path, writer, (output.shape, frames), (self.rate, None))?;
        report.stage("encode");
        Ok(outputs)
    }

    /// Makes one frame after the other, and hands each on.
    fn each(
        &self,
        session: &Session<'_>,
        (loaded, textures): (&ExemplarSet, &[Exemplars<2>]),
        (begun, flows, body, (output, options)): (Begun, &Flows, Option<&Body>, (Domain<2>, &Animation)),
        (frames, counts): (u32, &mut Vec<Value>),
        taken: &mut Taken<'_>,
    ) -> Result<(), Failure> {
        let payload: Vec<&Plane<2>> = loaded.payload.iter().collect();
        let quiet = Quiet(&session.watch);
        let run = Run { observer: &quiet, ..session.run() };
        let texture = |frame: u32| &textures[frame as usize % textures.len()];
        let mut beside = vec![None; textures.len()];
        let there = counts.len() as u32;
        let mut animator = begun.animator((texture(there.saturating_sub(1)), output), options, &run)?;
        for frame in there..frames {
            // What closes has to be told so again where it goes on.
            if let Some(closing) = self.close.map(|close| frames - close)
                && (frame == closing || (frame == there && closing < frame))
            {
                let within = |frame: u32| body.map(|body| body.at((frame + 1) % frames));
                animator.close((closing..frames).map(|frame| (flows.after(frame), within(frame))), &run)?;
            }
            let texture = texture(frame);
            let mut count = json!({});
            if 0 < frame {
                let within = body.map(|body| body.at(frame - 1));
                if 1 < textures.len() {
                    animator.turn_to(texture, &run)?;
                }
                let woven =
                    animator.next(flows.after(frame - 1), within, &run).map_err(|e| optimize::failure(loaded, e))?;
                count = self::count(&woven.stats);
            }
            let own = beside[frame as usize % textures.len()].get_or_insert_with(|| Beside::new(texture));
            let shown = own.shown(animator.frame())?;
            (count["sharpness"], count["completeness"]) = (shown.sharpness.into(), shown.completeness.into());
            counts.push(count);
            session.check_signal()?;
            // A frame of a clip names that frame alone.
            let shown = if textures.len() == 1 { payload.len() } else { frame as usize % textures.len() + 1 };
            let whole = animator.frame().render(&payload[..shown])?;
            let whole = if let Some(body) = body { body.shown(frame, whole)? } else { whole };
            taken(whole, &animator, counts)?;
            Observer::<2>::event(&session.watch, &Event::<2>::step("frames", u64::from(frame) + 1, u64::from(frames)));
        }
        Ok(())
    }
}

/// Writes the frames of a container that a signal ended, if that is wanted. Those of a sequence stand there by then.
fn partial(session: &Session<'_>, signal: u8, (path, writer): (&Path, ClipWriter)) -> Option<Failure> {
    let is_file = path.as_os_str() != STREAM && !clips::is_pattern(path);
    if !session.global.keep_partial || !is_file || writer.taken() == 0 {
        return None;
    }
    let file = outputs::partial(path);
    let written = writer.cut_short().map_err(Failure::from).and_then(|files| {
        let mut outputs = Outputs::default();
        files.into_iter().for_each(|(_, bytes)| outputs.bytes(&file, bytes));
        outputs.write(session)
    });
    Some(written.err().unwrap_or_else(|| Failure::kept(signal, &file)))
}

/// Takes away what an earlier run said of frames by these names, before the first of them is replaced.
fn forget(writer: &ClipWriter) -> Result<(), Failure> {
    let Some(manifest) = writer.files().pop().filter(|file| file.is_file()) else { return Ok(()) };
    let kept = |e| Failure::new(4, format!("tells of frames that are replaced, and stays: {}", stdio::plain(&e)));
    std::fs::remove_file(&manifest).map_err(|e| kept(e).about(&manifest).remedy("take it away, or name another clip"))
}

/// That of the first frame, if all others have one too.
pub(super) fn plan<'e>(
    session: &Session<'_>,
    (loaded, textures): (&ExemplarSet, &'e [Exemplars<2>]),
    output: Domain<2>,
    (first, others): (&Options, &Animation),
) -> Result<Plan<'e>, Failure> {
    let run = session.run();
    let of = |texture, options| Plan::new(texture, output, options, &run).map_err(|e| optimize::failure(loaded, e));
    textures.iter().try_for_each(|texture| of(texture, &others.frame).map(drop))?;
    of(&textures[0], first)
}

/// A full synthesis. `[Kwatra05 4.1]`
pub(super) fn first_frame(
    session: &Session<'_>,
    loaded: &ExemplarSet,
    (beginning, plan): (&Beginning<'_>, &Plan<'_>),
) -> Result<SourceMap<2>, Failure> {
    let run = session.run();
    let begun = beginning.weave(&run)?.map(|woven| woven.result);
    session.check_signal()?;
    let woven = plan.weave(begun.as_ref(), &Default::default(), &run).map_err(|e| optimize::failure(loaded, e))?;
    session.check_signal()?;
    match woven.result {
        Optimized::Map(map) => Ok(map),
        Optimized::Votes(_) => unreachable!("its finish is a map"),
    }
}

fn count(frame: &FrameStats) -> Value {
    let level = frame.stats.levels.last();
    json!({
        "carried": frame.carried,
        "energy": frame.stats.energy(),
        "robust_energy": level.and_then(|level| level.robust.last()),
        "searched": frame.stats.levels.iter().map(|level| level.searched).sum::<u64>(),
    })
}
