//! Clips that begin and end with the same frames, and loop by that. `[Kwatra03 7D]`

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, SampleId, SourceMap, Start, reserve};

use super::footage::the_clip;
use crate::error::Error;

/// Frames with which a clip begins and ends: what is between them goes on from the ones and into the others, so that it
/// loops. `[Kwatra03 7D]`
///
/// A [`start`](Self::start) with both in their places is woven by [`graphcut_from`](crate::graphcut_from), and
/// [`closed`](Self::closed) takes the first of them off.
///
/// A time axis without end needs none of this: it is there for what has to pass through given frames, and to be
/// compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Ends {
    frames: SourceMap<3>,
}

impl Ends {
    /// So many frames out of the middle of the clip, where as much as there can be comes before them and after them.
    ///
    /// # Errors
    /// [`Error::OneClip`], [`Error::Frames`]; [`Error::Core`] unless there are 1 to all but one of the clip's frames,
    /// and if memory is short.
    pub fn of_clip(exemplars: &Exemplars<3>, frames: u32) -> Result<Self, Error> {
        let [all, height, width] = the_clip(exemplars)?.shape;
        CoreError::within("keep", frames, 1.0..=f64::from(all - 1), "1 to all but one of the clip's frames")?;
        let (first, pixels) = ((all - frames) / 2, height * width);
        let mut ids = Vec::new();
        reserve(&mut ids, frames as usize * pixels as usize)?;
        ids.extend((first * pixels..(first + frames) * pixels).map(SampleId::new));
        let domain = Domain::open([frames, height, width]);
        Ok(Self { frames: SourceMap::new(Grid::from_vec(domain, 1, ids)?, exemplars.table().clone())? })
    }

    /// Frames that were woven, for outputs whose frames are of another size than the clip's, or tile.
    pub fn woven(frames: SourceMap<3>) -> Self {
        Self { frames }
    }

    /// What is to be woven for a loop of so many frames: those, and these frames once more, which stand at both ends.
    ///
    /// # Errors
    /// [`Error::Core`] unless there are more frames than these, and if memory is short.
    pub fn start(&self, frames: u32) -> Result<Start<3>, Error> {
        let Domain { shape: [kept, height, width], periodic } = self.frames.domain();
        CoreError::within("keep", kept, 1.0..=f64::from(frames.saturating_sub(1)), "less than the loop's frames")?;
        let all = frames.checked_add(kept).ok_or_else(|| CoreError::range("frames", frames, "fewer"))?;
        let domain = Domain { shape: [all, height, width], periodic: [false, periodic[1], periodic[2]] };
        let mut ids = Grid::try_filled(domain, 1, SampleId::UNASSIGNED)?;
        let mut fixed = Grid::try_filled(domain, 1, false)?;
        let (of, last) = (self.frames.ids.plane(0), domain.len() - self.frames.ids.plane(0).len());
        for begin in [0, last] {
            ids.plane_mut(0)[begin..][..of.len()].copy_from_slice(of);
            fixed.plane_mut(0)[begin..][..of.len()].fill(true);
        }
        let map = SourceMap::new(ids, self.frames.table.clone())?;
        Ok(Start { map, fixed: Some(fixed), sources: None })
    }

    /// The loop out of what was woven from a [`start`](Self::start): without the first of these frames, and without end
    /// in time.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    ///
    /// # Panics
    /// If it has no more frames than these.
    pub fn closed(&self, woven: &SourceMap<3>) -> Result<SourceMap<3>, Error> {
        let Domain { shape: [all, height, width], periodic } = woven.domain();
        let (kept, first) = (self.frames.domain().shape[0], self.frames.ids.plane(0).len());
        let domain = Domain { shape: [all - kept, height, width], periodic: [true, periodic[1], periodic[2]] };
        let mut ids = Vec::new();
        reserve(&mut ids, domain.len())?;
        ids.extend_from_slice(&woven.ids.plane(0)[first..]);
        Ok(SourceMap::new(Grid::from_vec(domain, 1, ids)?, woven.table.clone())?)
    }
}
