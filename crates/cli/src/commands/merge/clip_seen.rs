//! Merged clips as they are shown to eyes: the frames that are written, and slices through them.

use selvedge_core::{Bytes, Depth, Domain, Grid, Plane, Samples, SourceMap};

use crate::clip_look::Shown;
use crate::eyes;
use crate::failure::Failure;
use crate::memory;

/// The picture of `--preview`, on white where nothing shows.
pub(super) fn preview(frames: &[Plane<2>], map: &SourceMap<3>) -> Result<Plane<2>, Failure> {
    // As one picture, or each frame of light would be shown by a measure of its own.
    let seen = eyes::on_white(&below(frames)?, u32::MAX)?;
    let output = &Grid::from_vec(map.domain(), 3, seen.into_vec())?;
    Shown { output, map, in_space: true }.picture(Vec::new())
}

/// An upper bound of what that takes: the frames, one below the other, and as they are made 8 bits.
pub(super) fn bytes(output: Domain<3>, channels: usize, depth: Depth) -> Bytes {
    memory::picture(output, channels + 1, depth) * 4 + Bytes::of_samples(output, 3 + 3)
}

/// Frames below each other.
fn below(frames: &[Plane<2>]) -> Result<Plane<2>, Failure> {
    macro_rules! joined {
        ($kind:ident) => {{
            let grids =
                frames.iter().filter_map(|f| if let Samples::$kind(grid) = &f.samples { Some(grid) } else { None });
            Samples::$kind(joined(&grids.collect::<Vec<_>>())?)
        }};
    }
    let samples = match frames[0].samples.depth() {
        Depth::U8 => joined!(U8),
        Depth::U16 => joined!(U16),
        Depth::F16 => joined!(F16),
        Depth::F32 => joined!(F32),
    };
    let Plane { role, alpha, association, .. } = frames[0];
    Ok(Plane { role, samples, alpha, association })
}

fn joined<T: Copy>(frames: &[&Grid<T, 2>]) -> Result<Grid<T, 2>, Failure> {
    let Domain { shape: [height, width], .. } = frames[0].domain();
    let mut all = Vec::new();
    for c in 0..frames[0].channels() {
        frames.iter().for_each(|frame| all.extend_from_slice(frame.plane(c)));
    }
    Ok(Grid::from_vec(Domain::open([height * frames.len() as u32, width]), frames[0].channels(), all)?)
}
