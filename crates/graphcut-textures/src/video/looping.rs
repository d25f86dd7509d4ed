//! Loops of one jump.

use selvedge_core::{Domain, Error as CoreError, Run, SeamMeasure, SourceMap, SourceTable, Woven};

use super::banded::MOST_LEVELS;
use super::footage::{Footage, the_clip};
use super::jumps::Jump;
use super::options::LoopOptions;
use super::room::{Room, estimate};
use super::sides::{Halved, Sides};
use super::steps::{Closure, Usual, over_surface};
use super::surface::Surface;
use super::transition::Stretches;
use super::trials::{AT_FULL_SIZE, MOST_AT_FULL_SIZE, Trial, Trials};
use crate::error::Error;

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

/// Counts of one run of [`looped`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopStats {
    /// What was cut, in the order of the jumps, without those that were passed over.
    pub tried: Vec<Trial>,
    /// The number of the one that was taken.
    pub chosen: usize,
    /// Jumps that were cut in frames of half the size, whose prices and steps are told, if any were
    /// [sifted](LoopOptions::sifted): what was tried is the best of them.
    pub halved: Vec<Trial>,
}

/// Cuts jumps along the surface of least price, and takes the one whose loop closes best. `[Kwatra03 7A]`
///
/// The first [`jumps`](LoopOptions::jumps) are cut, in frames of half the size if they are to be
/// [sifted](LoopOptions::sifted), and where none of them closes the others as well, but for those whose worst block
/// would step more than that of the best so far even if each block jumped at the time that is best for it.
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
/// A jump takes one maximum flow over its window's samples, and about 90 bytes for each of them; jumps are cut at once
/// on the threads of the pool as far as they take no more than one whose window is whole. With
/// [`levels`](LoopOptions::levels) the flow is over a fourth of the samples at most, then over tiles, at once on the
/// threads of the pool.
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
    let (domain, channels) = (the_clip(clip)?, clip.weights().len());
    let [frames, height, width] = domain.shape;
    let first = jumps.first().ok_or(Error::NoJumps)?;
    jumps.iter().try_for_each(|jump| jump.check(frames))?;
    // Caps are on what is held at once.
    let held = Domain::open([frames.min(options.window.saturating_add(4)), height, width]);
    run.limits.admit(held, estimate(domain, channels, options))?;
    CoreError::within("levels", options.levels, 1.0..=f64::from(MOST_LEVELS), "1 to 5")?;
    let room = Room::of(domain, channels, options);
    let of = jumps.len() as u64;
    let Some(smaller) = Halved::of(clip).filter(|_| options.sifted && AT_FULL_SIZE < jumps.len()) else {
        return answer(cut_all(clip, jumps, options, run, (room, of))?, Vec::new(), first);
    };
    let (whole, all) = (LoopOptions { levels: 1, ..*options }, of + MOST_AT_FULL_SIZE as u64);
    let mut sifted = cut_all(&smaller, jumps, &whole, run, (room.of_frames(the_clip(&smaller)?, &whole), all))?;
    let mut trials = Trials::new(clip, options, run, (room, [of, all]))?;
    trials.complete = sifted.complete;
    trials.cut_best_of(&sifted)?;
    // What closes at half the size alone kept the others from being tried.
    if !trials.closes() && sifted.closes() && trials.complete {
        sifted.cut_others(&jumps[options.jumps.min(jumps.len())..])?;
        trials.complete = sifted.complete;
        trials.cut_best_of(&sifted)?;
    }
    answer(trials, sifted.tried, first)
}

/// Cuts the first jumps, and where none of these closes, the others.
fn cut_all<'a, F: Footage + ?Sized>(
    clip: &'a F,
    jumps: &[Jump],
    options: &'a LoopOptions,
    run: &'a Run<'a, 3>,
    (room, of): (Room<'a>, u64),
) -> Result<Trials<'a, F>, Error> {
    let mut trials = Trials::new(clip, options, run, (room, [0, of]))?;
    let (whatever, others) = jumps.split_at(options.jumps.min(jumps.len()));
    trials.cut(whatever)?;
    trials.cut_if_better(others)?;
    Ok(trials)
}

/// The best of what was tried, or if nothing was, a straight seam over the first jump.
fn answer<F: Footage + ?Sized>(
    trials: Trials<'_, F>,
    halved: Vec<Trial>,
    first: &Jump,
) -> Result<Woven<Loop, LoopStats>, Error> {
    let Trials { clip, tried, best, complete, .. } = trials;
    let [_, height, width] = the_clip(clip)?.shape;
    let (chosen, surface) = best.map_or_else(|| Ok((0, Surface::flat(first, [height, width])?)), Ok::<_, Error>)?;
    let jump = tried.get(chosen).map_or(*first, |trial| trial.jump);
    let result = Loop { jump, surface, table: clip.table().clone() };
    Ok(Woven { result, stats: LoopStats { tried, chosen, halved }, complete })
}
