//! A run of the method: cover the output, then refine it. `[Kwatra03 3, 4]`

use selvedge_core::{
    Domain, Event, Exemplars, Patch, Run, SeamCosts, SourceMap, Start, ValidBoxes, Window, Woven, par,
};
use selvedge_expansion::Scratch;

use crate::canvas::Canvas;
use crate::error::Error;
use crate::error_cells::CELLS_A_REGION;
use crate::few::halved;
use crate::history::History;
use crate::matching::{Matcher, Matches, Single, singles};
use crate::options::{Options, Placement, Stutter};
use crate::settings::{Settings, longest};
use crate::stats::Stats;

/// A run: the output in the making, and what is needed to go on.
pub(crate) struct Weaver<'a, const D: usize> {
    pub(crate) canvas: Canvas<'a, D>,
    pub(crate) matcher: Matcher<'a, D>,
    pub(crate) options: &'a Options<D>,
    pub(crate) run: &'a Run<'a, D>,
    pub(crate) placement: Placement,
    pub(crate) region: [u32; D],
    pub(crate) reach: [u32; D],
    /// The longest sides of sources; of one that tiles without end.
    longest: [u32; D],
    /// What of each source may be used at most.
    pub(crate) boxes: ValidBoxes<'a, D>,
    /// `k sigma^2`.
    pub(crate) scale: f64,
    pub(crate) variety: f64,
    pub(crate) apart: u32,
    pub(crate) stutter: Stutter,
    pub(crate) history: History<D>,
    /// Working memory of the regions that are looked at at once.
    pub(crate) workers: Vec<Worker<D>>,
    pub(crate) step: u64,
    /// Refinements in a row that made nothing better.
    pub(crate) failures: u64,
    /// About how many patches cover the output where no mask leaves gaps.
    pub(crate) usual: u64,
    /// No hole lies before this place.
    pub(crate) first_hole: usize,
    pub(crate) stats: Stats<D>,
}

/// What is kept from one region to the next.
#[derive(Debug, Default)]
pub(crate) struct Worker<const D: usize> {
    pub(crate) matches: Matches<D>,
    pub(crate) cut: Scratch<D>,
}

/// Regions that are refined at once at most, on any number of threads: the map must not depend on these. More would
/// keep more threads busy, but all are chosen before the first is laid: the last of many is no longer among the worst.
pub(crate) const BATCH: usize = 8;

/// Regions that take memory at once, on as many threads as there may be, with exemplars of so many samples.
pub(crate) fn at_once(samples: u64) -> u64 {
    par::at_once(samples).min(BATCH as u64)
}

/// A run at one size that was planned.
///
/// # Errors
/// Those of [`graphcut_from`](crate::graphcut_from).
pub(crate) fn weave_at<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    settings: &Settings<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    worked(exemplars, start, settings, options, run, |weaver| weaver.weave()).map(|(woven, _)| woven)
}

/// What a run has come to beside its map and its counts: what later draws follow from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Past<const D: usize> {
    pub(crate) history: History<D>,
    pub(crate) step: u64,
}

/// Some work of a run, which says whether it came to its end.
///
/// # Errors
/// Those of the work, and of [`Weaver::new`].
pub(crate) fn worked<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    settings: &Settings<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
    work: impl FnOnce(&mut Weaver<'_, D>) -> Result<bool, Error>,
) -> Result<(Woven<SourceMap<D>, Stats<D>>, Past<D>), Error> {
    let boxes = ValidBoxes::of(exemplars);
    let singles = singles(exemplars, boxes.boxes(), start.sources.is_some())?;
    let mut weaver = Weaver::new(exemplars, (boxes, &singles), settings, start, options, run)?;
    let complete = match work(&mut weaver) {
        Ok(complete) => complete,
        Err(error) if error.is_cancelled() => false,
        Err(error) => return Err(error),
    };
    let past = Past { history: weaver.history, step: weaver.step };
    Ok((Woven { result: weaver.canvas.map, stats: weaver.stats, complete }, past))
}

impl<'a, const D: usize> Weaver<'a, D> {
    /// # Errors
    /// Those of [`graphcut_from`](crate::graphcut_from), but for memory limits.
    pub(crate) fn new(
        exemplars: &'a Exemplars<D>,
        (boxes, singles): (ValidBoxes<'a, D>, &'a [Single<D>]),
        settings: &Settings<D>,
        start: Start<D>,
        options: &'a Options<D>,
        run: &'a Run<'a, D>,
    ) -> Result<Self, Error> {
        let output = start.map.domain();
        let region = region_of(settings.region, options.free, output);
        let costs = SeamCosts::new(exemplars, options.seam)?;
        let cells =
            std::array::from_fn(
                |a| if options.free[a] { settings.region[a] / CELLS_A_REGION } else { output.shape[a] },
            );
        let workers = at_once(exemplars.table().len().into()).min(par::threads() as u64);
        Ok(Self {
            canvas: Canvas::new(exemplars, costs, start.map, start.fixed, start.sources, cells)?,
            matcher: Matcher::new(exemplars, singles, (region, options.free), run.simd)?,
            options,
            run,
            placement: settings.placement,
            region,
            reach: settings.reach,
            longest: longest(boxes.domains()),
            boxes,
            scale: settings.scale,
            variety: settings.variety,
            apart: settings.apart,
            stutter: settings.stutter,
            history: History::default(),
            workers: (0..workers).map(|_| Worker::default()).collect(),
            step: 0,
            failures: 0,
            usual: settings.patches(output),
            first_hole: 0,
            stats: Stats::of(settings),
        })
    }

    /// False if it was cancelled.
    pub(crate) fn weave(&mut self) -> Result<bool, Error> {
        self.weave_on(&mut |_| ())
    }

    /// The same, which shows itself whenever another run could go on from where it is.
    pub(crate) fn weave_on(&mut self, keep: &mut dyn FnMut(&Self)) -> Result<bool, Error> {
        Ok(self.cover_all(keep)? && self.refine(keep)?)
    }

    /// Lays patches until no hole is left. False if it was cancelled.
    pub(crate) fn cover_all(&mut self, keep: &mut dyn FnMut(&Self)) -> Result<bool, Error> {
        let holes = self.canvas.holes as u64;
        self.strew();
        while 0 < self.canvas.holes {
            keep(self);
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            let step = self.step;
            match self.grow() {
                Err(error) if error.is_cancelled() => {
                    if self.step == step {
                        keep(self);
                    }
                    return Ok(false);
                }
                grown => grown?,
            }
            self.tell("cover", holes - self.canvas.holes as u64, holes);
        }
        // What goes on from refinements was covered before.
        if self.stats.energy.is_empty() {
            self.stats.energy.push(self.canvas.energy());
        }
        Ok(true)
    }

    pub(crate) fn tell(&self, stage: &'static str, done: u64, of: u64) {
        let energy = Some(self.canvas.energy());
        let step = Event::step(stage, done, of);
        self.run.observer.event(&Event { energy, so_far: Some(&self.canvas.map), ..step });
    }

    /// Lays a patch over the first hole and what is around it.
    fn grow(&mut self) -> Result<(), Error> {
        let ids = self.canvas.map.ids.plane(0);
        let hole = (self.first_hole..ids.len()).find(|&i| !ids[i].is_assigned());
        let Some(hole) = hole else { return Ok(()) };
        self.first_hole = hole;
        let at = self.canvas.domain().position(hole);
        let mut shape = self.region;
        if self.fill_gaps(&self.region_around(at, shape), at)? {
            return Ok(());
        }
        loop {
            let region = self.region_around(at, shape);
            let hole = region.unwrapped(self.canvas.domain(), at);
            let mut worker = std::mem::take(&mut self.workers[0]);
            let drawn = self.choose(&region, hole, 1, self.step, &mut worker.matches)?;
            // Before anything is noted, so that what is cancelled here is as if it had not begun.
            let covered = drawn.patches.first().map(|patch| self.cover(patch, &region, &mut worker.cut)).transpose()?;
            self.step += 1;
            self.note_drawn(&drawn);
            self.workers[0] = worker;
            if covered.is_some() {
                return Ok(());
            }
            if shape == [1; D] {
                return Err(selvedge_core::Error::NoSource { at: at.to_vec() }.into());
            }
            // No source holds so large a region without masked samples.
            shape = halved(shape);
        }
    }

    /// A region with a position in its middle, moved inside on open axes.
    fn region_around(&self, at: [u32; D], shape: [u32; D]) -> Window<D> {
        let output = self.canvas.domain();
        let start = std::array::from_fn(|a| {
            let start = at[a] as i32 - shape[a] as i32 / 2;
            let most = (output.shape[a] - shape[a]) as i32;
            let anywhere = output.periodic[a] && self.options.free[a];
            if anywhere { start } else { start.clamp(0, most) }
        });
        Window { start, shape }
    }

    fn cover(&mut self, patch: &Patch<D>, region: &Window<D>, scratch: &mut Scratch<D>) -> Result<(), Error> {
        let window = self.window(patch, region);
        let neighbours = self.canvas.map.patches(region);
        self.cut_in(patch, &window, scratch)?;
        self.history.note_vectors(patch, &neighbours);
        self.stats.patches += 1;
        Ok(())
    }

    /// Cuts a patch, seen through a window, into what is there; it fills what it can.
    pub(crate) fn cut_in(
        &mut self,
        patch: &Patch<D>,
        window: &Window<D>,
        scratch: &mut Scratch<D>,
    ) -> Result<(), Error> {
        let offer = self.canvas.offer(patch, window, scratch, &|| self.run.observer.cancelled())?;
        self.count(offer.proposal.free);
        self.canvas.lay(&offer);
        Ok(())
    }

    pub(crate) fn count(&mut self, nodes: usize) {
        self.stats.cuts += 1;
        self.stats.cut_nodes += nodes as u64;
    }

    /// What of a patch may show: its footprint within reach of its region, as far as the output goes.
    pub(crate) fn window(&self, patch: &Patch<D>, region: &Window<D>) -> Window<D> {
        let near = self.near(region).inside(self.canvas.domain());
        patch.footprint(self.canvas.exemplars, &near).shared(&near).unwrap_or(*region)
    }

    /// Where a patch over a region may show, also beyond the output: it has the same shape wherever the region is. No
    /// farther than the longest source goes beyond the region: a search pays for all that it is asked to look at (512^2
    /// with `reach` without end took 2.3 s to cover, and takes 0.4).
    pub(crate) fn near(&self, region: &Window<D>) -> Window<D> {
        let output = self.canvas.domain();
        let mut near = *region;
        for axis in 0..D {
            let (side, shape) = (output.shape[axis], region.shape[axis]);
            if !self.options.free[axis] {
                (near.start[axis], near.shape[axis]) = (0, side);
                continue;
            }
            let longest = self.longest[axis].saturating_sub(shape);
            let reach = self.reach[axis].min(side).min(longest);
            let (mut low, mut high) = (reach, reach);
            if output.periodic[axis] {
                // A patch that went around would meet itself.
                let most = side - side / 4;
                low = low.min((most - shape) / 2);
                high = high.min(most - shape - low);
            }
            near.start[axis] -= low as i32;
            near.shape[axis] += low + high;
        }
        near
    }
}

/// The shape of error regions: no longer than the output, and short enough for a patch not to meet itself around it,
/// unless that is where it lies anyway.
fn region_of<const D: usize>(sides: [u32; D], free: [bool; D], output: Domain<D>) -> [u32; D] {
    std::array::from_fn(|a| {
        let n = output.shape[a];
        sides[a].min(if output.periodic[a] && free[a] { n - n / 4 } else { n })
    })
}
