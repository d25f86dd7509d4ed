//! Pictures that are followed: where they are transparent they say nothing.

use std::path::{Path, PathBuf};

use selvedge_core::{Grid, Guide, Plane, Samples};

use crate::failure::Failure;
use crate::loom::Loom;

/// Bytes for each sample of a picture that is followed and transparent somewhere: where it shows anything, that again
/// in its guide, and where sources of the guide are turned.
pub(crate) const MASKS: u64 = 3;

/// A picture that lies under an exemplar or under the output.
pub(crate) struct Followed {
    /// Whose hidden samples are those seen before them.
    pub(crate) plane: Plane<2>,
    /// Where it shows anything; `None` for everywhere.
    pub(crate) seen: Option<Grid<bool, 2>>,
}

impl Followed {
    /// Takes a picture that shows something.
    pub(crate) fn new(mut plane: Plane<2>, path: &Path) -> Result<Self, Failure> {
        let Some(seen) = plane.validity()?.filter(|seen| seen.samples().contains(&false)) else {
            return Ok(Self { plane, seen: None });
        };
        if !seen.samples().contains(&true) {
            let failure = Failure::new(3, "all of it is transparent, so that it says nothing").about(path);
            return Err(failure.remedy("give a picture with something in it"));
        }
        let colors = plane.color_channels();
        match &mut plane.samples {
            Samples::U8(grid) => cover(grid, colors, seen.samples()),
            Samples::U16(grid) => cover(grid, colors, seen.samples()),
            Samples::F16(grid) => cover(grid, colors, seen.samples()),
            Samples::F32(grid) => cover(grid, colors, seen.samples()),
        }
        Ok(Self { plane, seen: Some(seen) })
    }

    /// Reads one.
    pub(crate) fn read(loom: &mut Loom<'_>, path: &Path) -> Result<Self, Failure> {
        Self::new(loom.open(path)?, path)
    }

    /// Reads several.
    pub(crate) fn all<'p>(
        loom: &mut Loom<'_>,
        paths: impl IntoIterator<Item = &'p PathBuf>,
    ) -> Result<Vec<Self>, Failure> {
        paths.into_iter().map(|path| Self::read(loom, path)).collect()
    }
}

/// A guide from pictures under the exemplars, and one under the output, of which what is hidden counts nowhere. A
/// picture that is gone on from has under it what is under the output.
pub(crate) fn seen(guide: Guide<2>, sources: &[Followed], target: &Followed) -> Result<Guide<2>, Failure> {
    let copied = |one: &Followed| one.seen.as_ref().map(|seen| seen.map(|v| v)).transpose();
    let exemplars = guide.exemplars().sources().iter().map(|s| usize::from(s.origin.exemplar) + 1).max().unwrap_or(0);
    let masks = (0..exemplars).map(|e| copied(sources.get(e).unwrap_or(target))).collect::<Result<Vec<_>, _>>()?;
    asked(guide.knowing(&masks)?, target)
}

/// A guide of which only what is seen under the output is asked for.
pub(crate) fn asked(guide: Guide<2>, target: &Followed) -> Result<Guide<2>, Failure> {
    Ok(match &target.seen {
        Some(seen) => guide.asking(seen.map(|v| v)?)?,
        None => guide,
    })
}

/// Lays what was seen before over hidden samples, so that their colours are in no mean around them and are no label.
fn cover<T: Copy>(grid: &mut Grid<T, 2>, colors: usize, seen: &[bool]) {
    let first = seen.iter().position(|seen| *seen).unwrap_or(0);
    for c in 0..colors {
        let samples = grid.plane_mut(c);
        let mut before = samples[first];
        for (sample, seen) in samples.iter_mut().zip(seen) {
            if *seen {
                before = *sample;
            } else {
                *sample = before;
            }
        }
    }
}
