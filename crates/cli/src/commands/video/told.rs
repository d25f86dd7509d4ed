//! What `video` tells before a run, and of its options.

use super::Video;
use super::modes::Way;
use super::transition::TransitionArgs;
use super::woven::WovenArgs;
use crate::clips::ClipInput;
use crate::failure::{Failure, n};
use crate::options::names_of;
use crate::used::Used;
use crate::values::name_of;

impl Video {
    /// What a run would make, in words.
    pub(super) fn would(&self, clip: &ClipInput, way: &Way) -> Result<String, Failure> {
        let [frames, h, w] = way.output.shape;
        if way.play.is_some() {
            return Ok(format!("{} of {w}x{h} px by jumps", n("frame", frames as usize)));
        }
        let size = format!("of {w}x{h} px");
        Ok(match (way.jumps(), way.loops()) {
            (true, _) => {
                let periods = self.transition.periods(clip, self.period(way))?;
                let (least, most) = (*periods.start(), *periods.end());
                let frames = match (least == most, self.transition.says_period()) {
                    (true, _) => n("frame", most as usize),
                    (false, true) => format!("{least} to {most} frames"),
                    (false, false) => format!("at most {most} frames"),
                };
                format!("a loop of {frames} {size} by a jump")
            }
            (false, true) => format!("a loop of {frames} frames {size}, {}", name_of(way.mode)),
            (false, false) => format!("a clip of {frames} frames {size}, {}", name_of(way.mode)),
        })
    }

    /// How many frames a run would write, where that is known before.
    pub(super) fn frames(&self, clip: &ClipInput, way: &Way) -> Result<Option<u32>, Failure> {
        if way.play.is_some() {
            return Ok(Some(way.output.shape[0]));
        }
        let frames = if way.jumps() { self.transition.periods(clip, self.period(way))? } else { way.fixed() };
        Ok((frames.start() == frames.end()).then(|| self.write.written(*frames.end())))
    }
}

/// Options that do nothing without a jump.
pub(super) fn of_jumps() -> Vec<String> {
    // Seams have a price, and are looked for at several sizes, either way.
    names_of::<TransitionArgs>().into_iter().filter(|name| !["seam", "levels"].contains(&&**name)).collect()
}

/// Options that do nothing for what is cut at a jump.
pub(super) fn of_woven() -> Vec<String> {
    names_of::<WovenArgs>()
}

/// Without the options that do nothing for what is cut at a jump, or for what is woven.
pub(super) fn of_mode(used: Used, jumps: bool) -> Used {
    let (idle, more): (_, &[&str]) =
        if jumps { (of_woven(), &["size", "tile", "loop", "keep"]) } else { (of_jumps(), &["play"]) };
    let idle = idle.iter().map(String::as_str).chain(more.iter().copied());
    idle.fold(used, |used, option| used.without(option))
}
