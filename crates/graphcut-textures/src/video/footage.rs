//! Where a clip's frames come from.

use std::borrow::Cow;
use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Grid, Source, SourceTable};

use crate::error::Error;

/// A clip by its frames: held whole, as [`Exemplars`] are, or read again whenever some are asked for. A loop of one
/// jump needs no more of it at once than frames around the jump, so that its memory follows from the window and not
/// from the clip. Whoever hands the same frames over gets the same answers.
pub trait Footage {
    /// How its samples are numbered: one source, the clip.
    fn table(&self) -> &SourceTable<3>;

    /// Weight of each feature channel.
    fn weights(&self) -> &[u8];

    /// Frames that are asked for together where all of them pass by once: of what is held, all.
    fn together(&self) -> u32 {
        8
    }

    /// The features of some frames, and which of their samples may be used.
    ///
    /// # Errors
    /// [`Error::Unread`] for frames that cannot be had, [`Error::Core`] if memory is short.
    fn stretch(&self, frames: Range<u32>) -> Result<Cow<'_, Source<3>>, Error>;
}

impl Footage for Exemplars<3> {
    fn table(&self) -> &SourceTable<3> {
        Self::table(self)
    }

    fn weights(&self) -> &[u8] {
        Self::weights(self)
    }

    fn together(&self) -> u32 {
        u32::MAX
    }

    fn stretch(&self, frames: Range<u32>) -> Result<Cow<'_, Source<3>>, Error> {
        let clip = &self.sources()[0];
        if frames == (0..clip.domain().shape[0]) {
            return Ok(Cow::Borrowed(clip));
        }
        let features = cut_out(&clip.features, &frames, 0)?;
        let valid = clip.valid.as_deref().map(|valid| cut_out(valid, &frames, false)).transpose()?;
        Ok(Cow::Owned(Source { features, valid: valid.map(Into::into), origin: clip.origin }))
    }
}

/// Some frames of a clip.
fn cut_out<T: Copy>(clip: &Grid<T, 3>, frames: &Range<u32>, fill: T) -> Result<Grid<T, 3>, Error> {
    let [_, height, width] = clip.domain().shape;
    let pixels = height as usize * width as usize;
    let domain = Domain::open([frames.end - frames.start, height, width]);
    let mut cut = Grid::try_filled(domain, clip.channels(), fill)?;
    for c in 0..clip.channels() {
        let from = &clip.plane(c)[frames.start as usize * pixels..frames.end as usize * pixels];
        cut.plane_mut(c).copy_from_slice(from);
    }
    Ok(cut)
}

/// The clip that is looped: its one source, without any ends.
pub(super) fn the_clip(clip: &(impl Footage + ?Sized)) -> Result<Domain<3>, Error> {
    let [(_, domain)] = clip.table().sources() else {
        return Err(Error::OneClip { found: clip.table().sources().len() });
    };
    let [frames, height, width] = domain.shape;
    if frames < 2 || u32::from(u16::MAX) < frames || height == 0 || width == 0 {
        return Err(Error::Frames { frames });
    }
    Ok(Domain::open(domain.shape))
}

/// Frames in order, so many at once.
pub(super) fn parts(frames: Range<u32>, most: u32) -> impl Iterator<Item = Range<u32>> {
    let end = frames.end;
    frames.step_by(most.max(1) as usize).map(move |from| from..from.saturating_add(most).min(end))
}

/// Every two frames that follow each other, in order: each as what holds it, and its number there.
pub(super) fn neighbours(
    clip: &(impl Footage + ?Sized),
    mut look: impl FnMut((&Source<3>, usize), (&Source<3>, usize)),
) -> Result<(), Error> {
    let frames = the_clip(clip)?.shape[0];
    let mut before: Option<Cow<'_, Source<3>>> = None;
    for part in parts(0..frames, clip.together()) {
        let these = clip.stretch(part)?;
        let len = these.domain().shape[0] as usize;
        if let Some(before) = &before {
            look((before, before.domain().shape[0] as usize - 1), (&these, 0));
        }
        (1..len).for_each(|t| look((&these, t - 1), (&these, t)));
        before = Some(these);
    }
    Ok(())
}
