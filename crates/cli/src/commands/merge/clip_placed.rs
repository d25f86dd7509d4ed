//! Where clips lie beside each other: at one place over all frames.

use std::path::PathBuf;

use selvedge_core::{Bytes, Domain, Encoder, Exemplar, Exemplars, Grid, Plane};
use selvedge_graphcut_textures::labels::{Label, aligned, estimate_aligned};
use selvedge_io::clip::frame_of;

use super::Merge;
use super::clip_blended::frame_valid;
use super::placed::{apart, arrange, extent, nowhere};
use crate::clips::Clip;
use crate::failure::Failure;
use crate::memory;
use crate::session::Session;

/// Frames, evenly spread, that say together where a clip lies: of one alone what moves by could decide. A guess.
const LOOKED_AT: u32 = 5;

impl Merge {
    /// Where clips are said to lie, by the shape of their frames, and how far they reach. Those that are to be found
    /// lie over the first.
    pub(super) fn lay_frames(
        &self,
        paths: &[PathBuf],
        frames: &[Domain<2>],
    ) -> Result<(Vec<Label<2>>, [u32; 2]), Failure> {
        let at = |source: usize| Label { source, offset: self.at(source).0.unwrap_or([0, 0]) };
        let mut labels: Vec<Label<2>> = (0..frames.len()).map(at).collect();
        if self.found().next().is_some() {
            let reach = extent(labels.iter().map(|label| (label.offset, frames[label.source].shape))).1;
            return Ok((labels, reach));
        }
        let reach = arrange(&mut labels, frames).map_err(|alone| apart(&paths[alone]))?;
        Ok((labels, reach))
    }

    /// The same once those that are to be found lie where they agree with the first: over frames spread over the clips,
    /// of which the differences are added.
    pub(super) fn lay_found(
        &self,
        session: &Session<'_>,
        clips: &[Clip],
        masks: &[Option<Grid<bool, 3>>],
    ) -> Result<(Vec<Label<2>>, [u32; 2]), Failure> {
        let looked = looked_at(clips, masks)?;
        let place = |source: usize| match self.at(source).0 {
            Some(offset) => Ok(Label { source, offset }),
            None => aligned(&looked, 0, source, session.run::<2>().simd)?.ok_or_else(|| nowhere(&clips[source].path)),
        };
        let mut labels = (0..clips.len()).map(place).collect::<Result<Vec<_>, Failure>>()?;
        let reach = arrange(&mut labels, &looked.domains()).map_err(|alone| apart(&clips[alone].path))?;
        Ok((labels, reach))
    }

    /// An upper bound of what that takes.
    pub(super) fn found_bytes(&self, sources: &[Domain<3>], colors: usize) -> Bytes {
        let frame = |source: &Domain<3>| Domain::open([source.shape[1], source.shape[2]]);
        let channels = colors * LOOKED_AT as usize;
        let frames: Vec<Domain<2>> = sources.iter().map(frame).collect();
        // Frames of floats at most, and their features.
        let looked = frames.iter().map(|frame| Bytes::of_samples(*frame, 5) * channels as u64).sum::<Bytes>();
        let found = self.found().map(|i| estimate_aligned(frames[0], frames[i], channels));
        found.max().map_or(Bytes(0), |most| most + looked + memory::sources(&frames, channels))
    }
}

/// Frames of each clip as channels of one picture, which may show where all of them may.
fn looked_at(clips: &[Clip], masks: &[Option<Grid<bool, 3>>]) -> Result<Exemplars<2>, Failure> {
    let [all, ..] = clips[0].plane.domain().shape;
    let times: Vec<u32> = (0..all.min(LOOKED_AT)).map(|i| (2 * i + 1) * all / (2 * all.min(LOOKED_AT))).collect();
    let frames = |clip: &Clip| times.iter().map(|&t| frame_of(&clip.plane, t)).collect::<Result<Vec<_>, _>>();
    let frames: Vec<Vec<Plane<2>>> = clips.iter().map(frames).collect::<Result<_, _>>()?;
    let valid = |mask: &Grid<bool, 3>| {
        let mut all = frame_valid(mask, times[0])?;
        for &t in &times[1..] {
            let more = frame_valid(mask, t)?;
            all.samples_mut().iter_mut().zip(more.samples()).for_each(|(all, more)| *all &= more);
        }
        Ok::<_, Failure>(all)
    };
    let masks = masks.iter().map(|mask| mask.as_ref().map(valid).transpose()).collect::<Result<Vec<_>, _>>()?;
    let planes: Vec<&[Plane<2>]> = frames.iter().map(Vec::as_slice).collect();
    let shown: Vec<Exemplar<'_, 2>> =
        planes.iter().zip(&masks).map(|(planes, mask)| Exemplar::new(planes).masked(mask.as_ref())).collect();
    Ok(Exemplars::new(&Encoder::fit(&planes)?, &shown)?)
}
