//! Seams of clips hidden: feathered and splined frame by frame, since what is blended in time is a ghost; fused in
//! space and time at once, so that nothing flickers.

use selvedge_core::{Bytes, Domain, Grid, Plane, SampleId, SourceMap, SourceTable};
use selvedge_io::clip::frame_of;

use super::clip_laid::Merged;
use crate::blending::Blending;
use crate::failure::Failure;
use crate::session::Session;

/// The output with its seams hidden.
pub(super) enum Blended {
    /// Frame by frame, by the map of each.
    Frames(Blending, Vec<SourceMap<2>>),
    /// All of it.
    Whole(Plane<3>),
}

impl Blended {
    /// `None` where samples are copied.
    pub(super) fn of(session: &Session<'_>, blending: Blending, merged: &Merged) -> Result<Option<Self>, Failure> {
        if blending.is_none() {
            return Ok(None);
        }
        session.watch.busy(blending.name());
        if !blending.is_fused() {
            let maps = (0..merged.frames()).map(|t| frame_map(&merged.map, t)).collect::<Result<Vec<_>, _>>()?;
            return Ok(Some(Self::Frames(blending.of_frames(&maps), maps)));
        }
        let planes: Vec<&Plane<3>> = merged.clips.iter().map(|clip| &clip.plane).collect();
        let (valid, kept) = (merged.exemplars.validity(), merged.unfused.as_ref());
        Ok(Some(Self::Whole(blending.render_around_holes(&merged.map, valid, kept, (&planes, merged.holes))?)))
    }

    /// A frame of it.
    pub(super) fn frame(&self, merged: &Merged, t: u32) -> Result<Plane<2>, Failure> {
        let (blending, map) = match self {
            Self::Whole(plane) => return Ok(frame_of(plane, t)?),
            Self::Frames(blending, maps) => (blending, &maps[t as usize]),
        };
        let frames = merged.clips.iter().map(|clip| frame_of(&clip.plane, t)).collect::<Result<Vec<_>, _>>()?;
        let valid = merged.exemplars.validity().into_iter().map(|valid| valid.map(|valid| frame_valid(valid, t)));
        let valid = valid.map(Option::transpose).collect::<Result<Vec<_>, _>>()?;
        let valid = valid.iter().map(Option::as_ref).collect();
        blending.render_around_holes(map, valid, None, (&frames.iter().collect::<Vec<_>>(), merged.holes))
    }
}

/// An upper bound of what that takes beside clips and output.
pub(super) fn bytes(blending: Blending, output: Domain<3>, channels: usize, (kept, depth): (bool, u64)) -> Bytes {
    let [_, height, width] = output.shape;
    if blending.is_none() {
        Bytes(0)
    } else if blending.is_fused() {
        // With alpha, were something in no clip.
        let clips = Bytes::of_samples(output, depth) * (channels as u64 + 1);
        blending.bytes(output, channels + 1, kept) + clips * 3
    } else {
        blending.bytes(Domain::open([height, width]), channels + 1, false) + Bytes::of_samples(output, 4)
    }
}

/// Where a frame may show.
pub(super) fn frame_valid(valid: &Grid<bool, 3>, t: u32) -> Result<Grid<bool, 2>, Failure> {
    let [_, height, width] = valid.domain().shape;
    let (domain, frame) = (Domain::open([height, width]), height as usize * width as usize);
    Ok(Grid::from_vec(domain, 1, valid.plane(0)[t as usize * frame..][..frame].to_vec())?)
}

/// The map of a frame, whose sources are the frames of that time, one a clip: no clip shows another time.
fn frame_map(map: &SourceMap<3>, t: u32) -> Result<SourceMap<2>, Failure> {
    let [_, height, width] = map.domain().shape;
    let source = |(origin, clip): &(_, Domain<3>)| (*origin, Domain::open([clip.shape[1], clip.shape[2]]));
    let table = SourceTable::new(map.table.sources().iter().map(source).collect())?;
    let (domain, frame) = (Domain::open([height, width]), height as usize * width as usize);
    let id = |id: &SampleId| {
        let found = map.table.locate(*id);
        found.map_or(SampleId::UNASSIGNED, |(clip, [_, y, x])| table.id(clip, [y, x]))
    };
    let ids = map.ids.plane(0)[t as usize * frame..][..frame].iter().map(id).collect();
    Ok(SourceMap::new(Grid::from_vec(domain, 1, ids)?, table)?)
}
