//! Frame after frame. `[Kwatra05 4.1]`

use selvedge_core::{
    Bytes, CameFrom, Direction, Domain, Error as CoreError, Exemplars, Flow, Grid, Origin, Run, SampleId, SourceMap,
    Woven,
};

use super::carry::Carried;
use super::closing::Closing;
use super::trust::trusted;
use crate::came::Came;
use crate::control::{self, Wanted};
use crate::error::Error;
use crate::level::Level;
use crate::optimize::Plan;
use crate::optimized::Optimized;
use crate::options::{Finish, Options, Search};
use crate::picture;
use crate::stats::Stats;

/// Options of an animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// How a frame is optimised. Its finish is [`Finish::Coherent`], since the next frame needs whole samples; what
    /// came is kept where it fits, so that [`Search::Coherent`] has no [`spread`](Options::spread). Default: see
    /// [`Animation::default`].
    pub frame: Options,
    /// How much a frame is wished to be the one before, moved, where the texture counts 1; up to a million. Default:
    /// 0.1.
    pub lambda: f64,
    /// What vectors say. Default: [`Direction::Forward`].
    pub direction: Direction,
}

impl Default for Animation {
    /// Full resolution alone, as in the paper: what moved there is nearly right, and coarser levels would let it go.
    fn default() -> Self {
        let schedule = [32, 16, 8].map(|size| Level { scale: 1, size }).to_vec();
        Self {
            frame: Options { schedule, iterations: 3, search: Search::Coherent, ..Options::default() },
            lambda: 0.1,
            direction: Direction::Forward,
        }
    }
}

impl Animation {
    /// Checks what can be checked without an exemplar.
    ///
    /// # Errors
    /// Those of [`Options::validate`], [`Error::Spread`], and of the core [`Amount`](selvedge_core::Error::Amount).
    pub fn validate(&self) -> Result<(), Error> {
        self.frame.validate()?;
        if self.frame.search == Search::Coherent && self.frame.spread != 0.0 {
            return Err(Error::Spread);
        }
        Wanted::check_lambda(self.lambda)
    }
}

/// Counts of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameStats {
    /// Those of its optimisation.
    pub stats: Stats,
    /// The share of its samples that came from the frame before.
    pub carried: f64,
}

/// A texture that flows, frame after frame. `[Kwatra05 4.1]`
#[derive(Clone, Debug)]
pub struct Animator<'e> {
    exemplars: &'e Exemplars<2>,
    options: Animation,
    plan: Plan<'e>,
    /// The frame that is there.
    pub(super) map: SourceMap<2>,
    pub(super) carried: Carried,
    /// What the first frame showed.
    pub(super) begun: Vec<SampleId>,
    /// Frames that lead back to it, where they have begun.
    closing: Option<Closing>,
    /// How many of them there are already.
    pub(super) closed: usize,
    /// How far neighborhoods were in the mean when the first frame that moved was looked for, level by level; until one
    /// does, when the first of all was.
    pub(super) first: Vec<f64>,
    /// How far what moved into that frame was from the places that it came from.
    pub(super) usual: Option<f64>,
}

impl<'e> Animator<'e> {
    /// Begins with a frame that is there, a map of the same exemplars.
    ///
    /// # Errors
    /// Those of [`Animation::validate`] and [`Plan::new`], one over the run's limits (its [`animation_estimate`]
    /// counts), [`Error::ForeignMap`], [`Error::Holes`].
    pub fn new(
        exemplars: &'e Exemplars<2>,
        first: SourceMap<2>,
        options: &Animation,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        options.validate()?;
        let domains = exemplars.domains();
        let needed = animation_estimate(&domains, exemplars.channels(), first.domain(), options);
        run.limits.admit(first.domain(), needed)?;
        let mut options = options.clone();
        options.frame.finish = Finish::Coherent;
        let plan = Plan::new(exemplars, first.domain(), &options.frame, run)?;
        plan.shown(&first)?;
        let carried = Carried::of(&first)?;
        let begun = first.ids.plane(0).to_vec();
        let (map, first) = (first, Vec::new());
        Ok(Self { exemplars, options, plan, map, carried, begun, closing: None, closed: 0, first, usual: None })
    }

    /// The frame that is there.
    pub fn frame(&self) -> &SourceMap<2> {
        &self.map
    }

    /// The next frame, and those after it, are of other exemplars: another frame of a clip, whose parts stay where they
    /// are while what they show goes on. What flows then glitters, or burns, by itself. `[Kwatra05 6]`
    ///
    /// Frames that [close](Self::close) lead to the first one's places, so that what they show has to have come around.
    ///
    /// # Errors
    /// [`Error::ForeignMap`] for sources of other shapes or orientations than the frame that is there comes from, and
    /// those of [`Plan::new`].
    pub fn turn_to(&mut self, exemplars: &'e Exemplars<2>, run: &Run<'_, 2>) -> Result<(), Error> {
        let like = |(own, other): (&(Origin, Domain<2>), &(Origin, Domain<2>))| {
            (own.0.transform, own.1) == (other.0.transform, other.1)
        };
        let (own, others) = (self.exemplars.table().sources(), exemplars.table().sources());
        if own.len() != others.len() || !own.iter().zip(others).all(like) {
            return Err(Error::ForeignMap);
        }
        self.plan = Plan::new(exemplars, self.map.domain(), &self.options.frame, run)?;
        self.exemplars = exemplars;
        self.map.table = exemplars.table().clone();
        Ok(())
    }

    /// From now on leads back to the first frame: over as many frames as there are flows, of which the last leads from
    /// the last frame to the first, which is not made again. Beside each flow, where a body is in the frame that it
    /// leads to, if it does not fill it.
    ///
    /// # Errors
    /// [`Error::FlowShape`], [`Error::FlowValue`], [`Error::Control`] for a body of another shape,
    /// [`Error::Checkpoint`] where more frames have closed already, or no memory: as much as [`closing_bytes`] tells.
    pub fn close<'f>(
        &mut self,
        flows: impl DoubleEndedIterator<Item = (&'f Flow, Option<&'f Grid<bool, 2>>)> + ExactSizeIterator + Clone,
        run: &Run<'_, 2>,
    ) -> Result<(), Error> {
        let output = self.map.domain();
        flows.clone().try_for_each(|(flow, within)| self.check(flow, within))?;
        if flows.len() < self.closed {
            return Err(Error::Checkpoint { what: "frames that close are fewer" });
        }
        run.limits.admit(output, closing_bytes(output, flows.len() as u32))?;
        let direction = self.options.direction.reversed();
        let back = flows.rev().map(|(flow, within)| came_from(flow, direction, (output, within)));
        let begun = Carried::of_ids(&self.begun, &self.map)?;
        let mut closing = Closing::new(&begun, output, back, run.seed)?;
        (0..self.closed).for_each(|_| _ = closing.go_on());
        self.closing = Some(closing);
        Ok(())
    }

    fn check(&self, flow: &Flow, within: Option<&Grid<bool, 2>>) -> Result<(), Error> {
        let output = self.map.domain();
        check(flow, output)?;
        within.map_or(Ok(()), |within| control::check("body that flows", within, output, 1))
    }

    /// Makes the next frame: that which is there, moved, and what a texture makes of it. A run that was cancelled
    /// leaves the frame that was there, and all else as it was.
    ///
    /// `within` is where a body that flows is in the frame that is there, if it does not fill it: what comes from
    /// outside of it is made anew, whatever stands there.
    ///
    /// # Errors
    /// [`Error::FlowShape`], [`Error::FlowValue`], [`Error::Control`] for a body of another shape, or no memory.
    pub fn next(
        &mut self,
        flow: &Flow,
        within: Option<&Grid<bool, 2>>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<&SourceMap<2>, FrameStats>, Error> {
        let output = self.map.domain();
        self.check(flow, within)?;
        let mut origins = came_from(flow, self.options.direction, (output, within))?;
        let moves = origins.iter().zip(output.positions()).any(|(origin, at)| origin.at != at.map(f64::from));
        // What a frame that stays shows is no measure of those that move.
        let is_first = moves && self.usual.is_none();
        let mut before = picture::shown(self.exemplars, &self.map)?;
        let body = within.map(|within| self.carried.of_body(within, &mut before)).transpose()?;
        let mut moved = body.as_ref().unwrap_or(&self.carried).moved(&origins)?;
        if let Some(closing) = &self.closing {
            closing.pass(output, &mut moved, &mut origins);
        }
        let (mut wishes, sure) = moved.wishes(self.exemplars, (&origins, self.options.lambda), &before)?;
        let carried = sure as f64 / origins.len().max(1) as f64;
        let fit = trusted(self.exemplars, (&moved, self.plan.smallest()), &mut wishes, self.usual)?;
        let begun = wishes.colors.clone();
        let came = Came { carried: &moved, first: if is_first { &[] } else { &self.first }, larger: None };
        let woven = self.plan.weave_on(Some(begun), (Some(wishes), Some(came)), None, run)?;
        let mut stats = FrameStats { stats: woven.stats, carried };
        let first = std::mem::take(&mut stats.stats.first);
        if let Optimized::Map(map) = woven.result
            && woven.complete
        {
            self.carried = moved.settled(self.exemplars, &map)?;
            self.map = map;
            self.usual = self.usual.or(is_first.then_some(fit));
            if is_first || self.first.is_empty() {
                self.first = first;
            }
            self.closed += usize::from(self.closing.as_mut().is_some_and(Closing::go_on));
        }
        Ok(Woven { result: &self.map, stats, complete: woven.complete })
    }
}

/// Where samples come from, by a flow that goes around where the output does; nothing from outside of a body is sure.
fn came_from(
    flow: &Flow,
    direction: Direction,
    (output, within): (Domain<2>, Option<&Grid<bool, 2>>),
) -> Result<Vec<CameFrom>, CoreError> {
    let known = flow.known.as_ref().map(|known| known.map(|v| v)).transpose()?;
    let flow = Flow { by: flow.by.map(|v| v)?.with_periodic(output.periodic), known };
    let mut origins = flow.came_from(direction)?;
    if let Some(within) = within {
        origins.iter_mut().for_each(|origin| origin.is_sure &= within.get(0, origin.nearest(output).0));
    }
    Ok(origins)
}

/// Refuses a flow that does not lie over the output, or says no numbers.
fn check(flow: &Flow, output: Domain<2>) -> Result<(), Error> {
    let (found, expected) = (flow.domain().shape, output.shape);
    let mask = flow.known.as_ref().map_or(found, |known| known.domain().shape);
    if found != expected || mask != expected || flow.by.channels() != 2 {
        return Err(Error::FlowShape { expected, found });
    }
    let odd = flow.odd().next();
    match odd {
        Some([y, x]) => Err(Error::FlowValue { x, y }),
        None => Ok(()),
    }
}

/// An upper bound of the bytes that an [`Animator`] holds beside the exemplars' features.
pub fn animation_estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Animation) -> Bytes {
    // Where samples come from, where they stand at first, before, in a body and now, colours and weights of wishes, and
    // three maps.
    let each = 24 + 9 + 5 * 40 + 8 * 2 * channels as u64 + 3 * 4 + 16;
    crate::estimate(exemplars, channels, output, &options.frame) + Bytes::of_samples(output, each)
}

/// An upper bound of the bytes that [`Animator::close`] takes besides, over so many frames.
pub fn closing_bytes(output: Domain<2>, frames: u32) -> Bytes {
    // Where samples stand, whether that is sure; where they come from, of one frame at a time.
    Bytes::of_samples(output, 40 + 1) * u64::from(frames) + Bytes::of_samples(output, 24)
}
