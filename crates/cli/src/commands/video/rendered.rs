//! Clips that are woven and not held: they are read again for what is written.

use std::ops::Range;

use selvedge_core::{Exemplars, Plane, SourceMap};

use super::modes::Way;
use super::woven::Material;
use super::{ClipOutcome, Video};
use crate::clip_maps::ClipMaps;
use crate::clips::ClipInput;
use crate::failure::Failure;
use crate::reel::Reel;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;

impl Video {
    /// Weaves a clip of which no more is held than its features. Frames are rendered as many at once as were woven so,
    /// each time by one pass over the clip.
    pub(super) fn rendered_again(
        &self,
        session: &Session<'_>,
        mut report: Report,
        (clips, start): (Vec<ClipInput>, Option<&ClipMaps>),
        (way, most): (&Way, u32),
        used: Used,
    ) -> Result<Done, Failure> {
        let options = self.read.options(session, self.write.rate);
        let reels = clips.into_iter().map(|clip| Reel::new(session, clip, &options)).collect::<Result<Vec<_>, _>>()?;
        let exemplars = exemplars(&reels[0])?;
        reels[1..].iter().try_for_each(Reel::pass)?;
        let noted = reels.iter().map(|reel| reel.noted(&mut report)).collect::<Result<Vec<_>, _>>()?;
        report.stage("read");
        let still = self.still.read(session, exemplars.sources()[0].domain().shape, &mut report)?;
        let frames = reels[0].frame_fingerprints();
        let clip = Material { exemplars: &exemplars, path: &reels[0].path, fingerprint: &noted[0], frames: &frames };
        let made = self.weave(session, clip, (way, still.as_ref(), start), used)?;
        session.watch.finish();
        report.stage("synthesis");
        drop(exemplars);
        (report.options, report.stats) = (made.options.clone(), made.stats.clone());
        let ended = || session.interrupted(session.watch.signal().unwrap_or(2));
        let ClipOutcome { map: Some(map), complete: true, .. } = &made else { return Err(ended()) };
        session.check_signal()?;
        self.write.tell_left_over(session, reels.iter().map(|reel| &*reel.path), (most, &made))?;
        let at_once = way.at_once.unwrap_or(made.frames);
        let shown = |reel| Shown { reel, map, at_once, of: 0..0, frames: Vec::new() };
        let mut all: Vec<Shown<'_, '_>> = reels.iter().map(shown).collect();
        let mut frame = |number: usize, t: u32| {
            // One clip is written after the other.
            all[..number].iter_mut().for_each(Shown::forget);
            all[number].frame(t)
        };
        let outputs = self.write.reread(session, (&reels, &noted), &made, &mut frame)?;
        report.stage("encode");
        let line = self.told(&made, &report);
        Ok(Done::made(report, line, outputs))
    }
}

/// A clip's features, of which alone it is woven.
fn exemplars(reel: &Reel<'_>) -> Result<Exemplars<3>, Failure> {
    let plane = reel.whole()?;
    Exemplars::of(&[std::slice::from_ref(&plane)]).map_err(|e| Failure::from(e).about(&reel.path))
}

/// Frames of a clip as they were rendered last.
struct Shown<'a, 's> {
    reel: &'a Reel<'s>,
    map: &'a SourceMap<3>,
    at_once: u32,
    of: Range<u32>,
    frames: Vec<Plane<2>>,
}

impl Shown<'_, '_> {
    fn frame(&mut self, t: u32) -> Result<Plane<2>, Failure> {
        if !self.of.contains(&t) {
            self.forget();
            let of = t..t.saturating_add(self.at_once).min(self.map.domain().shape[0]);
            (self.frames, self.of) = (self.reel.of_map(self.map, of.clone())?, of);
        }
        Ok(self.frames[(t - self.of.start) as usize].clone())
    }

    fn forget(&mut self) {
        (self.of, self.frames) = (0..0, Vec::new());
    }
}
