//! When each pixel jumps.

use selvedge_core::{Domain, Grid, Origin, SampleId, SourceMap, SourceTable, Transform, reserve};

use super::jumps::Jump;
use crate::error::Error;

/// A seam in space and time: when each pixel of a loop jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// By pixel, the first frame that it shows no more: it plays the frames of one period before that one, again and
    /// again.
    pub time: Grid<u16, 2>,
}

impl Surface {
    /// All pixels jump after the same frame.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short, [`Error::Jump`] beyond the frames that a clip may have.
    pub fn flat(jump: &Jump, [height, width]: [u32; 2]) -> Result<Self, Error> {
        let end = u16::try_from(u64::from(jump.from) + 1);
        let end = end.map_err(|_| Error::Jump { from: jump.from, to: jump.to, frames: u16::MAX.into() })?;
        Ok(Self { time: Grid::try_filled(Domain::open([height, width]), 1, end)? })
    }

    /// A surface read from elsewhere, for a jump in a clip.
    ///
    /// # Errors
    /// [`Error::Jump`] if the jump is not in the clip; [`Error::Surface`] if it has another size than the clip's
    /// frames, a pixel would show a frame that the clip does not have, or pixels jump farther from each other than a
    /// period.
    pub fn check(&self, jump: &Jump, clip: Domain<3>) -> Result<(), Error> {
        let [frames, height, width] = clip.shape;
        jump.check(frames)?;
        let found = self.time.domain().shape;
        let wrong = |at: Option<[u32; 2]>| Error::Surface { found, expected: [height, width], at, frames };
        if found != [height, width] || self.time.channels() != 1 {
            return Err(wrong(None));
        }
        let played = jump.period()..=frames;
        let times = self.time.plane(0);
        let last = u32::from(times.iter().min().copied().unwrap_or(0)) + jump.period();
        match times.iter().position(|&s| !played.contains(&s.into()) || last < s.into()) {
            Some(i) => Err(wrong(Some(self.time.domain().position(i)))),
            None => Ok(()),
        }
    }

    /// The frame that a pixel shows where the loop stands at `frame`, counted in the clip.
    #[inline]
    pub(super) fn frame(end: u16, period: u32, frame: u32) -> u32 {
        let first = u32::from(end) - period;
        first + (i64::from(frame) - i64::from(first)).rem_euclid(period.into()) as u32
    }

    /// Frame `t` of that loop: the frames of the clip that it shows, and its map over these.
    pub(super) fn frame_map(&self, jump: &Jump, t: u32) -> Result<(Vec<u32>, SourceMap<2>), Error> {
        let (domain, times) = (self.time.domain(), self.time.plane(0));
        let shown = |&end: &u16| Self::frame(end, jump.period(), jump.to + t);
        let mut frames: Vec<u32> = times.iter().map(shown).collect();
        frames.sort_unstable();
        frames.dedup();
        let origin = |(number, _)| (Origin { exemplar: number, transform: Transform::IDENTITY }, domain);
        let table = SourceTable::new((0..).zip(&frames).map(origin).collect())?;
        let source = |end: &u16| frames.iter().position(|&frame| frame == shown(end)).unwrap_or(0);
        let mut ids = Vec::new();
        reserve(&mut ids, domain.len())?;
        ids.extend(times.iter().zip(0..).map(|(end, pixel)| SampleId::new(table.first(source(end)) + pixel)));
        Ok((frames, SourceMap::new(Grid::from_vec(domain, 1, ids)?, table)?))
    }

    /// The loop that begins at the frame to which the jump leads.
    pub(super) fn map(&self, jump: &Jump, table: &SourceTable<3>) -> Result<SourceMap<3>, Error> {
        let [height, width] = self.time.domain().shape;
        let period = jump.period();
        let domain = Domain { shape: [period, height, width], periodic: [true, false, false] };
        let mut ids = Vec::new();
        reserve(&mut ids, domain.len())?;
        for at in 0..period {
            let pixels = self.time.plane(0).iter().zip(0..);
            ids.extend(
                pixels.map(|(&end, pixel)| {
                    SampleId::new(Self::frame(end, period, jump.to + at) * height * width + pixel)
                }),
            );
        }
        Ok(SourceMap::new(Grid::from_vec(domain, 1, ids)?, table.clone())?)
    }
}
