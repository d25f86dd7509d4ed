//! Which way `video` goes, and what options of it may not be.

use super::modes::{PlayArg, Way};
use super::{Video, blended, told};
use crate::clip_maps::ClipMaps;
use crate::clips::ClipInput;
use crate::failure::Failure;
use crate::session::Session;

impl Video {
    /// Which way the clip goes on.
    pub(super) fn way(
        &self,
        session: &Session<'_>,
        clip: &ClipInput,
        start: Option<&ClipMaps>,
    ) -> Result<Way, Failure> {
        blended::check(session, self.write.blending)?;
        let typed = |names: Vec<String>| session.first_typed(&names);
        let of_jumps = typed(told::of_jumps()).or(typed(vec!["surface".to_owned()]));
        let of_woven = typed(told::of_woven());
        let begun = start.map(|maps| maps.domain().shape);
        let mut way = self.mode.way(clip, (self.write.filled(), begun), (of_jumps.as_deref(), of_woven.as_deref()))?;
        way.at_once = self.woven.at_once(clip.domain(), &way)?;
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
        if way.jumps() {
            self.transition.periods(clip, self.period(&way))?;
        }
        Ok(way)
    }

    /// Frames that a loop of one jump has to have.
    pub(super) fn period(&self, way: &Way) -> Option<u32> {
        way.period(self.mode.frames().or(self.write.filled()).is_some())
    }
}
