//! An exemplar that moves: a clip, of which each frame that is made has the next.

use selvedge_core::Exemplars;

use crate::clips;
use crate::exemplars::{ExemplarArgs, Headers, NO_MASK};
use crate::failure::{Failure, n};
use crate::loaded::ExemplarSet;

/// Each frame of a clip as an exemplar, with a mask for each if there is any; `None` for exemplars that are still.
pub(super) fn frames(typed: &ExemplarArgs) -> Result<Option<ExemplarArgs>, Failure> {
    let Some(clip) = typed.exemplars.iter().find(|path| clips::is_pattern(path)) else { return Ok(None) };
    if 1 < typed.exemplars.len() {
        let failure = Failure::new(2, format!("is a clip, beside {}", n("exemplar", typed.exemplars.len() - 1)));
        return Err(failure.about(clip).remedy("give the clip alone, or one frame of it"));
    }
    let exemplars = clips::files(clip, None)?;
    typed.check_one_mask()?;
    let mask = match typed.mask.first() {
        Some(mask) if clips::is_pattern(mask) => clips::files(mask, None)?,
        Some(mask) if mask.as_os_str() != NO_MASK => vec![mask.clone(); exemplars.len()],
        _ => Vec::new(),
    };
    Ok(Some(ExemplarArgs { exemplars, mask, ..typed.clone() }))
}

/// Refuses frames of another size than the first one.
pub(super) fn check(frames: &ExemplarArgs, headers: &Headers) -> Result<(), Failure> {
    let size = |i: usize| [headers.infos[i].width, headers.infos[i].height];
    let Some(other) = (0..headers.infos.len()).find(|&i| size(i) != size(0)) else { return Ok(()) };
    let ([w, h], [fw, fh]) = (size(other), size(0));
    let failure = Failure::new(3, format!("{w}x{h} px, but the first frame has {fw}x{fh} px"));
    Err(failure.about(&frames.exemplars[other]).remedy("give frames of one size"))
}

/// What the frames of a clip that was read show, in their order. It is known by its name, and by all of them as one.
pub(super) fn each(typed: &ExemplarArgs, loaded: &mut ExemplarSet) -> Result<Vec<Exemplars<2>>, Failure> {
    let frames = 0..loaded.exemplars.sources().len();
    let each =
        frames.map(|frame| loaded.exemplars.only([frame]).map_err(|e| Failure::from(e).about(&loaded.paths[frame])));
    let each = each.collect::<Result<Vec<_>, Failure>>()?;
    let of_masks = std::mem::take(&mut loaded.other_fingerprints);
    loaded.fingerprints = vec![clips::fingerprint(&typed.exemplars[0], &loaded.fingerprints)];
    loaded.other_fingerprints = match (&typed.mask[..], &of_masks[..]) {
        ([mask], [_, ..]) if clips::is_pattern(mask) => vec![clips::fingerprint(mask, &of_masks)],
        (_, all) => all.iter().take(1).cloned().collect(),
    };
    (loaded.paths, loaded.given) = (typed.exemplars.clone(), 1);
    Ok(each)
}
