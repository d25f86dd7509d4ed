//! Frame after frame.

use selvedge_core::{Domain, Event, Observer, Plane, Render as _, Run, SourceMap};
use selvedge_io::Metadata;
use selvedge_io::clip::ClipWriter;
use selvedge_texture_optimization::{Animation, Animator, FrameStats, Optimized, Options, Plan};
use serde_json::{Value, json};

use super::Animate;
use super::body::Body;
use super::flow::Flows;
use crate::commands::optimize::{self, Beginning};
use crate::failure::Failure;
use crate::loaded::ExemplarSet;
use crate::outputs::Outputs;
use crate::report::Report;
use crate::session::Session;
use crate::watch::Watch;
use crate::{made, names};

/// Sees each frame as one step.
struct Quiet<'w>(&'w Watch);

impl Observer<2> for Quiet<'_> {
    fn event(&self, _: &Event<'_, 2>) {}

    fn cancelled(&self) -> bool {
        Observer::<2>::cancelled(self.0)
    }
}

impl Animate {
    /// Makes the frames and writes them: those of a sequence one by one, so that what is there stays if the run is
    /// ended.
    pub(super) fn frames(
        &self,
        session: &Session<'_>,
        loaded: &ExemplarSet,
        first: SourceMap<2>,
        (flows, body, frames, options): (&Flows, Option<&Body>, u32, &Animation),
        report: &mut Report,
    ) -> Result<Outputs, Failure> {
        let path = names::of_plane(&self.output, &self.input.exemplars[0]);
        let others = flows.fingerprint.iter().chain(body.map(|body| &body.fingerprint)).cloned();
        let fingerprints = loaded.all_fingerprints().into_iter().chain(others).collect();
        let own = ("animate", session.global.seed());
        let provenance = made::provenance(own, report.options.clone(), loaded.given(), fingerprints);
        let metadata = Metadata { provenance: Some(provenance), ..loaded.metadata.clone() };
        let mut writer = ClipWriter::create(&path, frames, metadata, self.write_options())?;
        let payload: Vec<&Plane<2>> = loaded.payload.iter().collect();
        let quiet = Quiet(&session.watch);
        let run = Run { observer: &quiet, ..session.run() };
        let mut animator = Animator::new(&loaded.exemplars, first, options, &run)?;
        let mut counts = Vec::new();
        for frame in 0..frames {
            if self.close.is_some_and(|close| frame + close == frames) {
                let within = |frame: u32| body.map(|body| body.at((frame + 1) % frames));
                animator.close((frame..frames).map(|frame| (flows.after(frame), within(frame))), &run)?;
            }
            if 0 < frame {
                let within = body.map(|body| body.at(frame - 1));
                let woven = animator.next(flows.after(frame - 1), within, &run)?;
                counts.push(count(&woven.stats));
            }
            session.check_signal()?;
            let whole = animator.frame().render(&payload)?;
            let plane = if let Some(body) = body { body.shown(frame, whole)? } else { whole };
            if let Some((path, bytes)) = writer.encoded(&plane)? {
                selvedge_io::write_bytes(&path, &bytes, session.global.no_clobber)?;
            }
            Observer::<2>::event(&session.watch, &Event::<2>::step("frames", u64::from(frame) + 1, u64::from(frames)));
        }
        report.stage("synthesis");
        report.stats = json!({ "frames": counts });
        let mut outputs = Outputs::default();
        writer.ended()?.into_iter().for_each(|(path, bytes)| outputs.bytes(&path, bytes));
        report.stage("encode");
        Ok(outputs)
    }
}

/// A full synthesis. `[Kwatra05 4.1]`
pub(super) fn first_frame(
    session: &Session<'_>,
    loaded: &ExemplarSet,
    output: Domain<2>,
    (beginning, options): (&Beginning<'_>, &Options),
) -> Result<SourceMap<2>, Failure> {
    let run = session.run();
    let plan = Plan::new(&loaded.exemplars, output, options, &run).map_err(|e| optimize::failure(loaded, e))?;
    let begun = beginning.weave(&run)?.map(|woven| woven.result);
    session.check_signal()?;
    let woven = plan.weave(begun.as_ref(), &Default::default(), &run)?;
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
