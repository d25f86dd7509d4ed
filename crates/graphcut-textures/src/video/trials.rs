//! Jumps that are cut, one beside the other, and the one whose seam is seen least.

use std::ops::Range;

use selvedge_core::{Event, Run, par};

use super::footage::{Footage, the_clip};
use super::jumps::Jump;
use super::options::LoopOptions;
use super::room::Room;
use super::sides::{Sides, sizes};
use super::steps::{Closure, Usual, over_surface};
use super::surface::Surface;
use super::transition::{Transition, transition, window};
use crate::error::Error;

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

/// Jumps that are cut at full size, of those that were cut at half of it, and how many more while none of them closes,
/// if no more close there. Of a tree of 320x240 the best two of eight by half size miss by 5 and 10 % of a block's
/// usual step, which half size does not show, and the third closes.
pub(super) const AT_FULL_SIZE: usize = 2;
pub(super) const MOST_AT_FULL_SIZE: usize = 4;

/// What is tried on one clip.
pub(super) struct Trials<'a, F: ?Sized> {
    pub(super) clip: &'a F,
    frames: u32,
    options: &'a LoopOptions,
    run: &'a Run<'a, 3>,
    usual: Usual,
    room: Room<'a>,
    /// Jumps that are done with, of so many.
    progress: [u64; 2],
    /// In the order of the jumps, without those that were passed over.
    pub(super) tried: Vec<Trial>,
    /// The number of the best, and its surface.
    pub(super) best: Option<(usize, Surface)>,
    /// False if the run was cancelled.
    pub(super) complete: bool,
}

impl<'a, F: Footage + ?Sized> Trials<'a, F> {
    pub(super) fn new(
        clip: &'a F,
        options: &'a LoopOptions,
        run: &'a Run<'a, 3>,
        (room, progress): (Room<'a>, [u64; 2]),
    ) -> Result<Self, Error> {
        let (frames, usual) = (the_clip(clip)?.shape[0], Usual::read(clip)?);
        Ok(Self { clip, frames, options, run, usual, room, progress, tried: Vec::new(), best: None, complete: true })
    }

    /// Cuts jumps whatever comes of them.
    pub(super) fn cut(&mut self, jumps: &[Jump]) -> Result<(), Error> {
        self.cut_each(jumps, |_, _| 0.0)
    }

    /// Cuts those that may yet be better than the best: not where that is as good as none, nor those that are seen more
    /// even where each block jumps when that is best for it.
    pub(super) fn cut_if_better(&mut self, jumps: &[Jump]) -> Result<(), Error> {
        if self.closes() { Ok(()) } else { self.cut_others(jumps) }
    }

    /// Cuts those that may be better, whether or not the best is as good as none.
    pub(super) fn cut_others(&mut self, jumps: &[Jump]) -> Result<(), Error> {
        self.cut_each(jumps, Usual::least_block)
    }

    /// Cuts the best of what was tried elsewhere: the first two, and while none of them closes all that close there, or
    /// some more.
    pub(super) fn cut_best_of<G: Footage + ?Sized>(&mut self, sifted: &Trials<'_, G>) -> Result<(), Error> {
        let ranked = sifted.ranked();
        let close = ranked.iter().filter(|trial| trial.closure.is_best()).count();
        let jumps = ranked[..ranked.len().min(close.max(MOST_AT_FULL_SIZE))].iter().map(|trial| trial.jump);
        let new: Vec<Jump> = jumps.filter(|jump| !self.knows(jump)).collect();
        let (first, others) = new.split_at(new.len().min(AT_FULL_SIZE.saturating_sub(self.tried.len())));
        self.cut(first)?;
        others.iter().try_for_each(|jump| self.cut_if_better(std::slice::from_ref(jump)))
    }

    /// Cuts jumps, but for those that would at least step so much that they are no better than the best.
    fn cut_each(&mut self, jumps: &[Jump], least: fn(&Usual, &Sides) -> f64) -> Result<(), Error> {
        let mut left = jumps;
        while !left.is_empty() && self.complete {
            let (some, others) = left.split_at(self.room.fits(left.iter().map(|jump| self.window(jump).len())));
            let read = |i: usize| {
                let sides = Sides::read(self.clip, &some[i], self.window(&some[i]))?;
                let least = least(&self.usual, &sides);
                let known = self.knows(&some[i]) || some[..i].iter().any(|jump| self.is_same(jump, &some[i]));
                let sides = Some(sides).filter(|_| !known && self.may_yield(least));
                Ok(Attempt { jump: some[i], least, sides, cut: None })
            };
            let attempts = (0..some.len()).map(read).collect::<Result<Vec<_>, Error>>()?;
            self.lay(attempts)?;
            left = others;
        }
        Ok(())
    }

    /// Whether the seam of the best is as good as none.
    pub(super) fn closes(&self) -> bool {
        self.best().is_some_and(|trial| trial.closure.is_best())
    }

    /// The best first, and of those that part the same frames at the same times the first alone.
    fn ranked(&self) -> Vec<&Trial> {
        let mut ranked: Vec<&Trial> = Vec::new();
        for trial in &self.tried {
            if ranked.iter().all(|other| !self.is_same(&other.jump, &trial.jump)) {
                let at = ranked.iter().position(|other| trial.is_better(other)).unwrap_or(ranked.len());
                ranked.insert(at, trial);
            }
        }
        ranked
    }

    fn may_yield(&self, least: f64) -> bool {
        self.best().is_none_or(|trial| trial.closure.may_yield(least))
    }

    fn best(&self) -> Option<&Trial> {
        self.best.as_ref().map(|(number, _)| &self.tried[*number])
    }

    fn window(&self, jump: &Jump) -> Range<u32> {
        window(jump, self.frames, self.options.window)
    }

    /// Whether two jumps part the same frames at the same times.
    fn is_same(&self, a: &Jump, b: &Jump) -> bool {
        a.period() == b.period() && self.window(a) == self.window(b)
    }

    fn knows(&self, jump: &Jump) -> bool {
        self.tried.iter().any(|tried| self.is_same(&tried.jump, jump))
    }

    /// Cuts all that are new at once, and notes them in their order, as if they had been cut one after the other.
    fn lay(&mut self, mut attempts: Vec<Attempt>) -> Result<(), Error> {
        let (options, run, usual) = (self.options, self.run, &self.usual);
        par::for_rows(&mut attempts, 1, |_, attempts| {
            for attempt in attempts {
                attempt.cut = attempt.sides.take().map(|sides| cut(attempt.jump, sides, options, run, usual));
            }
        });
        for Attempt { jump, least, cut, .. } in attempts {
            if !self.may_yield(least) {
                continue;
            }
            if let Some(tried) = self.tried.iter().find(|tried| self.is_same(&tried.jump, &jump)) {
                self.tried.push(Trial { jump, ..tried.clone() });
                continue;
            }
            match cut {
                Some(Ok((trial, surface))) => self.note(trial, surface),
                Some(Err(error)) if !error.is_cancelled() => return Err(error),
                _ => {
                    self.complete = false;
                    break;
                }
            }
        }
        Ok(())
    }

    fn note(&mut self, trial: Trial, surface: Surface) {
        if self.best().is_none_or(|best| trial.is_better(best)) {
            self.best = Some((self.tried.len(), surface));
        }
        self.tried.push(trial);
        self.progress[0] += 1;
        self.run.observer.event(&Event::step("transition", self.progress[0], self.progress[1]));
    }
}

/// A jump that is to be cut, and what came of it.
struct Attempt {
    jump: Jump,
    /// What its worst block steps at least.
    least: f64,
    /// The frames around it, unless it need not be cut.
    sides: Option<Sides>,
    cut: Option<Result<(Trial, Surface), Error>>,
}

fn cut(
    jump: Jump,
    sides: Sides,
    options: &LoopOptions,
    run: &Run<'_, 3>,
    usual: &Usual,
) -> Result<(Trial, Surface), Error> {
    let (window, sizes) = (sides.window.clone(), sizes(sides, options.levels)?);
    let (cut, around) = transition(sizes, options.seam, &|| run.observer.cancelled())?;
    let closure = usual.closure(over_surface(&around, &cut.surface).into_iter());
    let Transition { surface, price, straight, shift } = cut;
    Ok((Trial { jump, window, price, straight, shift, closure }, surface))
}
