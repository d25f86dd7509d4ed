//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use std::sync::{Mutex, PoisonError};

use selvedge_core::{Domain, Event, Exemplars, Run, SampleId, SeamCosts, SourceMap, Woven, par};

use crate::candidates::{Candidate, draw, variance};
use crate::canvas::{Canvas, Offer};
use crate::cut::CutScratch;
use crate::error::Error;
use crate::error_cells::CELLS_A_REGION;
use crate::estimate::estimate;
use crate::history::History;
use crate::matching::Matcher;
use crate::options::{Options, Placement};
use crate::patch::Patch;
use crate::period::periodicity;
use crate::region::patches;
use crate::start::Start;
use crate::window::Window;

/// From this periodicity on, all of the exemplar is matched.
const PERIODIC: f64 = 0.5;

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// The placement that was used: never [`Placement::Auto`].
    pub placement: Placement,
    /// What [`Placement::Auto`] chose by: the exemplar's [`periodicity`].
    pub periodicity: Option<f64>,
    /// Side of the error region that was used.
    pub region: u32,
    /// How far patches could reach beyond it.
    pub reach: u32,
    /// Patches laid until everything was covered.
    pub patches: u64,
    /// Patches tried over bad seams.
    pub refinements: u64,
    /// Those of them that made seams cheaper.
    pub improvements: u64,
    /// Cuts that were solved.
    pub cuts: u64,
    /// Positions that cuts decided, over all cuts.
    pub cut_nodes: u64,
    /// Price of all seams when everything was covered, and after each refinement.
    pub energy: Vec<i64>,
}

/// Synthesises an output from patches of the exemplars, cut along the best seams. `[Kwatra03 3, 4]`
///
/// # Errors
/// Wrong options ([`Options::validate`]), an empty output, regions that no exemplar holds, and too little memory.
///
/// # Complexity
/// For `P` patches over exemplars of `N` samples: time `O(P N log N)` for entire-patch matching, and `P` maximum flows
/// over at most `N` nodes each; `P` grows with the output's area. Space `O(output + N)`.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Step number `i` draws from `"graphcut/draw"`, `i`.
pub fn graphcut<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats>, Error> {
    let map = SourceMap::unassigned(exemplars, output)?;
    graphcut_from(exemplars, Start { map, fixed: None, sources: None }, options, run)
}

/// Like [`graphcut`], going on from what is there.
///
/// # Errors
/// Those of [`graphcut`], [`Error::Shape`] and [`Error::ForeignMap`] for a start that does not fit, and
/// [`Error::NoSource`] where a hole may not be filled.
pub fn graphcut_from<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    options: &Options,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats>, Error> {
    options.validate()?;
    start.check(exemplars)?;
    let sources: Vec<Domain<D>> = exemplars.table().sources().iter().map(|(_, domain)| *domain).collect();
    let needed = estimate(&sources, exemplars.channels(), start.map.domain(), options);
    if run.limits.memory < needed {
        return Err(Error::Memory { needed, limit: run.limits.memory });
    }
    let mut weaver = Weaver::new(exemplars, start, options, run)?;
    let outcome = weaver.weave();
    let complete = match outcome {
        Ok(complete) => complete,
        Err(error) if error.is_cancelled() => false,
        Err(error) => return Err(error),
    };
    Ok(Woven { result: weaver.canvas.map, stats: weaver.stats, complete })
}

struct Weaver<'a, const D: usize> {
    canvas: Canvas<'a, D>,
    matcher: Matcher<'a, D>,
    options: &'a Options,
    run: &'a Run<'a, D>,
    placement: Placement,
    region: [u32; D],
    reach: u32,
    /// `k sigma^2`.
    scale: f64,
    history: History<D>,
    scratch: Vec<Mutex<CutScratch<D>>>,
    step: u64,
    /// No hole lies before this place.
    first_hole: usize,
    stats: Stats,
}

impl<'a, const D: usize> Weaver<'a, D> {
    fn new(
        exemplars: &'a Exemplars<D>,
        start: Start<D>,
        options: &'a Options,
        run: &'a Run<'a, D>,
    ) -> Result<Self, Error> {
        let output = start.map.domain();
        let side = region_side(exemplars, options)?;
        let region = std::array::from_fn(|a| side.min(output.shape[a]));
        // Far beyond any output, and still far from the end of positions.
        let reach = options.reach.unwrap_or(side * 2 / 3).min(1 << 24);
        let costs = SeamCosts::new(exemplars, options.seam)?;
        let periodicity = (options.placement == Placement::Auto).then(|| periodicity(exemplars));
        let placement = match options.placement {
            Placement::Auto if PERIODIC <= periodicity.unwrap_or(0.0) => Placement::Entire,
            Placement::Auto => Placement::Sub,
            chosen => chosen,
        };
        Ok(Self {
            canvas: Canvas::new(exemplars, costs, start.map, start.fixed, start.sources, side / CELLS_A_REGION)?,
            matcher: Matcher::new(exemplars)?,
            options,
            run,
            placement,
            region,
            reach,
            scale: options.randomness * variance(exemplars),
            history: History::default(),
            scratch: (0..options.tries).map(|_| Mutex::default()).collect(),
            step: 0,
            first_hole: 0,
            stats: Stats { placement, periodicity, region: side, reach, ..Stats::default() },
        })
    }

    /// False if it was cancelled.
    fn weave(&mut self) -> Result<bool, Error> {
        let holes = self.canvas.holes as u64;
        while 0 < self.canvas.holes {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            self.grow()?;
            self.tell("cover", holes - self.canvas.holes as u64, holes);
        }
        self.stats.energy.push(self.canvas.energy());
        self.refine()
    }

    fn tell(&self, stage: &'static str, done: u64, of: u64) {
        let energy = Some(self.canvas.energy());
        self.run.observer.event(&Event { stage, done, of, energy, so_far: Some(&self.canvas.map) });
    }

    /// Lays a patch over the first hole and what is around it.
    fn grow(&mut self) -> Result<(), Error> {
        let ids = self.canvas.map.ids.plane(0);
        let hole = (self.first_hole..ids.len()).find(|&i| !ids[i].is_assigned());
        let Some(hole) = hole else { return Ok(()) };
        self.first_hole = hole;
        let at = self.canvas.domain().position(hole);
        let mut shape = self.region;
        loop {
            let region = self.region_around(at, shape);
            let hole = unwrapped(at, &region, self.canvas.domain());
            let mut candidates = self.candidates(&region, hole)?;
            if shape == [1; D] && candidates.is_empty() {
                candidates = self.any_sample(hole);
            }
            if let Some(patch) = self.choose(&candidates, &region, 1)?.first() {
                return self.cover(patch, &region);
            }
            if shape == [1; D] {
                return Err(Error::NoSource { at: at.to_vec() });
            }
            // No source holds so large a region without masked samples.
            shape = shape.map(|n| n.div_ceil(2));
        }
    }

    /// Every patch that shows anything at a position.
    fn any_sample(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        let mut found = Vec::new();
        for (source, of) in self.canvas.exemplars.sources().iter().enumerate() {
            let patches = of.domain().positions().map(|from| {
                let offset = std::array::from_fn(|a| at[a] - from[a] as i32);
                Patch { source, offset }
            });
            let shown = patches.filter(|patch| self.canvas.offered(patch, at).is_some());
            found.extend(shown.map(|patch| Candidate { patch, cost: 0.0 }));
        }
        found
    }

    /// A region with a position in its middle, moved inside on open axes.
    fn region_around(&self, at: [u32; D], shape: [u32; D]) -> Window<D> {
        let output = self.canvas.domain();
        let start = std::array::from_fn(|a| {
            let start = at[a] as i32 - shape[a] as i32 / 2;
            let most = (output.shape[a] - shape[a]) as i32;
            if output.periodic[a] { start } else { start.clamp(0, most) }
        });
        Window { start, shape }
    }

    fn cover(&mut self, patch: &Patch<D>, region: &Window<D>) -> Result<(), Error> {
        let window = self.window(patch, region);
        let neighbours = patches(&self.canvas.map, region);
        let offer = {
            let mut scratch = self.scratch[0].lock().unwrap_or_else(PoisonError::into_inner);
            self.canvas.offer(patch, &window, &mut scratch, &|| self.run.observer.cancelled())?
        };
        self.count(&offer);
        self.canvas.lay(&offer);
        self.history.note_vectors(patch, &neighbours);
        self.stats.patches += 1;
        Ok(())
    }

    fn count(&mut self, offer: &Offer<D>) {
        self.stats.cuts += 1;
        self.stats.cut_nodes += offer.cut.nodes as u64;
    }

    /// What of a patch may show: its footprint, as far as patches reach, and not around a periodic axis.
    fn window(&self, patch: &Patch<D>, region: &Window<D>) -> Window<D> {
        let near = self.near(region);
        patch.footprint(self.canvas.exemplars, &near).shared(&near).unwrap_or(*region)
    }

    /// The positions that a patch over a region may touch.
    fn near(&self, region: &Window<D>) -> Window<D> {
        let output = self.canvas.domain();
        let mut near = *region;
        for axis in 0..D {
            let (side, shape) = (output.shape[axis], region.shape[axis]);
            let (mut low, mut high) = (self.reach.min(side), self.reach.min(side));
            if output.periodic[axis] {
                // A patch that went around would meet itself.
                let most = (side - side / 4).max(shape);
                low = low.min((most - shape) / 2);
                high = high.min(most - shape - low);
            }
            let (start, end) = (region.start[axis] - low as i32, region.end(axis) + high as i32);
            let (start, end) = if output.periodic[axis] { (start, end) } else { (start.max(0), end.min(side as i32)) };
            (near.start[axis], near.shape[axis]) = (start, (end - start) as u32);
        }
        near
    }

    /// Patches that cover a region and may show at a position of it.
    fn candidates(&mut self, region: &Window<D>, at: [i32; D]) -> Result<Vec<Candidate<D>>, Error> {
        let mut found = match self.placement {
            Placement::Random => self.random(at),
            Placement::Entire => {
                let near = self.near(region);
                self.matcher.entire(&self.canvas.map, region, &near)?
            }
            Placement::Sub | Placement::Auto => self.matcher.sub(&self.canvas.map, region)?,
        };
        found.retain(|c| self.canvas.offered(&c.patch, at).is_some());
        Ok(found)
    }

    /// Patches that show a random sample at a position.
    fn random(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        let exemplars = self.canvas.exemplars;
        let mut rng = self.run.seed.derive("graphcut/random", self.step).rng();
        let candidate = |_| {
            let id = SampleId::new(rng.below(exemplars.table().len()));
            let (source, from) = exemplars.locate(id)?;
            let offset = std::array::from_fn(|a| at[a] - from[a] as i32);
            Some(Candidate { patch: Patch { source, offset }, cost: 0.0 })
        };
        // Masked samples and those used before are left out afterwards.
        (0..64).filter_map(candidate).collect()
    }

    /// Draws up to `count` candidates; the draw is keyed by the step.
    fn choose(&mut self, all: &[Candidate<D>], region: &Window<D>, count: usize) -> Result<Vec<Patch<D>>, Error> {
        let output = self.canvas.domain();
        let neighbours = patches(&self.canvas.map, region);
        let seed = self.run.seed.derive("graphcut/draw", self.step);
        self.step += 1;
        let fresh = |history: &History<D>| -> Vec<Candidate<D>> {
            all.iter().filter(|c| !history.is_used(&c.patch, output)).copied().collect()
        };
        let mut left = fresh(&self.history);
        if left.is_empty() && !all.is_empty() {
            self.history.forget_used();
            left = fresh(&self.history);
        }
        let least = left.iter().map(|c| c.cost).fold(f64::INFINITY, f64::min);
        left.retain(|c| c.cost - least <= self.scale * 22.5);
        for c in &mut left {
            c.cost += self.scale * self.options.variety * f64::from(self.history.repeats(&c.patch, &neighbours));
        }
        let drawn = draw(&left, self.scale, count, &mut seed.rng());
        for patch in &drawn {
            self.history.note_used(patch, output);
        }
        Ok(drawn)
    }

    /// Lays patches over the worst seams. False if it was cancelled.
    fn refine(&mut self) -> Result<bool, Error> {
        let (mut failures, mut failed) = (0, vec![false; self.canvas.cells.cells.len()]);
        let most = self.stats.patches.max(4) * Options::REFINEMENTS_A_PATCH;
        let limit = self.options.refine.map_or(most, u64::from);
        while self.stats.refinements < limit && failures < self.options.patience {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            let Some((cell, _)) = self.canvas.cells.worst(|cell| !failed[cell]) else { break };
            let region = self.canvas.cells.region(cell, self.region);
            let improved = self.improve(&region)?;
            self.stats.refinements += 1;
            if let Some(window) = improved {
                self.stats.improvements += 1;
                failures = 0;
                for (cell, failed) in failed.iter_mut().enumerate().filter(|(_, f)| **f) {
                    *failed = !self.canvas.cells.region(cell, self.region).meets(&window, self.canvas.domain());
                }
            } else {
                failures += 1;
                failed[cell] = true;
            }
            self.stats.energy.push(self.canvas.energy());
            self.tell("refine", self.stats.refinements, limit);
        }
        Ok(true)
    }

    /// Tries patches over a region and takes the best; answers with the window that changed, if seams became cheaper.
    fn improve(&mut self, region: &Window<D>) -> Result<Option<Window<D>>, Error> {
        let middle = std::array::from_fn(|a| region.start[a] + region.shape[a] as i32 / 2);
        let candidates = self.candidates(region, middle)?;
        let drawn = self.choose(&candidates, region, self.options.tries as usize)?;
        let cancelled = || self.run.observer.cancelled();
        let offers = par::map_indexed(drawn.len(), |i| {
            let window = self.window(&drawn[i], region);
            let mut scratch = self.scratch[i].lock().unwrap_or_else(PoisonError::into_inner);
            self.canvas.offer(&drawn[i], &window, &mut scratch, &cancelled)
        });
        let offers = offers.into_iter().collect::<Result<Vec<_>, _>>()?;
        offers.iter().for_each(|o| self.count(o));
        let best = offers.iter().enumerate().max_by_key(|(i, o)| (o.gain(), std::cmp::Reverse(*i)));
        let Some((i, offer)) = best else { return Ok(None) };
        let neighbours = patches(&self.canvas.map, region);
        if !self.canvas.improve(offer) {
            return Ok(None);
        }
        self.history.note_vectors(&drawn[i], &neighbours);
        Ok(Some(offer.frame.window))
    }
}

/// A position of the output in the turn of its periodic axes that a window is in.
fn unwrapped<const D: usize>(at: [u32; D], window: &Window<D>, output: Domain<D>) -> [i32; D] {
    std::array::from_fn(|a| {
        let (p, side) = (at[a] as i32, output.shape[a] as i32);
        if output.periodic[a] { window.start[a] + (p - window.start[a]).rem_euclid(side) } else { p }
    })
}

/// The side of error regions: as asked, or a quarter of the exemplar.
fn region_side<const D: usize>(exemplars: &Exemplars<D>, options: &Options) -> Result<u32, Error> {
    let shortest = |s: &selvedge_core::Source<D>| s.domain().shape.into_iter().min().unwrap_or(0);
    let largest = exemplars.sources().iter().max_by_key(|s| shortest(s)).map(|s| s.domain().shape).unwrap_or([0; D]);
    let most = largest.into_iter().min().unwrap_or(0);
    match options.region {
        Some(region) if most < region => Err(Error::RegionExceedsExemplar { region, largest: largest.to_vec() }),
        Some(region) => Ok(region),
        None => Ok((most / 4).clamp(most.min(8), 64).max(1)),
    }
}
