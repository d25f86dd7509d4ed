//! Algorithm 1, level by level. `[Kwatra05 3]`

use selvedge_core::{Bytes, Domain, Event, Exemplars, Grid, Run, SourceMap, Woven};

use crate::assignment::{self, Place};
use crate::average::average;
use crate::estimate::estimate;
use crate::falloff::Falloff;
use crate::neighborhoods::Neighborhoods;
use crate::optimized::{Optimized, Pulls};
use crate::picture;
use crate::robust;
use crate::schedule::{self, Schedule};
use crate::search::{Exact, Found, reference};
use crate::stats::{LevelStats, Stats};
use crate::{Error, Level, Options, Search};

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
        let [height, width] = output.shape;
        if output.is_empty() {
            return Err(Error::EmptyOutput { width, height });
        }
        let domains: Vec<_> = exemplars.sources().iter().map(|s| s.domain()).collect();
        run.limits.admit(output, Bytes(estimate(&domains, exemplars.channels(), output, options)))?;
        let schedule = Schedule::new(exemplars, output, &options.schedule)?;
        Ok(Self { exemplars, output, options: options.clone(), schedule })
    }

    /// The levels that fit, in their order.
    pub fn levels(&self) -> &[Level] {
        &self.schedule.levels
    }

    /// Levels of the schedule that do not fit into exemplars or output.
    pub fn left_out(&self) -> &[Level] {
        &self.schedule.left_out
    }

    /// Optimises, from noise or from a map of the same exemplars and the output's shape.
    ///
    /// # Errors
    /// [`Error::ForeignMap`], [`Error::Holes`], [`Error::Masked`], or no memory.
    pub fn weave(&self, start: Option<&SourceMap<2>>, run: &Run<'_, 2>) -> Result<Woven<Optimized, Stats>, Error> {
        let start = start.map(|map| self.shown(map)).transpose()?;
        let mut stats = Stats { left_out: self.schedule.left_out.clone(), ..Stats::default() };
        let mut x: Option<Grid<f64, 2>> = start;
        for (number, &level) in self.schedule.levels.iter().enumerate() {
            let weaver = Weaver::new(self, number, run);
            let begun = x.map(|x| self.to_level(x, level)).transpose()?;
            let ended = weaver.run(begun, &mut stats)?;
            if number + 1 == self.schedule.levels.len() || !ended.complete {
                return self.answer(&weaver, &ended, stats);
            }
            x = Some(ended.x);
        }
        unreachable!("a plan has levels")
    }

    /// The features that a map shows.
    fn shown(&self, map: &SourceMap<2>) -> Result<Grid<f64, 2>, Error> {
        let (found, expected) = (map.domain().shape.to_vec(), self.output.shape.to_vec());
        if map.table != *self.exemplars.table() {
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

    /// Votes at full resolution; of a run that ended before, the map that was there as a finer one.
    fn answer(&self, weaver: &Weaver<'_>, ended: &Ended, stats: Stats) -> Result<Woven<Optimized, Stats>, Error> {
        let pulls = weaver.pulls(&ended.places, &ended.weights);
        let mut halvings = weaver.level.halvings();
        if halvings == 0 {
            return Ok(Woven { result: Optimized::Votes(pulls.votes()?), stats, complete: ended.complete });
        }
        let mut map = pulls.map()?;
        while 0 < halvings {
            halvings -= 1;
            let exemplars = self.schedule.exemplars(self.exemplars, halvings);
            map = map.finer(exemplars, schedule::at(self.output, halvings))?;
        }
        Ok(Woven { result: Optimized::Map(map), stats, complete: ended.complete })
    }
}

/// What a level ends with.
struct Ended {
    x: Grid<f64, 2>,
    /// What `x` is the average of.
    places: Vec<Place>,
    weights: Vec<f64>,
    complete: bool,
}

/// The work at one level.
struct Weaver<'a> {
    options: &'a Options,
    exemplars: &'a Exemplars<2>,
    all: Neighborhoods,
    falloff: Falloff,
    level: Level,
    /// Its number, and how many there are.
    number: usize,
    levels: usize,
    run: &'a Run<'a, 2>,
}

impl<'a> Weaver<'a> {
    fn new(plan: &'a Plan<'_>, number: usize, run: &'a Run<'_, 2>) -> Self {
        let level = plan.schedule.levels[number];
        Self {
            options: &plan.options,
            exemplars: plan.schedule.exemplars(plan.exemplars, level.halvings()),
            all: Neighborhoods::new(schedule::at(plan.output, level.halvings()), level.size),
            falloff: Falloff::new(level.size),
            level,
            number,
            levels: plan.schedule.levels.len(),
            run,
        }
    }

    fn pulls<'b>(&'b self, found: &'b [Place], weights: &'b [f64]) -> Pulls<'b> {
        Pulls { exemplars: self.exemplars, all: &self.all, found, weights, falloff: &self.falloff }
    }

    /// Algorithm 1: from a texture with the search, else from random neighborhoods with the average.
    fn run(&self, begun: Option<Grid<f64, 2>>, stats: &mut Stats) -> Result<Ended, Error> {
        let mut search = Exact::new(self.exemplars, &self.all, self.run.simd);
        let mut counts = self.counts();
        let mut weights = vec![1.0; self.all.len()];
        let (mut x, mut places) = match begun {
            Some(x) => (x, None),
            None => {
                let seed = self.run.seed.derive("texture-optimization/level", self.number as u64);
                let places = assignment::random(self.exemplars, &self.all, seed).ok_or_else(|| self.masked())?;
                (self.average(&places, &weights)?, Some(places))
            }
        };
        let mut complete = true;
        for _ in 0..self.options.iterations {
            let found = self.search(&mut search, &x)?;
            self.note(&mut counts, &found);
            counts.settled = places.as_ref() == Some(&found.places);
            if counts.settled {
                break;
            }
            weights = robust::weights(&found.distances, self.options.robust);
            x = self.average(&found.places, &weights)?;
            places = Some(found.places);
            complete = !self.run.observer.cancelled();
            if !complete {
                break;
            }
        }
        stats.levels.push(counts);
        Ok(Ended { x, places: places.expect("there is an iteration"), weights, complete })
    }

    fn average(&self, places: &[Place], weights: &[f64]) -> Result<Grid<f64, 2>, Error> {
        average(self.exemplars, &self.all, places, weights, &self.falloff)
    }

    fn search(&self, exact: &mut Exact<'_>, x: &Grid<f64, 2>) -> Result<Found, Error> {
        let found = match self.options.search {
            Search::Exact => exact.search(x)?,
            Search::Reference => reference::search(self.exemplars, &self.all, &self.falloff, x),
        };
        found.ok_or_else(|| self.masked())
    }

    fn masked(&self) -> Error {
        Error::Masked { level: self.level }
    }

    fn counts(&self) -> LevelStats {
        LevelStats {
            level: self.level,
            neighborhoods: self.all.len() as u64,
            energy: Vec::new(),
            robust: Vec::new(),
            searched: 0,
            rises: 0,
            settled: false,
        }
    }

    fn note(&self, counts: &mut LevelStats, found: &Found) {
        let energy = robust::energy(&found.distances, self.options.robust);
        // Sums differ in their last bits.
        let rose = counts.robust.last().is_some_and(|&before| before * (1.0 + 1e-12) < energy);
        counts.rises += u32::from(rose);
        counts.robust.push(energy);
        counts.energy.push(robust::mean(&found.distances));
        counts.searched += found.searched as u64;
        let (done, of) = (self.number as u64, self.levels as u64);
        self.run.observer.event(&Event::step("optimizing", done, of));
    }
}

/// A texture that is optimised as a whole: all overlapping neighborhoods of the output are looked for in the exemplars, and the
/// output becomes their average, until nothing changes; from coarse to fine, and from large neighborhoods to small ones.
/// `[Kwatra05 3]`
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars or an output that no neighborhood fits into, an
/// empty output, one over the run's limits (its [`estimate`] counts against their memory), or no memory for it.
///
/// # Complexity
/// An iteration takes `O(output samples * exemplar samples * channels)` at its resolution for neighborhoods that changed,
/// whatever their size. Space `O(output + exemplars)`.
///
/// # Determinism
/// The result follows from exemplars, domain, options and seed alone.
pub fn optimize(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<Optimized, Stats>, Error> {
    Plan::new(exemplars, output, options, run)?.weave(None, run)
}

/// The same from a map instead of noise: it is shown at the resolution where the schedule begins. With a schedule of full
/// resolution alone it is polished: joins that are hard become texture.
///
/// # Errors
/// Those of [`optimize`], [`Error::ForeignMap`] for a map of other sources, [`Error::Holes`].
pub fn optimize_from(
    exemplars: &Exemplars<2>,
    start: &SourceMap<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<Optimized, Stats>, Error> {
    Plan::new(exemplars, start.domain(), options, run)?.weave(Some(start), run)
}
