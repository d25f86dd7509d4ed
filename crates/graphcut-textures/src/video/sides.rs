//! The frames around a jump: what would have come, and what comes, one period earlier.

use std::ops::Range;

use selvedge_core::{Exemplars, Source};

use super::banded::halved;
use super::footage::{Footage, the_clip};
use super::jumps::Jump;
use crate::error::Error;

/// The window of a jump in both stretches of the clip, with two more frames on either side: a seam's other side, and
/// what its gradient looks at.
pub(super) struct Sides {
    /// A source for each, whatever of them is valid: a loop shows all of its frames.
    pub(super) both: Exemplars<3>,
    /// By stretch, the number of its first frame in the clip.
    pub(super) first: [u32; 2],
    pub(super) window: Range<u32>,
    pub(super) period: u32,
}

impl Sides {
    pub(super) fn read(clip: &(impl Footage + ?Sized), jump: &Jump, window: Range<u32>) -> Result<Self, Error> {
        let (all, period) = (the_clip(clip)?.shape[0], jump.period());
        let of = |by: u32| (window.start - by).saturating_sub(2)..(window.end - by + 2).min(all);
        let read = |frames| clip.stretch(frames).map(|side| Source { valid: None, ..side.into_owned() });
        // The earlier one first: so a clip that is read again is read forwards.
        let earlier = read(of(period))?;
        let sources = vec![read(of(0))?, earlier];
        let both = Exemplars::from_sources(sources, clip.weights().to_vec())?;
        Ok(Self { both, first: [of(0).start, of(period).start], window, period })
    }

    /// The same with frames of half the size.
    pub(super) fn smaller(&self) -> Result<Self, Error> {
        let sources = self.both.sources().iter().map(|side| halved(side)).collect::<Result<Vec<_>, _>>()?;
        let both = Exemplars::from_sources(sources, self.both.weights().to_vec())?;
        Ok(Self { both, window: self.window.clone(), ..*self })
    }

    /// A frame of a side, by its number in the clip, in a channel.
    pub(super) fn frame(&self, side: usize, channel: usize, frame: u32) -> &[u8] {
        let features = &self.both.sources()[side].features;
        let pixels = features.domain().strides()[0];
        &features.plane(channel)[(frame - self.first[side]) as usize * pixels..][..pixels]
    }
}
