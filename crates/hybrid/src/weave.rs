//! Block after block: searched, split while it does not fit, laid where it does. `[Ding 3]`

use selvedge_core::{
    Event, Exemplars, Look, Patch, Run, SampleId, SeamCosts, SeamMeasure, SourceMap, Start, Usage, Window, Woven, par,
};
use selvedge_quilting::Continuation;
use selvedge_quilting::search::{BlockScratch, BlockSearch, Candidate, Preference, Space, Successor, Term};

use crate::canvas::Canvas;
use crate::composite::{Compositor, Laying};
use crate::error::Error;
use crate::features::errors_of;
use crate::followed::{Followed, LEAST_FOLLOWED};
use crate::ground::Ground;
use crate::layout::{Block, Blocks};
use crate::options::{Options, Split};
use crate::pixel::{PixelScratch, Pixels};
use crate::stats::{Level, Stats};
use crate::thresholds::{Limit, Of, largest};
use crate::usable::Usable;

/// Blocks of these levels and larger ones count as uses of the exemplar: smaller ones take whatever there is.
const COUNTED_LEVELS: usize = 2;

/// Blocks that are tried beside each other at most: each takes memory.
pub(crate) const AT_ONCE: usize = 4;

/// A window, and what is counted, before or after a block is laid.
struct State {
    held: Vec<(SampleId, u8)>,
    usage: Usage<2>,
    errors: Vec<(u64, u64)>,
    stats: Stats,
}

/// An output in the making.
pub(crate) struct Weaver<'a> {
    options: &'a Options,
    run: &'a Run<'a, 2>,
    exemplars: &'a Exemplars<2>,
    /// The sources that are searched, by their numbers among all.
    numbers: &'a [usize],
    search: BlockSearch<'a>,
    scratch: BlockScratch,
    pixel: PixelScratch,
    under: Look,
    /// What is followed, and the look at what it asks for.
    followed: Option<&'a Followed>,
    asked: Look,
    usage: Usage<2>,
    pub(crate) canvas: Canvas,
    compositor: Compositor<'a>,
    /// What seams show.
    shown: SeamCosts<2>,
    /// A block is split while its error is larger.
    max: Limit,
    /// Sums of errors, and samples they are of, by level.
    errors: Vec<(u64, u64)>,
    pub(crate) stats: Stats,
}

impl<'a> Weaver<'a> {
    pub(crate) fn new(
        usable: &'a Usable<'a>,
        followed: Option<&'a Followed>,
        block: [u32; 2],
        options: &'a Options,
        start: Start<2>,
        run: &'a Run<'a, 2>,
    ) -> Result<Self, Error> {
        let exemplars = usable.all;
        let max = Limit::of(options.max_error, Of::Block, exemplars);
        let pixel = Limit::of(options.pixel_error, Of::Pixel, exemplars);
        let compositor = Compositor {
            exemplars,
            pixels: Pixels::new(exemplars, usable.flags(), options.search, followed)?,
            costs: SeamCosts::new(exemplars, SeamMeasure::Difference)?,
            resynthesize: options.resynthesize,
            // 1 never re-synthesises, also what fits worse than the largest error allowed.
            recut: (options.k < 1.0).then(|| max.part(options.k)),
            pixel,
        };
        let stats =
            Stats { block, max_error: max.shown(exemplars), pixel_error: pixel.shown(exemplars), ..Stats::default() };
        Ok(Self {
            options,
            run,
            exemplars,
            numbers: &usable.numbers,
            pixel: PixelScratch::default(),
            search: BlockSearch::new(&usable.some, usable.followed.as_ref().map(|f| &f.guide), run.simd)?,
            scratch: BlockScratch::default(),
            under: Look::new(),
            followed,
            asked: Look::new(),
            usage: Usage::new(&usable.some, block, options.spread)?,
            canvas: Canvas::new(start)?,
            compositor,
            shown: SeamCosts::new(exemplars, SeamMeasure::Gradient)?,
            max,
            errors: Vec::new(),
            stats,
        })
    }

    /// Lays all blocks.
    pub(crate) fn weave(mut self, blocks: Blocks) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        let mut complete = true;
        for (done, block) in (1..).zip(blocks.iter()) {
            if !self.lay(&block)? {
                complete = false;
                break;
            }
            let so_far = Some(&self.canvas.map as _);
            self.run.observer.event(&Event { so_far, ..Event::step("hybrid", done, blocks.len()) });
        }
        let whole = largest(self.exemplars) as f64;
        for (level, &(error, samples)) in self.stats.levels.iter_mut().zip(&self.errors) {
            level.error = error as f64 / (samples.max(1) as f64 * whole);
        }
        self.stats.laid = self.canvas.marks;
        Ok(Woven { result: self.canvas.map, stats: self.stats, complete })
    }

    /// Lays a block, or what it splits into; false if the run was cancelled.
    fn lay(&mut self, block: &Block) -> Result<bool, Error> {
        let Some(core) = block.core() else { return Ok(true) };
        let domain = self.canvas.domain();
        if core.places(domain).flatten().all(|place| self.canvas.id(place).is_assigned()) {
            return Ok(true);
        }
        if self.run.observer.cancelled() {
            return Ok(false);
        }
        if self.stats.levels.len() <= block.level {
            self.stats.levels.resize(block.level + 1, Level::default());
            self.errors.resize(block.level + 1, (0, 0));
        }
        self.stats.levels[block.level].blocks += 1;
        let (window, before, after) = self.canvas.grown(&core, block.overlap);
        self.under.at_map(self.exemplars, &self.canvas.map, &window, |_| true)?;
        if let Some(followed) = self.followed {
            followed.look(&window, &mut self.asked)?;
        }
        let drawn = self.search(block, &window)?;
        let laying = self.cheapest(&drawn, |chosen| Laying {
            core,
            window,
            before,
            after,
            chosen,
            level: block.level,
            errors: Vec::new(),
        })?;
        let samples = self.under.samples() as u64;
        let fits = match &laying {
            Some(laying) => self.fits(block, laying, samples)?,
            None => false,
        };
        if fits || !block.is_splittable() {
            self.stats.unsplittable += u64::from(!fits);
            self.lay_whole(block, &core, laying.as_ref(), samples)?;
            return Ok(true);
        }
        let Some(laying) = laying.filter(|_| self.options.split == Split::Cheaper) else {
            return self.lay_parts(block);
        };
        // Both are tried, with what is counted; the one that shows less stays.
        let before = self.state(&window)?;
        self.lay_whole(block, &core, Some(&laying), samples)?;
        let (whole, after) = (self.price(&window)?, self.state(&window)?);
        self.go_back(&window, before);
        let complete = self.lay_parts(block)?;
        if complete && whole <= self.price(&window)? {
            self.go_back(&window, after);
        }
        Ok(complete)
    }

    /// Lays what a block splits into; false if the run was cancelled.
    fn lay_parts(&mut self, block: &Block) -> Result<bool, Error> {
        self.stats.levels[block.level].splits += 1;
        for part in block.split() {
            if !self.lay(&part)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Lays a block as it was found.
    fn lay_whole(
        &mut self,
        block: &Block,
        core: &Window<2>,
        laying: Option<&Laying>,
        samples: u64,
    ) -> Result<(), Error> {
        let Some(laying) = laying else { return self.lay_sample(block, core) };
        let sums = &mut self.errors[block.level];
        *sums = (sums.0 + laying.errors.iter().sum::<u64>(), sums.1 + samples);
        let counts = (&mut self.stats, &mut self.pixel);
        self.compositor.lay(laying, &self.under, &mut self.canvas, counts)?;
        if block.level < COUNTED_LEVELS {
            let searched = self.numbers.iter().position(|&s| s == laying.chosen.source);
            searched.into_iter().for_each(|source| self.usage.note(source, laying.chosen.at));
        }
        Ok(())
    }

    /// The price of all seams in a window and around it.
    fn price(&self, window: &Window<2>) -> Result<i64, Error> {
        Ground::new(&self.canvas, window, &self.shown)?.price(|_, _| Ok(()))
    }

    /// What laying a block in a window changes.
    fn state(&self, window: &Window<2>) -> Result<State, Error> {
        Ok(State {
            held: self.canvas.held(window)?,
            usage: self.usage.clone(),
            errors: self.errors.clone(),
            stats: self.stats.clone(),
        })
    }

    fn go_back(&mut self, window: &Window<2>, state: State) {
        self.canvas.put_back(window, state.held);
        (self.usage, self.errors, self.stats) = (state.usage, state.errors, state.stats);
    }

    /// Whether a block need not be split: by what stands, and as long as it is not small by what is asked for as well.
    fn fits(&self, block: &Block, laying: &Laying, samples: u64) -> Result<bool, Error> {
        let stands = (laying.errors.iter().sum(), samples);
        let fits = !self.max.is_passed(stands.0, stands.1);
        match self.followed {
            Some(followed) if LEAST_FOLLOWED < block.shortest() => {
                let guided = errors_of(followed.guide.exemplars(), &self.asked, &laying.window, laying.chosen)?;
                let guided = (guided.iter().sum(), self.asked.samples() as u64);
                let (error, samples) = followed.joined(self.exemplars, stands, guided);
                Ok(fits && !self.max.is_passed(error, samples))
            }
            _ => Ok(fits),
        }
    }

    /// Places for a grown block, drawn among those near the best.
    fn search(&mut self, block: &Block, window: &Window<2>) -> Result<Vec<Candidate>, Error> {
        let terms = match self.followed {
            Some(followed) => followed.terms(self.exemplars, window.shape, (&self.under, &self.asked)),
            None => vec![Term::new(Space::Texture, window.shape, &self.under)],
        };
        let continued = self.continuations(block, window);
        let preference = Preference { per_mille: self.options.per_mille(), usage: &self.usage, continued: &continued };
        let mut rng = self.run.seed.derive("hybrid/block", block.number).derive("hybrid/split", block.path).rng();
        let mut drawn = Vec::new();
        let most = (&mut rng, self.options.tries as usize);
        self.search.draw_some(&terms, &preference, most, &mut self.scratch, &mut drawn)?;
        drawn.iter_mut().for_each(|found| found.source = self.numbers[found.source]);
        Ok(drawn)
    }

    /// Of some places the first whose block would be cut with the cheapest seams, before samples are chosen anew.
    fn cheapest(
        &self,
        drawn: &[Candidate],
        laid: impl Fn(Candidate) -> Laying + Sync,
    ) -> Result<Option<Laying>, Error> {
        let (Some(&first), more) = (drawn.first(), 1 < drawn.len()) else { return Ok(None) };
        let mut best = (i64::MAX, first);
        if more {
            let ground = Ground::new(&self.canvas, &laid(first).window, &self.shown)?;
            let tried = par::map_with(&mut [(); AT_ONCE], drawn.len(), |(), i| {
                let laying = self.measured(laid(drawn[i]))?;
                ground.price(|canvas, by| self.compositor.lay_cut(&laying.moved(by), &self.under, canvas))
            });
            for (&chosen, price) in drawn.iter().zip(tried) {
                let price = price?;
                best = if price < best.0 { (price, chosen) } else { best };
            }
        }
        Ok(Some(self.measured(laid(best.1))?))
    }

    /// How far a block is from what stands, sample by sample.
    fn measured(&self, laying: Laying) -> Result<Laying, Error> {
        let errors = errors_of(self.exemplars, &self.under, &laying.window, laying.chosen)?;
        Ok(Laying { errors, ..laying })
    }

    /// Where the patches under a window would go on: no start block is to lie there, if they are to be avoided.
    fn continuations(&self, block: &Block, window: &Window<2>) -> Vec<Successor> {
        if block.level != 0 || self.options.continuation == Continuation::Allow {
            return Vec::new();
        }
        let patches = self.canvas.map.patches(window);
        let go_on = |patch: &Patch<2>| {
            let source = self.exemplars.sources()[patch.source].domain();
            let at = source.wrapped([0, 1].map(|a| window.start[a] - patch.offset[a])).map(i64::from);
            let number = self.numbers.iter().position(|&s| s == patch.source)?;
            Some(Successor { source: number, at })
        };
        patches.iter().filter_map(go_on).collect()
    }

    /// A sample that no source holds with all that is known around it: the best of those that are searched. All of them
    /// for each would take minutes where a mask is noise, and every sample is such a one.
    fn lay_sample(&mut self, block: &Block, core: &Window<2>) -> Result<(), Error> {
        for place in core.places(self.canvas.domain()).flatten() {
            if let Some(choice) = self.compositor.pixels.choose(&self.canvas, place, &mut self.pixel)? {
                self.canvas.set(place, choice.id, block.level as u8);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use selvedge_core::{Domain, Grid, Origin, Rng, SampleId, Seed, Source, Transform};

    fn exemplars(rng: &mut Rng, masked: bool) -> Exemplars<2> {
        let mut source = |exemplar, shape: [u32; 2]| {
            let domain = Domain::open(shape);
            Source {
                features: Grid::from_vec(domain, 3, (0..3 * domain.len()).map(|_| rng.below(256) as u8).collect())
                    .unwrap(),
                valid: masked
                    .then(|| Grid::from_vec(domain, 1, (0..domain.len()).map(|i| i % 97 != 50).collect()).unwrap())
                    .map(Into::into),
                origin: Origin { exemplar, transform: Transform::IDENTITY },
            }
        };
        Exemplars::from_sources(vec![source(0, [17, 23]), source(1, [20, 14])], vec![77, 150, 29]).unwrap()
    }

    /// `[Ding eq. 1]` sample by sample: the least sum over all places whose samples are all there and valid.
    fn naive(weaver: &Weaver<'_>, window: &Window<2>) -> Option<u64> {
        let (e, map) = (weaver.exemplars, &weaver.canvas.map);
        let at_place = |source: &Source<2>, at: [u32; 2]| {
            let mut sum = 0;
            for local in window.local().positions() {
                let from = source.domain().step(at, local.map(|v| v as i32))?;
                if source.valid.as_deref().is_some_and(|v| !v.get(0, from)) {
                    return None;
                }
                let Some(stands) = window.position(map.domain(), local).and_then(|at| e.locate(map.ids.get(0, at)))
                else {
                    continue;
                };
                for (c, &weight) in e.weights().iter().enumerate() {
                    let d = e.sources()[stands.0].features.get(c, stands.1).abs_diff(source.features.get(c, from));
                    sum += u64::from(weight) * u64::from(d).pow(2);
                }
            }
            Some(sum)
        };
        let all = e.sources().iter().flat_map(|s| s.domain().positions().map(move |at| (s, at)));
        all.filter_map(|(s, at)| at_place(s, at)).min()
    }

    #[test]
    fn the_search_finds_the_least_weighted_error_over_all_that_stands() {
        let mut rng = Seed(2).rng();
        for (masked, circular) in [(false, false), (true, false), (false, true), (true, true)] {
            let e = exemplars(&mut rng, masked);
            let options = Options { block: Some([8, 4]), tolerance: 0.0, spread: 0.0, circular, ..Options::default() };
            let output = Domain { shape: [16, 12], periodic: [false, true] };
            let run = Run::seeded(1);
            let plan = Plan::new(&e, output, &options, &run).unwrap();
            for _ in 0..3 {
                let mut map = SourceMap::unassigned(&e, output).unwrap();
                let holes = 1 + rng.below(4);
                for id in map.ids.plane_mut(0) {
                    if rng.below(holes) == 0 {
                        *id = SampleId::new(rng.below(e.table().len()));
                    }
                }
                let usable = Usable::new(&plan.exemplars, &map, None, None).unwrap();
                let start = Start { map, fixed: None, sources: None };
                let mut weaver = Weaver::new(&usable, None, plan.block, &options, start, &run).unwrap();
                for block in plan.blocks().iter() {
                    let core = block.core().unwrap();
                    let (window, ..) = weaver.canvas.grown(&core, block.overlap);
                    weaver.under.at_map(&e, &weaver.canvas.map, &window, |_| true).unwrap();
                    let found = weaver.search(&block, &window).unwrap().first().copied();
                    let least = naive(&weaver, &window);
                    assert_eq!(found.map(|c| c.error), least, "{masked} {circular}");
                    if let Some(chosen) = found {
                        let errors = errors_of(weaver.exemplars, &weaver.under, &window, chosen).unwrap();
                        assert_eq!(Some(errors.iter().sum()), least);
                        let known = weaver.under.known().iter();
                        assert!(known.zip(&errors).all(|(&known, &error)| known || error == 0));
                    }
                }
            }
        }
    }
}
