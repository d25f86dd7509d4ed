//! What `video` tells before a run, and of its options.

use super::Video;
use super::modes::Way;
use crate::clips::ClipInput;
use crate::failure::n;
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

/// Without the options that do nothing for what is cut at a jump, or for what is woven.
pub(super) fn of_mode(used: Used, jumps: bool) -> Used {
    const OF_JUMPS: [&str; 7] = ["period", "window", "jumps", "jump", "surface-from", "blend", "play"];
    const OF_WOVEN: [&str; 12] = [
        "size",
        "tile",
        "loop",
        "keep",
        "placement",
        "region",
        "reach",
        "randomness",
        "variety",
        "refine",
        "patience",
        "tries",
    ];
    let idle: &[&str] = if jumps { &OF_WOVEN } else { &OF_JUMPS };
    idle.iter().fold(used, |used, option| used.without(option))
}
