//! Clips that are given beside each other.

use std::path::Path;

use selvedge_io::Association;
use selvedge_io::clip::ClipInfo;

use crate::clips::ClipInput;
use crate::failure::{Failure, n, shown};
use crate::inputs;
use crate::session::Session;

/// Refuses clips of other frames or samples than the first, or of another rate than the first that has one; tells of
/// other colours.
pub(crate) fn check_alike(session: &Session<'_>, clips: &[ClipInput]) -> Result<(), Failure> {
    let first = &clips[0];
    let paced = clips.iter().find(|clip| clip.info().rate.is_some()).unwrap_or(first);
    for clip in &clips[1..] {
        if let Some((found, of, expected)) = unlike(clip, first, paced) {
            let what = format!("has {found}, but '{}' has {expected}", shown(of));
            let failure = Failure::new(3, what).about(clip.path());
            return Err(failure.remedy("give what has the same frames, rate and samples"));
        }
    }
    inputs::tell_tags(session, first.path(), clips.iter().map(|clip| &clip.info().metadata), "clip");
    Ok(())
}

/// What a clip has, and which other one has something else.
fn unlike<'c>(clip: &ClipInput, first: &'c ClipInput, paced: &'c ClipInput) -> Option<(String, &'c Path, String)> {
    let (a, b) = (clip.info(), first.info());
    let of_first = |told: &dyn Fn(&ClipInfo) -> String| Some((told(a), first.path(), told(b)));
    if a.frames != b.frames {
        return of_first(&|info| n("frame", info.frames as usize));
    }
    if let (Some(rate), Some(of)) = (a.rate, paced.info().rate)
        && rate != of
    {
        return Some((format!("{rate} frames a second"), paced.path(), of.to_string()));
    }
    if (a.channels, a.alpha, a.depth) != (b.channels, b.alpha, b.depth) {
        return of_first(&|info| format!("{} of {}", n("channel", info.channels), info.depth.name()));
    }
    let multiplied = |info: &ClipInfo| info.association == Association::Premultiplied;
    if a.alpha && multiplied(a) != multiplied(b) {
        return of_first(&|info| if multiplied(info) { "premultiplied alpha" } else { "straight alpha" }.to_owned());
    }
    None
}
