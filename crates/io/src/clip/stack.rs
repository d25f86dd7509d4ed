//! Between frames and clips that are held whole.

use selvedge_core::{Domain, Grid, Limits, Plane, Samples};

use super::info::ClipInfo;
use super::problem::{ClipProblem, check_samples};
use super::reader::ClipReader;
use crate::error::{Error, Problem};
use crate::header::{Header, afford};

/// All frames of a clip, over time, height and width. The clip is read to its end.
///
/// # Errors
/// Those of the frames; [`ClipProblem::Samples`] and [`Problem::Memory`] before anything is read.
pub fn read_clip(reader: &mut ClipReader, limits: &Limits) -> Result<Plane<3>, Error> {
    check(reader.info(), limits).map_err(|p| Error::new(reader.path(), p))?;
    let path = reader.path().to_path_buf();
    let info = reader.info();
    let domain = Domain::open([info.frames, info.height, info.width]);
    let (channels, depth, alpha, association) = (info.channels, info.depth, info.alpha, info.association);
    let refused = |e| Error::new(&path, Problem::Core(e));
    let mut samples = Samples::try_zeros(domain, channels, depth).map_err(refused)?;
    let (mut frames, mut role) = (0, selvedge_core::Role::Color);
    while let Some(frame) = reader.next()? {
        match (&mut samples, &frame.samples) {
            (Samples::U8(to), Samples::U8(from)) => put(to, from, frames),
            (Samples::U16(to), Samples::U16(from)) | (Samples::F16(to), Samples::F16(from)) => put(to, from, frames),
            (Samples::F32(to), Samples::F32(from)) => put(to, from, frames),
            _ => unreachable!("frames were compared with the first one"),
        }
        role = frame.role;
        frames += 1;
    }
    if frames as u32 != domain.shape[0] {
        let (expected, found) = (domain.shape[0], frames as u32);
        return Err(Error::new(&path, ClipProblem::Count { expected, found }));
    }
    Ok(Plane { role, samples, alpha, association })
}

/// Refuses what is too large to be held whole.
fn check(info: &ClipInfo, limits: &Limits) -> Result<(), Problem> {
    let ClipInfo { width, height, frames, channels, alpha, depth, .. } = *info;
    let frame = Header { width: width.into(), height: height.into(), channels, alpha, depth };
    check_samples((frame.width, frame.height), frames, limits)?;
    afford(limits, frame.bytes().saturating_mul(u64::from(frames) + 2))
}

fn put<T: Copy>(clip: &mut Grid<T, 3>, frame: &Grid<T, 2>, t: usize) {
    let n = frame.domain().len();
    for c in 0..frame.channels() {
        clip.plane_mut(c)[t * n..][..n].copy_from_slice(frame.plane(c));
    }
}

/// One frame of a clip.
///
/// # Errors
/// [`Allocation`](selvedge_core::Error::Allocation).
///
/// # Panics
/// If the clip has no such frame.
pub fn frame_of(clip: &Plane<3>, t: u32) -> Result<Plane<2>, selvedge_core::Error> {
    let samples = match &clip.samples {
        Samples::U8(grid) => Samples::U8(taken(grid, t, 0)?),
        Samples::U16(grid) => Samples::U16(taken(grid, t, 0)?),
        Samples::F16(grid) => Samples::F16(taken(grid, t, 0)?),
        Samples::F32(grid) => Samples::F32(taken(grid, t, 0.0)?),
    };
    Ok(Plane { role: clip.role, samples, alpha: clip.alpha, association: clip.association })
}

fn taken<T: Copy>(clip: &Grid<T, 3>, t: u32, fill: T) -> Result<Grid<T, 2>, selvedge_core::Error> {
    let Domain { shape: [_, height, width], periodic: [_, y, x] } = clip.domain();
    let domain = Domain { shape: [height, width], periodic: [y, x] };
    let (mut frame, n) = (Grid::try_filled(domain, clip.channels(), fill)?, domain.len());
    for c in 0..clip.channels() {
        frame.plane_mut(c).copy_from_slice(&clip.plane(c)[t as usize * n..][..n]);
    }
    Ok(frame)
}
