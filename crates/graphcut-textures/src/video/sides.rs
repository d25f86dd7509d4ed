//! The frames around a jump: what would have come, and what comes, one period earlier.

use std::borrow::Cow;
use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Grid, Source, SourceTable};

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
    fn smaller(&self) -> Result<Self, Error> {
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

/// A clip in frames of half the size.
pub(super) struct Halved<'c, F: ?Sized> {
    clip: &'c F,
    table: SourceTable<3>,
}

impl<'c, F: Footage + ?Sized> Halved<'c, F> {
    /// None where little would be left of a frame.
    pub(super) fn of(clip: &'c F) -> Option<Self> {
        let [(origin, domain)] = clip.table().sources() else { return None };
        let [frames, height, width] = domain.shape;
        let domain = Domain::open([frames, height / 2, width / 2]);
        let table = may_be_halved([height, width]).then(|| SourceTable::new(vec![(*origin, domain)]))?.ok()?;
        Some(Self { clip, table })
    }
}

impl<F: Footage + ?Sized> Footage for Halved<'_, F> {
    fn table(&self) -> &SourceTable<3> {
        &self.table
    }

    fn weights(&self) -> &[u8] {
        self.clip.weights()
    }

    fn stretch(&self, frames: Range<u32>) -> Result<Cow<'_, Source<3>>, Error> {
        Ok(Cow::Owned(halved(&*self.clip.stretch(frames)?)?))
    }
}

/// Less is left of a smaller frame than its surface could be told by.
fn may_be_halved(frame: [u32; 2]) -> bool {
    frame.iter().all(|&side| 64 <= side)
}

/// The frames around a jump, the same of half the size, of half of that, and so on, as far as there is anything to
/// halve.
pub(super) fn sizes(sides: Sides, levels: u32) -> Result<Vec<Sides>, Error> {
    let mut all = vec![sides];
    for _ in 1..levels {
        let last = &all[all.len() - 1];
        let [_, height, width] = last.both.sources()[0].domain().shape;
        if !may_be_halved([height, width]) {
            break;
        }
        all.push(last.smaller()?);
    }
    Ok(all)
}

/// Frames of half the size: means of two by two samples; of an odd side the last one is left out.
fn halved(clip: &Source<3>) -> Result<Source<3>, Error> {
    let [frames, height, width] = clip.domain().shape;
    let mut features = Grid::try_filled(Domain::open([frames, height / 2, width / 2]), clip.features.channels(), 0_u8)?;
    let (from, to) = (width as usize, (width / 2) as usize);
    for c in 0..clip.features.channels() {
        let rows = clip.features.plane(c).chunks(from * height as usize).flat_map(|frame| frame.chunks_exact(2 * from));
        for (out, rows) in features.plane_mut(c).chunks_mut(to).zip(rows) {
            let (upper, lower) = rows.split_at(from);
            for (out, (a, b)) in out.iter_mut().zip(upper.chunks(2).zip(lower.chunks(2))) {
                let sum: u16 = a.iter().chain(b).map(|&v| u16::from(v)).sum();
                *out = ((sum + 2) / 4) as u8;
            }
        }
    }
    Ok(Source { features, valid: None, origin: clip.origin })
}
