//! An exemplar that moves: a clip, of which each frame that is made has the next.

use std::path::PathBuf;

use selvedge_core::{Exemplars, Role};
use selvedge_io::{Fingerprint, Metadata, WriteOptions};

use crate::clips::{self, ClipInput};
use crate::exemplars::{ExemplarArgs, Headers, NO_MASK};
use crate::failure::{Failure, n};
use crate::inputs;
use crate::loaded::ExemplarSet;
use crate::report::Report;
use crate::session::Session;
use crate::stdio::STREAM;

/// A clip that is the exemplar.
pub(super) struct Moving {
    /// Each of its frames as an exemplar, with a mask for each if there is any.
    pub(super) frames: ExemplarArgs,
    /// The file that holds them all, if one does.
    container: Option<Fingerprint>,
}

impl Moving {
    /// Looks at frames, and reads those of a container; `None` for exemplars that are still.
    pub(super) fn found(
        session: &Session<'_>,
        typed: &ExemplarArgs,
        report: &mut Report,
    ) -> Result<Option<Self>, Failure> {
        let options = inputs::options(session.limits, Role::Color, typed.nonfinite);
        let mut clips = typed.exemplars.iter().filter(|path| path.as_os_str() != STREAM).map(|path| {
            let found = if clips::is_pattern(path) { None } else { ClipInput::found(path, &options)? };
            Ok((path, found))
        });
        let is_clip = |found: &Result<(&PathBuf, Option<ClipInput>), Failure>| {
            found.as_ref().map_or(true, |(path, found)| found.is_some() || clips::is_pattern(path))
        };
        let Some((clip, found)) = clips.find(is_clip).transpose()? else { return Ok(None) };
        if 1 < typed.exemplars.len() {
            let failure = Failure::new(2, format!("is a clip, beside {}", n("exemplar", typed.exemplars.len() - 1)));
            return Err(failure.about(clip).remedy("give the clip alone, or one frame of it"));
        }
        typed.check_one_mask()?;
        let (exemplars, container) = match found {
            Some(clip) => held(session, clip, report).map(|(frames, file)| (frames, Some(file)))?,
            None => (clips::files(clip, None)?, None),
        };
        let mask = match typed.mask.first() {
            Some(mask) if clips::is_pattern(mask) => clips::files(mask, None)?,
            Some(mask) if mask.as_os_str() != NO_MASK => vec![mask.clone(); exemplars.len()],
            _ => Vec::new(),
        };
        Ok(Some(Self { frames: ExemplarArgs { exemplars, mask, ..typed.clone() }, container }))
    }

    /// Whether one file holds all frames.
    pub(super) fn is_packed(&self) -> bool {
        self.container.is_some()
    }

    /// What frames that were read show, in their order. The clip is known by its name, and by all of them as one.
    pub(super) fn each(&self, typed: &ExemplarArgs, loaded: &mut ExemplarSet) -> Result<Vec<Exemplars<2>>, Failure> {
        let frames = 0..loaded.exemplars.sources().len();
        let each = frames
            .map(|frame| loaded.exemplars.only([frame]).map_err(|e| Failure::from(e).about(&loaded.paths[frame])));
        let each = each.collect::<Result<Vec<_>, Failure>>()?;
        let of_masks = std::mem::take(&mut loaded.other_fingerprints);
        let of_frames = || clips::fingerprint(&typed.exemplars[0], &loaded.fingerprints);
        loaded.fingerprints = vec![self.container.clone().unwrap_or_else(of_frames)];
        loaded.other_fingerprints = match (&typed.mask[..], &of_masks[..]) {
            ([mask], [_, ..]) if clips::is_pattern(mask) => vec![clips::fingerprint(mask, &of_masks)],
            (_, all) => all.iter().take(1).cloned().collect(),
        };
        (loaded.paths, loaded.given) = (typed.exemplars.clone(), 1);
        Ok(each)
    }
}

/// Holds the frames of a container as pictures that are read one by one.
fn held(session: &Session<'_>, clip: ClipInput, report: &mut Report) -> Result<(Vec<PathBuf>, Fingerprint), Failure> {
    let (path, mut frames) = (clip.path().to_path_buf(), Vec::new());
    let fingerprint = clip.each(session, report, &mut |frame| {
        let name = path.join(format!("{}.png", frames.len() + 1));
        let bytes = selvedge_io::encode(&frame, &Metadata::default(), &name, &WriteOptions::default())?;
        session.hold(name.clone(), bytes);
        frames.push(name);
        Ok(())
    })?;
    Ok((frames, fingerprint))
}

/// Refuses frames of another size than the first one.
pub(super) fn check(frames: &ExemplarArgs, headers: &Headers) -> Result<(), Failure> {
    let size = |i: usize| [headers.infos[i].width, headers.infos[i].height];
    let Some(other) = (0..headers.infos.len()).find(|&i| size(i) != size(0)) else { return Ok(()) };
    let ([w, h], [fw, fh]) = (size(other), size(0));
    let failure = Failure::new(3, format!("{w}x{h} px, but the first frame has {fw}x{fh} px"));
    Err(failure.about(&frames.exemplars[other]).remedy("give frames of one size"))
}
