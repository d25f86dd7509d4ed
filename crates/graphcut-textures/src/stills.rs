//! Clips by one of their frames each: what is measured of space is no matter of time.

use std::cmp::Reverse;

use selvedge_core::{Exemplars, Source, Window};

use crate::error::Error;

/// The frame in the middle of each clip, as a clip of one; of masked ones the frame that shows most.
///
/// Of whole clips the same measures took 560 bytes a sample, and took a flicker's beat for a structure in space.
pub(crate) fn stills<const D: usize>(clips: &Exemplars<D>) -> Result<Exemplars<D>, Error> {
    let still = |clip: &Source<D>| {
        let domain = clip.domain();
        let (frames, pixels) = (domain.shape[0] as usize, domain.strides()[0]);
        let shown = |t: usize| clip.valid.as_deref().map_or(0, |v| shown(&v.plane(0)[t * pixels..][..pixels]));
        let middle = (0..frames).min_by_key(|&t| (Reverse(shown(t)), t.abs_diff(frames / 2))).unwrap_or(0);
        let mut one = Window::all(domain);
        (one.start[0], one.shape[0]) = (middle as i32, 1);
        Ok(clip.cropped(&one)?)
    };
    let sources = clips.sources().iter().map(|clip| still(clip)).collect::<Result<_, Error>>()?;
    Ok(Exemplars::from_sources(sources, clips.weights().to_vec())?)
}

fn shown(valid: &[bool]) -> usize {
    valid.iter().filter(|valid| **valid).count()
}
