//! Loops of one jump.

use std::ops::Range;

use selvedge_core::{Bytes, Domain, Error as CoreError, Event, Run, SeamMeasure, SourceMap, SourceTable, Woven};

use super::banded::{MOST_LEVELS, tiled};
use super::footage::{Footage, the_clip};
use super::jumps::Jump;
use super::sides::{Sides, sizes};
use super::steps::{Closure, Usual, over_surface};
use super::surface::Surface;
use super::transition::{Stretches, Transition, transition, window};
use crate::error::Error;

/// Options of [`looped`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopOptions {
    /// Frames around the jump in which pixels may jump. It shrinks to what there is on both sides, and to a period.
    /// Default: 60. `[Kwatra03 7A]`
    pub window: u32,
    /// How seams are priced. Default: eq. 5 of the paper, by gradients.
    pub seam: SeamMeasure,
    /// Jumps that are cut whatever comes of them; those after them are cut where none of these closes. Default: 8.
    pub jumps: usize,
    /// At how many sizes surfaces are looked for, each of frames half as wide and high as the one before: all but the
    /// smallest only near the surface of the next smaller one. From 1, the cheapest surface, to 5. Default: 1.
    pub levels: u32,
}

impl Default for LoopOptions {
    fn default() -> Self {
        Self { window: 60, seam: SeamMeasure::Gradient, jumps: 8, levels: 1 }
    }
}

/// A clip that loops: a jump, and when each pixel makes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// The jump.
    pub jump: Jump,
    /// When each pixel makes it.
    pub surface: Surface,
    table: SourceTable<3>,
}

impl Loop {
    /// A loop with a surface that is known, for instance from another pass of the same clip.
    ///
    /// # Errors
    /// [`Error::OneClip`], [`Error::Frames`], and those of [`Surface::check`].
    pub fn new(clip: &(impl Footage + ?Sized), jump: Jump, surface: Surface) -> Result<Self, Error> {
        surface.check(&jump, the_clip(clip)?)?;
        Ok(Self { jump, surface, table: clip.table().clone() })
    }

    /// The loop, `[period, height, width]`, without end in time: its first frame is the one that the jump leads to.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn map(&self) -> Result<SourceMap<3>, Error> {
        self.surface.map(&self.jump, &self.table)
    }

    /// The same frame by frame, for clips of which only some are held: the frames of the clip that frame `t` of the
    /// loop shows, at most two, and its map, of which they are the sources in this order.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn frame(&self, t: u32) -> Result<(Vec<u32>, SourceMap<2>), Error> {
        self.surface.frame_map(&self.jump, t)
    }

    /// How much the loop's steps over its seam exceed what is usual in the clip.
    ///
    /// # Errors
    /// Those of [`Usual::read`].
    pub fn closure(&self, clip: &(impl Footage + ?Sized)) -> Result<Closure, Error> {
        let times = self.surface.time.plane(0);
        let ends = |end: Option<&u16>| end.map_or(0, |&end| u32::from(end));
        let sides = Sides::read(clip, &self.jump, ends(times.iter().min())..ends(times.iter().max()))?;
        let around = Stretches::new(&sides, SeamMeasure::Difference)?;
        Ok(Usual::read(clip)?.closure(over_surface(&around, &self.surface).into_iter()))
    }
}

/// A jump that was cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The jump.
    pub jump: Jump,
    /// Frames in which pixels could jump; empty where all jump at once, because the clip has no frames around.
    pub window: Range<u32>,
    /// The price of the seam, in the units of [`SeamCosts`](selvedge_core::SeamCosts).
    pub price: i64,
    /// The price of the best straight seam in the same window.
    pub straight: i64,
    /// Bits by which prices were shortened for the cut, because they were too large for it: 0 almost always.
    pub shift: u32,
    /// How the loop's steps over the seam compare with the clip's own.
    pub closure: Closure,
}

impl Trial {
    /// True if its seam is noticed less than another's, or as much and cheaper.
    fn is_better(&self, other: &Self) -> bool {
        (self.closure.excess(), self.price) < (other.closure.excess(), other.price)
    }
}

/// Counts of one run of [`looped`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopStats {
    /// What was cut, in the order of the jumps, without those that were passed over.
    pub tried: Vec<Trial>,
    /// The number of the one that was taken.
    pub chosen: usize,
}

/// What a run takes however small it is: allocations are given whole pages, and some stay with the allocator. With 64
/// KiB nine of forty runs over 200 frames of 16x16 held up to 104,448 bytes more than were told, with 256 one in some
/// dozens 832 bytes; since steps are measured beside the prices, nine of ten up to 150,336 more with 320.
/// Code that is paged in counts: with 640 the same runs held 2.0, 2.3, 2.4 and 2.9 MB in test programs of 41, 45, 46
/// and 49 MB, the last 187,200 to 314,176 bytes more than were told.
const A_RUN: u64 = 20 << 16;

/// The bytes that [`looped`] holds at most besides the exemplars themselves.
pub fn estimate(clip: Domain<3>, channels: usize, options: &LoopOptions) -> Bytes {
    // Measured: see `tests/it/memory.rs`. Features twice, links and gradients of both sides of the window with two
    // frames around each; then the graph, which takes 51 bytes a node, and the answer.
    let frames = |n: u32| Domain::open([n.min(clip.shape[0]), clip.shape[1], clip.shape[2]]);
    let side = Bytes::of_samples(frames(options.window.saturating_add(4)), 2 * channels as u64 + 1 + 12);
    let whole = Bytes::of_samples(frames(options.window), 56);
    let cut = if options.levels == 1 { whole } else { whole.min(tiled(frames(options.window))) };
    // All smaller frames together are a third.
    let smaller = Bytes::of_samples(frames(options.window.saturating_add(4)), 2 * channels as u64)
        * u64::from(1 < options.levels);
    // By pixel what is shown, between which frames it may change, and how often it does.
    Bytes(A_RUN) + side * 2 + cut + smaller + Bytes::of_samples(frames(1), 64 + 40) + Usual::bytes(clip)
}

/// Cuts jumps along the surface of least price, and takes the one whose loop closes best. `[Kwatra03 7A]`
///
/// The first [`jumps`](LoopOptions::jumps) are cut, and where none of them closes the others as well, but for those
/// whose worst block would step more than that of the best so far even if each block jumped at the time that is best
/// for it.
/// A loop closes if no step over its seam is more than what is usual in the clip, of whole frames (but for
/// [`CLOSES`](super::CLOSES)) and of blocks of 16 x 16 pixels. It is better if the largest step exceeds that by less,
/// of whole frames first; of those that are as good, the one whose seam costs least is taken. Prices alone do not tell:
/// a seam of few frames, where the clip has no more beside a jump, is cheap, and seen.
///
/// Each pixel jumps once a period. All samples are copied whether they are valid or not: a loop shows all of its
/// frames.
///
/// # Errors
/// [`Error::NoJumps`], [`Error::Jump`] for one that is not in the clip, [`Error::OneClip`], [`Error::Frames`], what
/// [`Limits::admit`](selvedge_core::Limits::admit) refuses of the [`estimate`],
/// [`Error::Cut`] and [`Error::Core`] if memory is short.
///
/// # Complexity
/// A jump takes one maximum flow over its window's samples, and about 90 bytes for each of them; jumps are cut one
/// after the other. With [`levels`](LoopOptions::levels) the flow is over a fourth of them at most, then over tiles, at
/// once on the threads of the pool.
///
/// # Events
/// `"transition"` after each jump.
///
/// # Determinism
/// The answer follows from exemplars, jumps and options. Of jumps that are as good the first is taken. If the
/// run is cancelled, it is the best so far, and a straight seam over the first jump if there is none.
pub fn looped(
    clip: &(impl Footage + ?Sized),
    jumps: &[Jump],
    options: &LoopOptions,
    run: &Run<'_, 3>,
) -> Result<Woven<Loop, LoopStats>, Error> {
    let domain = the_clip(clip)?;
    let [frames, height, width] = domain.shape;
    let first = jumps.first().ok_or(Error::NoJumps)?;
    jumps.iter().try_for_each(|jump| jump.check(frames))?;
    // Caps are on what is held at once.
    let held = Domain::open([frames.min(options.window.saturating_add(4)), height, width]);
    run.limits.admit(held, estimate(domain, clip.weights().len(), options))?;
    CoreError::within("levels", options.levels, 1.0..=f64::from(MOST_LEVELS), "1 to 5")?;
    let usual = Usual::read(clip)?;
    let mut stats = LoopStats::default();
    let mut best = Surface::flat(first, [height, width])?;
    let mut complete = true;
    for (number, jump) in jumps.iter().enumerate() {
        let window = window(jump, frames, options.window);
        let extra = stats.tried.get(stats.chosen).filter(|_| options.jumps <= number);
        if number == options.jumps && extra.is_some_and(|trial| trial.closure.is_best()) {
            break;
        }
        let sides = Sides::read(clip, jump, window.clone())?;
        // One that is seen more even where each block jumps when that is best for it.
        if extra.is_some_and(|trial| !trial.closure.may_yield(usual.least_block(&sides))) {
            continue;
        }
        let same = |tried: &&Trial| tried.jump.period() == jump.period() && tried.window == window;
        if let Some(tried) = stats.tried.iter().find(same) {
            // The same frames to be parted at the same times.
            stats.tried.push(Trial { jump: *jump, ..tried.clone() });
            continue;
        }
        let sizes = sizes(sides, options.levels)?;
        let (cut, around) = match transition(sizes, options.seam, &|| run.observer.cancelled()) {
            Ok(cut) => cut,
            Err(error) if error.is_cancelled() => {
                complete = false;
                break;
            }
            Err(error) => return Err(error),
        };
        let closure = usual.closure(over_surface(&around, &cut.surface).into_iter());
        let Transition { surface, price, straight, shift } = cut;
        let tried = Trial { jump: *jump, window, price, straight, shift, closure };
        if stats.tried.get(stats.chosen).is_none_or(|best| tried.is_better(best)) {
            (best, stats.chosen) = (surface, stats.tried.len());
        }
        stats.tried.push(tried);
        run.observer.event(&Event::step("transition", number as u64 + 1, jumps.len() as u64));
    }
    let jump = stats.tried.get(stats.chosen).map_or(*first, |trial| trial.jump);
    Ok(Woven { result: Loop { jump, surface: best, table: clip.table().clone() }, stats, complete })
}
