//! The cut of one jump: which pixel jumps when. `[Kwatra03 7A]`
//!
//! Over a window of frames around the jump lie what would have come, the clip itself, and what comes, the clip one
//! period earlier. Each pixel changes from the one to the other once. Where a change lies between neighbours, in space
//! or in time, it costs what a seam of two patches costs. `[Kwatra03 eq. 1]` `[Kwatra03 eq. 5]`

use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Grid, SampleId, SeamCosts, SeamMeasure, Source, try_vec};
use selvedge_maxflow::MaxflowError;

use super::jumps::Jump;
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
    /// By stretch, number of the first sample of the window's first frame.
    first: [i64; 2],
    pub(super) pixels: usize,
    /// Of the window.
    pub(super) shape: [u32; 3],
}

impl Stretches {
    fn new(exemplars: &Exemplars<3>, jump: &Jump, frames: Range<u32>, seam: SeamMeasure) -> Result<Self, Error> {
        let clip = &exemplars.sources()[0];
        let [all, height, width] = clip.domain().shape;
        let pixels = height as usize * width as usize;
        // Two more frames on either side: the seam's other side, and what its gradient looks at.
        let stretch = |by: u32| {
            let (start, end) = ((frames.start - by).saturating_sub(2), (frames.end - by + 2).min(all));
            (start, cut_out(clip, start..end))
        };
        let both = [stretch(0), stretch(jump.period())];
        let starts = [both[0].0, both[1].0];
        let sources = both.into_iter().map(|(_, source)| source).collect::<Result<Vec<_>, _>>()?;
        let sides = Exemplars::from_sources(sources, exemplars.weights().to_vec())?;
        let of = |i: usize| {
            let by = if i == 0 { 0 } else { jump.period() };
            let frame = i64::from(frames.start) - i64::from(by) - i64::from(starts[i]);
            i64::from(sides.table().first(i)) + frame * pixels as i64
        };
        let first = [of(0), of(1)];
        let shape = [frames.end - frames.start, height, width];
        Ok(Self { costs: SeamCosts::new(&sides, seam)?, frames, first, pixels, shape })
    }

    /// The sample of a side at a node of the window; nodes before and after it are the frames around it.
    fn sample(&self, side: usize, node: i64) -> SampleId {
        SampleId::new((self.first[side] + node) as u32)
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

/// Cuts a jump: by a clip and, if there are any, by smaller ones, each of frames of half the size, whose surface says
/// where that of the one before it is looked for.
///
/// # Errors
/// [`Error::Core`] and [`Error::Cut`].
pub(super) fn transition(
    sizes: &[&Exemplars<3>],
    jump: &Jump,
    frames: Range<u32>,
    seam: SeamMeasure,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Transition, Error> {
    if cancelled() {
        return Err(Error::Cancelled);
    }
    let mut coarser: Option<([u32; 2], Vec<u32>)> = None;
    let mut shift = 0;
    for exemplars in sizes.iter().skip(1).rev() {
        let stretches = Stretches::new(exemplars, jump, frames.clone(), seam)?;
        let found = stretches.surface(coarser.take(), cancelled)?;
        shift = shift.max(found.1);
        coarser = Some(([stretches.shape[1], stretches.shape[2]], found.0));
    }
    let stretches = Stretches::new(sizes[0], jump, frames, seam)?;
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
    Ok(Transition { surface, price: found.min(price), straight: price, shift })
}

pub(super) fn cut_failed(error: MaxflowError) -> Error {
    selvedge_expansion::Error::from(error).into()
}

/// Some frames of a clip, whatever of them is valid: a loop shows all of its frames.
fn cut_out(clip: &Source<3>, frames: Range<u32>) -> Result<Source<3>, Error> {
    let [_, height, width] = clip.domain().shape;
    let pixels = height as usize * width as usize;
    let channels = clip.features.channels();
    let domain = Domain::open([frames.end - frames.start, height, width]);
    let mut features = Grid::try_filled(domain, channels, 0_u8)?;
    for c in 0..channels {
        let from = &clip.features.plane(c)[frames.start as usize * pixels..frames.end as usize * pixels];
        features.plane_mut(c).copy_from_slice(from);
    }
    Ok(Source { features, valid: None, origin: clip.origin })
}
