//! Which patch comes next: what may be laid over a region, and the draw among it. `[Kwatra03 4]`

use selvedge_core::{Patch, SampleId, Window};

use crate::candidates::{Candidate, NOTHING, Shortlist, draw};
use crate::error::Error;
use crate::matching::Matches;
use crate::options::{Placement, Stutter};
use crate::reflection::{reflects, stutters};
use crate::usable::Usable;
use crate::weaver::Weaver;

/// Patches that [`Placement::Random`] draws from, and draws after which it takes fewer. All cost the same, and the draw
/// takes one, or `tries`, of which there are 64 at most. Masks and regions as large as the exemplar make most draws
/// miss.
const RANDOM: usize = 64;
const MOST_DRAWS: usize = 4096;

/// What a patch is wanted for.
struct Here<'a, const D: usize> {
    /// It covers the region,
    region: &'a Window<D>,
    /// shows at this position of it,
    at: [i32; D],
    /// comes from one of these sources,
    usable: Usable,
    /// reflects none of these,
    neighbours: &'a [Patch<D>],
    /// lies as far from where one of them shows the same,
    apart: u32,
    /// and was not used before, unless that is to be forgotten.
    forgets: bool,
}

/// Patches for a region, the first drawn first.
#[derive(Debug)]
pub(crate) struct Draw<const D: usize> {
    pub(crate) patches: Vec<Patch<D>>,
    /// True if they were all used before, and so was every other.
    forgets: bool,
}

impl<const D: usize> Weaver<'_, D> {
    /// Draws up to `count` patches that cover a region and show at a position of it; the draw is keyed by the step.
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn choose(
        &self,
        region: &Window<D>,
        at: [i32; D],
        count: usize,
        step: u64,
        matches: &mut Matches<D>,
    ) -> Result<Draw<D>, Error> {
        let usable = Usable::of(&self.canvas, region, at);
        // What is drawn without a search may be masked in part.
        let searches = self.placement != Placement::Random;
        if searches && region.shape != [1; D] && !self.matcher.holds(region.shape, usable) {
            return Ok(Draw { patches: Vec::new(), forgets: false });
        }
        let near = if self.placement == Placement::Entire { self.near(region) } else { *region };
        if searches {
            self.matcher.search(&self.canvas.map, region, &near, usable, matches)?;
        }
        let neighbours = self.canvas.map.patches(region);
        let mut here = Here { region, at, usable, neighbours: &neighbours, apart: self.apart, forgets: false };
        let mut list = self.shortlist(&here, step, matches);
        if list.is_empty() && 0 < here.apart {
            here = Here { apart: 0, ..here };
            list = self.shortlist(&here, step, matches);
        }
        if list.is_empty() {
            // Every offset that fits was used, or reflects what is there.
            here = Here { neighbours: &[], forgets: true, ..here };
            list = self.shortlist(&here, step, matches);
        }
        if list.is_empty() && region.shape == [1; D] {
            // What shows here agrees with nothing around: any sample is better than none.
            list = self.fresh(self.everything(at), &here);
        }
        for c in &mut list {
            c.cost += self.scale * self.variety * self.history.repeats(&c.patch, &neighbours);
        }
        let seed = self.run.seed.derive("graphcut/draw", step);
        let patches = draw(&list, self.scale, count, &mut seed.rng());
        Ok(Draw { forgets: here.forgets && !patches.is_empty(), patches })
    }

    /// Notes what was drawn as used.
    pub(crate) fn note_drawn(&mut self, drawn: &Draw<D>) {
        if drawn.forgets {
            self.history.forget_used();
        }
        for patch in &drawn.patches {
            let source = self.canvas.exemplars.sources()[patch.source].domain();
            self.history.note_used(patch, source, self.canvas.domain());
        }
    }

    /// The patches that have a chance in the draw.
    fn shortlist(&self, here: &Here<'_, D>, step: u64, matches: &Matches<D>) -> Vec<Candidate<D>> {
        match self.placement {
            Placement::Random => self.fresh(self.random(here, step), here),
            _ => self.fresh(self.matcher.found(matches), here),
        }
    }

    /// The cheapest of some candidates that show here, were not used before and neither reflect nor repeat a neighbour.
    fn fresh(&self, candidates: impl IntoIterator<Item = Candidate<D>>, here: &Here<'_, D>) -> Vec<Candidate<D>> {
        let mut list = Shortlist::new(self.scale * NOTHING);
        let exemplars = self.canvas.exemplars;
        let repeats = |patch: &Patch<D>, other| {
            let source = exemplars.sources()[patch.source].domain();
            let may_stutter = || self.stutter == Stutter::Once && self.history.times(patch, other) == 0;
            stutters(patch, other, source, here.apart) && !may_stutter()
                || reflects(patch, other, exemplars, here.region)
        };
        let fresh = |patch: &Patch<D>| {
            here.usable.has(patch.source)
                && self.canvas.offered(patch, here.at).is_some()
                && !self.was_used(patch, here)
                && !here.neighbours.iter().any(|n| repeats(patch, n))
        };
        candidates.into_iter().for_each(|c| list.offer(c, || fresh(&c.patch)));
        list.finish()
    }

    fn was_used(&self, patch: &Patch<D>, here: &Here<'_, D>) -> bool {
        let source = self.canvas.exemplars.sources()[patch.source].domain();
        !here.forgets && self.history.is_used(patch, source, self.canvas.domain())
    }

    /// Patches that cover a region, anywhere; if none was found that was not used before, some that were.
    fn random(&self, here: &Here<'_, D>, step: u64) -> Vec<Candidate<D>> {
        let (samples, region) = (self.boxes.len(), here.region);
        let mut rng = self.run.seed.derive("graphcut/random", step).rng();
        let (mut fresh, mut used) = (Vec::new(), Vec::new());
        for _ in 0..MOST_DRAWS {
            let Some(mut candidate) = self.showing(self.boxes.sample(rng.below(samples)), region.start) else {
                continue;
            };
            (0..D).filter(|&a| !self.options.free[a]).for_each(|a| candidate.patch.offset[a] = 0);
            let source = self.canvas.exemplars.sources()[candidate.patch.source].domain();
            let end = std::array::from_fn::<_, D, _>(|a| region.end(a) - candidate.patch.offset[a]);
            if (0..D).any(|a| !source.periodic[a] && (source.shape[a] as i32) < end[a]) {
                continue;
            }
            if self.was_used(&candidate.patch, here) { &mut used } else { &mut fresh }.push(candidate);
            if fresh.len() == RANDOM {
                break;
            }
        }
        if fresh.is_empty() { used } else { fresh }
    }

    /// Every patch that shows anything at a position.
    fn everything(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        let lies = |c: &Candidate<D>| (0..D).all(|a| self.options.free[a] || c.patch.offset[a] == 0);
        self.boxes.samples(0..self.boxes.len()).filter_map(|id| self.showing(id, at)).filter(lies).collect()
    }

    /// The patch that shows a sample at a position.
    fn showing(&self, id: SampleId, at: [i32; D]) -> Option<Candidate<D>> {
        let (source, from) = self.canvas.exemplars.locate(id)?;
        let offset = std::array::from_fn(|a| at[a] - from[a] as i32);
        Some(Candidate { patch: Patch { source, offset }, cost: 0.0 })
    }
}
