//! What `video` tells before a run, and of its options.

use super::Video;
use super::modes::Way;
use super::transition::TransitionArgs;
use super::woven::WovenArgs;
use crate::clips::ClipInput;
use crate::failure::n;
use crate::options::names_of;
use crate::used::Used;
use crate::values::name_of;

impl Video {
    /// What a run would make, in words.
    pub(super) fn would(&self, clip: &ClipInput, way: &Way) -> String {
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
}

/// Options that do nothing without a jump.
pub(super) fn of_jumps() -> Vec<String> {
    // Seams have a price either way.
    names_of::<TransitionArgs>().into_iter().filter(|name| name != "seam").collect()
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
