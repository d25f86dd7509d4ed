//! Frame after frame. `[Kwatra05 4.1]`

use selvedge_core::{Bytes, Domain, Exemplars, Flow, Run, SourceMap, Woven};

use super::carry::Carried;
use super::origins::{Direction, origins};
use crate::error::Error;
use crate::level::Level;
use crate::optimize::Plan;
use crate::optimized::Optimized;
use crate::options::{Finish, Options, Search};
use crate::picture;
use crate::stats::Stats;
use crate::weaver::Came;

/// Options of an animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// How a frame is optimised. Its finish is [`Finish::Coherent`], since the next frame needs whole samples.
    /// Default: see [`Animation::default`].
    pub frame: Options,
    /// How much a frame is wished to be the one before, moved, where the texture counts 1. Default: 0.1.
    pub lambda: f64,
    /// What vectors say. Default: [`Direction::Forward`].
    pub direction: Direction,
}

impl Default for Animation {
    /// Full resolution alone, as in the paper: what moved there is nearly right, and coarser levels would let it go.
    fn default() -> Self {
        let schedule = [32, 16, 8].map(|size| Level { scale: 1, size }).to_vec();
        Self {
            frame: Options { schedule, iterations: 2, search: Search::Coherent, ..Options::default() },
            lambda: 0.1,
            direction: Direction::Forward,
        }
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
    map: SourceMap<2>,
    carried: Carried,
    /// How far its neighborhoods were when they were looked for first, level by level.
    first: Vec<Vec<f64>>,
}

impl<'e> Animator<'e> {
    /// Begins with a frame that is there, a map of the same exemplars.
    ///
    /// # Errors
    /// Those of [`Plan::new`] with the options of frames, [`Error::Lambda`], [`Error::ForeignMap`], [`Error::Holes`].
    pub fn new(
        exemplars: &'e Exemplars<2>,
        first: SourceMap<2>,
        options: &Animation,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        if !(options.lambda.is_finite() && 0.0 <= options.lambda) {
            return Err(Error::Lambda { lambda: options.lambda as f32 });
        }
        let mut options = options.clone();
        options.frame.finish = Finish::Coherent;
        let plan = Plan::new(exemplars, first.domain(), &options.frame, run)?;
        plan.shown(&first)?;
        let carried = Carried::of(&first);
        Ok(Self { exemplars, options, plan, map: first, carried, first: Vec::new() })
    }

    /// The frame that is there.
    pub fn frame(&self) -> &SourceMap<2> {
        &self.map
    }

    /// Makes the next frame: that which is there, moved, and what a texture makes of it. A run that was cancelled has
    /// nothing.
    ///
    /// # Errors
    /// [`Error::FlowShape`], [`Error::FlowValue`], or no memory.
    pub fn next(&mut self, flow: &Flow, run: &Run<'_, 2>) -> Result<Woven<&SourceMap<2>, FrameStats>, Error> {
        check(flow, self.map.domain())?;
        let flow = Flow { by: flow.by.clone().with_periodic(self.map.domain().periodic), known: flow.known.clone() };
        let origins = origins(&flow, self.options.direction);
        let moved = self.carried.moved(&origins);
        let before = picture::shown(self.exemplars, &self.map)?;
        let wishes = moved.wishes(self.exemplars, (&origins, self.options.lambda), &before)?;
        let sure = wishes.weights.plane(0).iter().filter(|weight| 0.0 < **weight).count();
        let carried = sure as f64 / origins.len().max(1) as f64;
        let begun = wishes.colors.clone();
        let came = Came { carried: &moved, before: &self.first };
        let woven = self.plan.weave_on(Some(begun), (Some(wishes), Some(came)), None, run)?;
        if let Optimized::Map(map) = woven.result {
            self.carried = moved.settled(self.exemplars, &map);
            self.map = map;
        }
        let mut stats = FrameStats { stats: woven.stats, carried };
        self.first = std::mem::take(&mut stats.stats.first);
        Ok(Woven { result: &self.map, stats, complete: woven.complete })
    }
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
    // Where samples come from, where they stand before and now, colours and weights of wishes, and three maps.
    let each = 24 + 3 * 40 + 8 * 2 * channels as u64 + 3 * 4 + 16;
    crate::estimate(exemplars, channels, output, &options.frame) + Bytes::of_samples(output, each)
}
