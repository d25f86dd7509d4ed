//! The cut of one jump: which pixel jumps when. `[Kwatra03 7A]`
//!
//! Over a window of frames around the jump lie what would have come, the clip itself, and what comes, the clip one
//! period earlier. Each pixel changes from the one to the other once. Where a change lies between neighbours, in space
//! or in time, it costs what a seam of two patches costs. `[Kwatra03 eq. 1]` `[Kwatra03 eq. 5]`

use std::ops::Range;

use selvedge_core::{Domain, Grid, SampleId, SeamCosts, SeamMeasure, try_vec};
use selvedge_maxflow::MaxflowError;

use super::jumps::Jump;
use super::sides::Sides;
use super::surface::Surface;
use crate::error::Error;

/// What a jump costs at best.
#[derive(Clone, Debug)]
pub(super) struct Transition {
    pub(super) surface: Surface,
    /// The price of its seam.
    pub(super) price: i64,
    /// That of the best straight one.
    pub(super) straight: i64,
    /// Bits that prices were shortened by for the cut.
    pub(super) shift: u32,
}

/// The frames in which pixels may jump: `window` at most, as many before the jump as after it, as far as both sides
/// exist, and no more than a period, so that the loop does not meet its own seam. A pixel jumps before one of them or
/// after the last.
pub(super) fn window(jump: &Jump, frames: u32, window: u32) -> Range<u32> {
    let (end, period) = (jump.from + 1, jump.period());
    let window = window.min(period);
    // As for a clip played backwards, where the halves change places, so that only even ones are mirror images.
    end.saturating_sub(window / 2).max(period)..(end + window.div_ceil(2)).min(frames)
}

/// Two stretches of the clip side by side: what would have come and what comes.
pub(super) struct Stretches {
    costs: SeamCosts<3>,
    pub(super) frames: Range<u32>,
    pub(super) period: u32,
    pub(super) channels: usize,
    /// By stretch, number of the first sample of the window's first frame.
    first: [i64; 2],
    pub(super) pixels: usize,
    /// Of the window.
    pub(super) shape: [u32; 3],
}

impl Stretches {
    pub(super) fn new(sides: &Sides, seam: SeamMeasure) -> Result<Self, Error> {
        let [_, height, width] = sides.both.sources()[0].domain().shape;
        let (pixels, frames) = (height as usize * width as usize, sides.window.clone());
        let of = |i: usize| {
            let by = if i == 0 { 0 } else { sides.period };
            let frame = i64::from(frames.start) - i64::from(by) - i64::from(sides.first[i]);
            i64::from(sides.both.table().first(i)) + frame * pixels as i64
        };
        let first = [of(0), of(1)];
        let shape = [frames.end - frames.start, height, width];
        let (period, channels) = (sides.period, sides.both.channels());
        Ok(Self { costs: SeamCosts::new(&sides.both, seam)?, frames, period, channels, first, pixels, shape })
    }

    /// The sample of a side at a node of the window; nodes before and after it are the frames around it.
    fn sample(&self, side: usize, node: i64) -> SampleId {
        SampleId::new((self.first[side] + node) as u32)
    }

    /// The features of a pixel at a frame of the clip, in the window or a period earlier, or beside one of them.
    #[inline]
    pub(super) fn shown(&self, frame: u32, pixel: usize) -> &[u8] {
        let earlier = frame + 1 < self.frames.start;
        let at = i64::from(frame) - i64::from(self.frames.start) + i64::from(self.period) * i64::from(earlier);
        self.costs.features(self.sample(earlier.into(), at * self.pixels as i64 + pixel as i64))
    }

    /// The price of a change between two neighbours.
    #[inline]
    pub(super) fn price(&self, axis: usize, here: i64, there: i64) -> i32 {
        self.costs.between(axis, self.sample(0, here), self.sample(1, there))
    }

    /// The best straight seam: the frame of the window before which it lies, and its price.
    fn straight(&self) -> (u32, i64) {
        let pixels = self.pixels as i64;
        let before = |t: u32| -> i64 {
            let nodes = i64::from(t) * pixels..(i64::from(t) + 1) * pixels;
            nodes.map(|v| i64::from(self.price(0, v - pixels, v))).sum()
        };
        let seams = (0..=self.shape[0]).map(|t| (t, before(t)));
        seams.min_by_key(|&(_, price)| price).unwrap_or_default()
    }

    /// The price of a surface, by frames of the window that each pixel shows before it jumps.
    pub(super) fn total(&self, shown: &[u32]) -> i64 {
        let (pixels, [_, height, width]) = (self.pixels as i64, self.shape);
        let picture = Domain::open([height, width]);
        let mut sum = 0;
        for (p, at) in picture.positions().enumerate() {
            let t = i64::from(shown[p]);
            sum += i64::from(self.price(0, (t - 1) * pixels + p as i64, t * pixels + p as i64));
            for axis in (0..2).filter(|&axis| at[axis] + 1 < picture.shape[axis]) {
                let q = p + picture.strides()[axis];
                let (earlier, later) = (shown[p].min(shown[q]), shown[p].max(shown[q]));
                for t in i64::from(earlier)..i64::from(later) {
                    let [v, w] = [p, q].map(|p| t * pixels + p as i64);
                    sum += i64::from(self.price(axis + 1, v, w));
                }
            }
        }
        sum
    }
}

/// Cuts a jump: by the frames around it and, if there are any, by smaller ones, each of half the size, whose surface
/// says where that of the one before it is looked for. Answers with what was cut, too.
///
/// # Errors
/// [`Error::Core`] and [`Error::Cut`].
pub(super) fn transition(
    mut sizes: Vec<Sides>,
    seam: SeamMeasure,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<(Transition, Stretches), Error> {
    if cancelled() {
        return Err(Error::Cancelled);
    }
    let mut coarser: Option<([u32; 2], Vec<u32>)> = None;
    let mut shift = 0;
    for sides in sizes.drain(1..).rev() {
        let stretches = Stretches::new(&sides, seam)?;
        let found = stretches.surface(coarser.take(), cancelled)?;
        shift = shift.max(found.1);
        coarser = Some(([stretches.shape[1], stretches.shape[2]], found.0));
    }
    let stretches = Stretches::new(&sizes[0], seam)?;
    drop(sizes);
    let (straight, price) = stretches.straight();
    let mut shown = try_vec(stretches.pixels, straight)?;
    let mut found = price;
    if !stretches.frames.is_empty() {
        let (best, by) = stretches.surface(coarser, cancelled)?;
        shift = shift.max(by);
        found = stretches.total(&best);
        // Prices that were shortened may mislead, and so may a smaller clip.
        if found <= price {
            shown = best;
        }
    }
    let [_, height, width] = stretches.shape;
    let time = shown.into_iter().map(|n| (stretches.frames.start + n) as u16).collect();
    let surface = Surface { time: Grid::from_vec(Domain::open([height, width]), 1, time)? };
    Ok((Transition { surface, price: found.min(price), straight: price, shift }, stretches))
}

pub(super) fn cut_failed(error: MaxflowError) -> Error {
    selvedge_expansion::Error::from(error).into()
}
