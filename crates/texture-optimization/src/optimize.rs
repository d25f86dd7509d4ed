//! Algorithm 1, level by level. `[Kwatra05 3]`

use selvedge_core::{Bytes, Domain, Exemplars, Grid, Guidance, Run, SampleId, SourceMap, Woven};

use crate::assignment::Place;
use crate::came::Came;
use crate::control::{Control, Wishes};
use crate::error::Error;
use crate::estimate::estimate;
use crate::finish;
use crate::level::Level;
use crate::neighborhoods::Neighborhoods;
use crate::optimized::{Held, Optimized};
use crate::options::{Finish, Options};
use crate::picture;
use crate::schedule::{self, Schedule};
use crate::stats::Stats;
use crate::weaver::{Ended, Weaver};

/// What [`optimize`] will do: options checked against exemplars, output and limits, and the levels that fit.
#[derive(Clone, Debug)]
pub struct Plan<'e> {
    exemplars: &'e Exemplars<2>,
    output: Domain<2>,
    options: Options,
    schedule: Schedule,
}

impl<'e> Plan<'e> {
    /// Checks the options, then the output and the run's limits, then which levels fit.
    ///
    /// # Errors
    /// Those of [`optimize`].
    pub fn new(
        exemplars: &'e Exemplars<2>,
        output: Domain<2>,
        options: &Options,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        options.validate()?;
        run.limits.admit(output, Self::bytes(exemplars, output, options))?;
        let schedule = Schedule::new(exemplars, output, &options.schedule)?;
        Ok(Self { exemplars, output, options: options.clone(), schedule })
    }

    fn bytes(exemplars: &Exemplars<2>, output: Domain<2>, options: &Options) -> Bytes {
        let domains = exemplars.domains();
        estimate(&domains, exemplars.channels(), output, options)
    }

    /// The levels that fit, in their order.
    pub fn levels(&self) -> &[Level] {
        &self.schedule.levels
    }

    /// The smallest neighborhoods at full resolution.
    pub(crate) fn smallest(&self) -> u32 {
        let full = self.schedule.levels.iter().filter(|level| level.scale == 1);
        full.map(|level| level.size).min().expect("schedules end at full resolution")
    }

    /// Levels of the schedule that do not fit into exemplars or output.
    pub fn left_out(&self) -> &[Level] {
        &self.schedule.left_out
    }

    /// Optimises, from noise or from a map of the same exemplars and the output's shape.
    ///
    /// # Errors
    /// [`Error::ForeignMap`], [`Error::MapShape`], [`Error::Holes`], [`Error::Masked`], constraints of another shape
    /// than the output ([`Error::Control`]) or out of range (the core's `Amount`, [`Error::NothingFixed`]), a guide of
    /// other exemplars or with a weight that is no number from 0 on (the core's), control that is over the run's
    /// memory, or no memory.
    pub fn weave(
        &self,
        start: Option<&SourceMap<2>>,
        control: &Control,
        run: &Run<'_, 2>,
    ) -> Result<Woven<Optimized, Stats>, Error> {
        // What is followed is channels of the exemplars as well.
        let (both, followed);
        let plan = match control.followed() {
            Some(Guidance { guide, weight }) => {
                both = guide.beside(self.exemplars, *weight)?;
                followed = Plan::new(&both, self.output, &self.options, run)?;
                &followed
            }
            None => self,
        };
        let needed =
            Self::bytes(plan.exemplars, self.output, &self.options) + control.bytes(self.exemplars, self.output);
        run.limits.admit(self.output, needed)?;
        let begun = start.map(|map| plan.shown(map)).transpose()?;
        let wishes = control.wishes(plan.exemplars, self.output, start)?;
        let held = start.zip(control.fixed.as_ref()).map(|(map, fixed)| Held { map, fixed });
        plan.weave_on(begun, (wishes, None), held, run)
    }

    /// The same from features, or noise.
    pub(crate) fn weave_on(
        &self,
        begun: Option<Grid<f64, 2>>,
        (wishes, came): (Option<Wishes>, Option<Came<'_>>),
        held: Option<Held<'_>>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<Optimized, Stats>, Error> {
        let mut wishes: Vec<Wishes> = wishes.into_iter().collect();
        for _ in 0..self.schedule.levels[0].halvings() {
            wishes.extend(wishes.last().map(Wishes::coarser).transpose()?);
        }
        let mut stats = Stats { left_out: self.schedule.left_out.clone(), ..Stats::default() };
        let (mut x, mut before) = (begun, None);
        for (number, &level) in self.schedule.levels.iter().enumerate() {
            let halvings = level.halvings();
            let here = (self.schedule.exemplars(self.exemplars, halvings), schedule::at(self.output, halvings));
            let level_of = (level, number, self.schedule.steps(number, self.options.iterations));
            let finer = |map| self.finer(map, halvings);
            let mut weaver = Weaver::new(&self.options, here, level_of, wishes.get(halvings), run);
            weaver.finer = Some(&finer);
            let begun = x.map(|x| self.to_level(x, level)).transpose()?;
            let larger = before.as_ref().map(|(all, found): &(Neighborhoods, Vec<Place>)| (all, found.as_slice()));
            let came = came.filter(|_| halvings == 0).map(|came| Came { larger, ..came });
            let ended = weaver.run(begun, came, &mut stats)?;
            if number + 1 == self.schedule.levels.len() || !ended.complete {
                return self.answer(&weaver, &ended, (held, wishes.first()), stats);
            }
            x = Some(ended.x);
            before = (halvings == 0).then_some((weaver.all, ended.places));
        }
        unreachable!("a plan has levels")
    }

    /// The features that a map shows.
    pub(crate) fn shown(&self, map: &SourceMap<2>) -> Result<Grid<f64, 2>, Error> {
        let (found, expected) = (map.domain().shape.to_vec(), self.output.shape.to_vec());
        let samples = self.exemplars.table().len();
        let is_foreign = |id: &SampleId| id.is_assigned() && samples <= id.get();
        if map.table != *self.exemplars.table() || map.ids.plane(0).iter().any(is_foreign) {
            return Err(Error::ForeignMap);
        }
        if found != expected {
            return Err(Error::MapShape { expected, found });
        }
        match map.holes() {
            0 => Ok(picture::shown(self.exemplars, map)?.with_periodic(self.output.periodic)),
            holes => Err(Error::Holes { holes }),
        }
    }

    /// The texture at the resolution of a level: halved, or finer step by step.
    fn to_level(&self, mut x: Grid<f64, 2>, level: Level) -> Result<Grid<f64, 2>, Error> {
        let target = schedule::at(self.output, level.halvings());
        while x.domain() != target {
            let halvings = (0..).find(|&h| schedule::at(self.output, h) == x.domain()).unwrap_or(0);
            x = if halvings < level.halvings() {
                picture::coarser(&x)?
            } else {
                picture::finer(&x, schedule::at(self.output, halvings - 1))?
            };
        }
        Ok(x)
    }

    /// A map of a coarser resolution as one of the output.
    fn finer(&self, mut map: SourceMap<2>, halvings: usize) -> Result<SourceMap<2>, Error> {
        for halvings in (0..halvings).rev() {
            let exemplars = self.schedule.exemplars(self.exemplars, halvings);
            map = map.finer(exemplars, schedule::at(self.output, halvings))?;
        }
        Ok(map)
    }

    /// Votes at full resolution; of a run that ended before, or on the way to a map, the map that was there as a finer
    /// one.
    fn answer(
        &self,
        weaver: &Weaver<'_>,
        ended: &Ended,
        (held, wishes): (Option<Held<'_>>, Option<&Wishes>),
        stats: Stats,
    ) -> Result<Woven<Optimized, Stats>, Error> {
        let pulls = weaver.pulls(&ended.places, &ended.weights);
        let halvings = weaver.level.halvings();
        if halvings == 0 && ended.complete && self.options.finish == Finish::Coherent {
            let map = finish::sharp(&pulls, &ended.x, held, wishes)?;
            return Ok(Woven { result: Optimized::Map(map), stats, complete: true });
        }
        // What would have become a map is one: its samples were wanted whole.
        if halvings == 0 && (ended.complete || self.options.finish != Finish::Coherent) {
            return Ok(Woven { result: Optimized::Votes(pulls.votes(held)?), stats, complete: ended.complete });
        }
        let mut map = self.finer(pulls.map()?, halvings)?;
        held.iter().for_each(|held| held.lay(&mut map));
        Ok(Woven { result: Optimized::Map(map), stats, complete: ended.complete })
    }
}

/// A texture that is optimised as a whole: all overlapping neighborhoods of the output are looked for in the exemplars,
/// and the output becomes their average, until nothing changes; from coarse to fine, and from large neighborhoods to
/// small ones.
/// `[Kwatra05 3]`
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars or an output that no neighborhood fits into,
/// an empty output, one over the run's limits (its [`estimate`] counts against their memory), or no memory for it.
///
/// # Complexity
/// An iteration takes `O(output samples * exemplar samples * channels)` at its resolution for neighborhoods that
/// changed, whatever their size. Space `O(output + exemplars)`.
///
/// # Determinism
/// The result follows from exemplars, domain, options and seed alone.
pub fn optimize(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<Optimized, Stats>, Error> {
    Plan::new(exemplars, output, options, run)?.weave(None, &Control::default(), run)
}

/// The same from a map instead of noise: it is shown at the resolution where the schedule begins. With a schedule of
/// full resolution alone it is polished: joins that are hard become texture.
///
/// # Errors
/// Those of [`optimize`], and of [`Plan::weave`].
pub fn optimize_from(
    exemplars: &Exemplars<2>,
    start: &SourceMap<2>,
    control: &Control,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<Optimized, Stats>, Error> {
    Plan::new(exemplars, start.domain(), options, run)?.weave(Some(start), control, run)
}
