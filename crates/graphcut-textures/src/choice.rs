//! Which patch comes next: what may be laid over a region, and the draw among it. `[Kwatra03 4]`

use selvedge_core::SampleId;

use crate::candidates::{Candidate, NOTHING, Shortlist, draw};
use crate::error::Error;
use crate::options::Placement;
use crate::patch::Patch;
use crate::region::patches;
use crate::weaver::Weaver;
use crate::window::Window;

/// Positions that [`Placement::Random`] draws from.
const RANDOM: usize = 64;

impl<const D: usize> Weaver<'_, D> {
    /// Draws up to `count` patches that cover a region and show at a position of it; the draw is keyed by the step.
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn choose(&mut self, region: &Window<D>, at: [i32; D], count: usize) -> Result<Vec<Patch<D>>, Error> {
        match self.placement {
            Placement::Random => {}
            Placement::Entire => self.matcher.search(&self.canvas.map, region, &self.near(region))?,
            Placement::Sub | Placement::Auto => self.matcher.search(&self.canvas.map, region, region)?,
        }
        let mut list = self.shortlist(at);
        if list.is_empty() {
            // Every offset that fits was used.
            self.history.forget_used();
            list = self.shortlist(at);
        }
        if list.is_empty() && region.shape == [1; D] {
            // What shows here agrees with nothing around: any sample is better than none.
            list = self.fresh(self.everything(at), at);
        }
        let neighbours = patches(&self.canvas.map, region);
        for c in &mut list {
            c.cost += self.scale * self.options.variety * f64::from(self.history.repeats(&c.patch, &neighbours));
        }
        let seed = self.run.seed.derive("graphcut/draw", self.step);
        self.step += 1;
        let drawn = draw(&list, self.scale, count, &mut seed.rng());
        for patch in &drawn {
            self.history.note_used(patch, self.canvas.domain());
        }
        Ok(drawn)
    }

    /// The patches that have a chance in the draw.
    fn shortlist(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        match self.placement {
            Placement::Random => self.fresh(self.random(at), at),
            _ => self.fresh(self.matcher.found(), at),
        }
    }

    /// The cheapest of some candidates that show at a position and were not used before.
    fn fresh(&self, candidates: impl IntoIterator<Item = Candidate<D>>, at: [i32; D]) -> Vec<Candidate<D>> {
        let output = self.canvas.domain();
        let mut list = Shortlist::new(self.scale * NOTHING);
        let fresh = |patch: &Patch<D>| self.canvas.offered(patch, at).is_some() && !self.history.is_used(patch, output);
        candidates.into_iter().for_each(|c| list.offer(c, || fresh(&c.patch)));
        list.finish()
    }

    /// Patches that show a random sample at a position. Masked samples and those used before are left out afterwards.
    fn random(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        let samples = self.canvas.exemplars.table().len();
        let mut rng = self.run.seed.derive("graphcut/random", self.step).rng();
        (0..RANDOM).filter_map(|_| self.showing(SampleId::new(rng.below(samples)), at)).collect()
    }

    /// Every patch that shows anything at a position.
    fn everything(&self, at: [i32; D]) -> Vec<Candidate<D>> {
        let samples = self.canvas.exemplars.table().len();
        (0..samples).filter_map(|id| self.showing(SampleId::new(id), at)).collect()
    }

    /// The patch that shows a sample at a position.
    fn showing(&self, id: SampleId, at: [i32; D]) -> Option<Candidate<D>> {
        let (source, from) = self.canvas.exemplars.locate(id)?;
        let offset = std::array::from_fn(|a| at[a] - from[a] as i32);
        Some(Candidate { patch: Patch { source, offset }, cost: 0.0 })
    }
}
