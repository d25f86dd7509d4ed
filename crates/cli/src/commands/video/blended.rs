//! `--feather` and `--spline` of clips: in space alone, frame by frame, since what is blended in time is a ghost.

use selvedge_core::{Bytes, Domain, Grid, Plane, SourceMap};
use selvedge_io::clip::frame_of;

use crate::blending::Blending;
use crate::clip_maps;
use crate::clips::ClipInput;
use crate::failure::Failure;
use crate::session::Session;

/// Refuses what no clip can have.
pub(super) fn check(session: &Session<'_>, blending: Blending) -> Result<(), Failure> {
    blending.validate()?;
    let refused = |what: &str| Err(Failure::new(2, what).remedy("use --feather or --spline, or leave it out"));
    if blending.is_fused() {
        return refused("--fuse would raise each frame by another amount, and the clip would flicker");
    }
    match session.first_typed(&["blend"]).filter(|_| !blending.is_none()) {
        Some(_) => refused("--blend fades whole frames and has no seam to hide"),
        None => Ok(()),
    }
}

/// All frames of an output, blended but for what stands still.
pub(super) fn frames(
    session: &Session<'_>,
    blending: Blending,
    (map, clip): (&SourceMap<3>, &Plane<3>),
    still: Option<&Grid<bool, 2>>,
) -> Result<Vec<Plane<2>>, Failure> {
    let all: Vec<Plane<2>> = (0..clip.domain().shape[0]).map(|t| frame_of(clip, t)).collect::<Result<_, _>>()?;
    let all: Vec<&Plane<2>> = all.iter().collect();
    let maps = clip_maps::each(map)?.collect::<Result<Vec<_>, _>>()?;
    let blending = blending.of_frames(&maps);
    session.watch.busy(blending.name());
    let frame = |map: &SourceMap<2>| {
        session.check_signal()?;
        blending.render(map, Vec::new(), still, &all)
    };
    maps.iter().map(frame).collect()
}

/// What that takes beside the clip and the output: the clip once more, frame by frame, and the maps.
pub(super) fn bytes(blending: Blending, clip: &ClipInput, output: Domain<3>) -> Bytes {
    if blending.is_none() {
        return Bytes(0);
    }
    let [frames, height, width] = output.shape;
    // A table of all frames of the clip for each of the output.
    let tables = Bytes(u64::from(frames) * u64::from(clip.domain().shape[0]) * 48);
    clip.bytes()
        + Bytes::of_samples(output, 4)
        + tables
        + blending.bytes(
            Domain { shape: [height, width], periodic: [output.periodic[1], output.periodic[2]] },
            clip.info().channels,
            false,
        )
}
