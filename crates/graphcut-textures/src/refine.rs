//! Refinement: patches over the worst seams, taken where they make seams cheaper. `[Kwatra03 4, fig. 5]`
//!
//! Regions far enough apart to know nothing of each other are refined at once.

use selvedge_core::{Patch, Window, par};

use crate::canvas::Offer;
use crate::choice::Draw;
use crate::error::Error;
use crate::few::halved;
use crate::options::Options;
use crate::usable::Usable;
use crate::weaver::{BATCH, Weaver, Worker};

/// For each so many regions of the output, one more failure in a row is borne: of more regions more fail in a row by
/// chance, so that a fixed number ends large outputs early.
const REGIONS_A_FAILURE: u64 = 32;

/// What was tried over a region.
struct Attempt<const D: usize> {
    drawn: Draw<D>,
    /// Cuts made, and their nodes.
    nodes: Vec<usize>,
    /// The patch that makes seams cheapest.
    best: Option<(Patch<D>, Offer<D>)>,
}

impl<const D: usize> Weaver<'_, D> {
    /// Lays patches over the worst seams. False if it was cancelled.
    ///
    /// # Errors
    /// [`Error::Search`], [`Error::Cut`].
    pub(crate) fn refine(&mut self, keep: &mut dyn FnMut(&Self)) -> Result<bool, Error> {
        // Of more regions, more fail in a row by chance.
        let patience = u64::from(self.options.patience) + self.canvas.cells.regions() / REGIONS_A_FAILURE;
        // Patches that fill gaps of others are no measure of what can become better.
        let whole = self.matcher.holds(self.region, Usable::all());
        let laid = if whole { self.stats.patches } else { self.stats.patches.min(self.usual) };
        let most = laid.max(4) * Options::<D>::REFINEMENTS_A_PATCH;
        let limit = self.options.refine.map_or(most, u64::from);
        self.tell("refine", self.stats.refinements, limit);
        while self.stats.refinements < limit && self.failures < patience {
            keep(self);
            let left = (limit - self.stats.refinements).min(BATCH as u64) as usize;
            let cells = self.worst(left);
            if cells.is_empty() {
                break;
            }
            let step = self.step;
            let all = self.try_all(&cells);
            // Of regions that were chosen together none is taken, so that a run may go on from before them.
            if all.iter().any(|tried| tried.as_ref().map_or_else(Error::is_cancelled, Option::is_none)) {
                self.step = step;
                keep(self);
                return Ok(false);
            }
            for (cell, tried) in cells.iter().zip(all) {
                let Some(tried) = tried? else { return Ok(false) };
                self.stats.refinements += 1;
                self.failures = if self.settle(*cell, tried) { 0 } else { self.failures + 1 };
                self.stats.energy.push(self.canvas.energy());
                self.tell("refine", self.stats.refinements, limit);
            }
        }
        Ok(true)
    }

    /// Takes what was tried over a region, or leaves the region out for now; says whether seams became cheaper.
    fn settle(&mut self, cell: usize, tried: Attempt<D>) -> bool {
        let region = self.canvas.cells.region(cell, self.region);
        match self.take(&region, tried) {
            Some(window) => {
                self.stats.improvements += 1;
                self.canvas.cells.readmit(&window, self.region);
                true
            }
            None => {
                self.canvas.cells.leave_out(cell);
                false
            }
        }
    }

    /// The worst regions whose patches do not meet, by their cells.
    fn worst(&mut self, count: usize) -> Vec<usize> {
        let (shape, output) = (self.region, self.canvas.domain());
        let model = self.near(&Window { start: [0; D], shape });
        let near = |region: &Window<D>| Window {
            start: std::array::from_fn(|a| region.start[a] + model.start[a]),
            shape: model.shape,
        };
        let mut cells = Vec::new();
        while cells.len() < count {
            let Some(cell) = self.canvas.cells.worst() else { break };
            cells.push(cell);
            // Nor may a seam at the border of one touch the other.
            let around = near(&self.canvas.cells.region(cell, shape)).grown(output, [1; D], [1; D]);
            self.canvas.cells.hide(&around, shape, near);
        }
        self.canvas.cells.show();
        cells
    }

    /// Tries patches over some regions that know nothing of each other; `None` where that was cancelled.
    fn try_all(&mut self, cells: &[usize]) -> Vec<Result<Option<Attempt<D>>, Error>> {
        let mut workers = std::mem::take(&mut self.workers);
        let this = &*self;
        let tried = par::map_with(&mut workers, cells.len(), |worker, i| {
            if this.run.observer.cancelled() {
                return Ok(None);
            }
            let region = this.canvas.cells.region(cells[i], this.region);
            this.attempt(&region, this.step + i as u64, worker).map(Some)
        });
        self.workers = workers;
        self.step += cells.len() as u64;
        tried
    }

    /// Draws patches over a region, cuts each, and keeps the best.
    fn attempt(&self, region: &Window<D>, step: u64, worker: &mut Worker<D>) -> Result<Attempt<D>, Error> {
        let middle = std::array::from_fn(|a| region.start[a] + region.shape[a] as i32 / 2);
        let mut region = *region;
        let drawn = loop {
            let drawn = self.choose(&region, middle, self.options.tries as usize, step, &mut worker.matches)?;
            if !drawn.patches.is_empty() || region.shape == [1; D] {
                break drawn;
            }
            // No source that may show here is as large.
            let shape = halved(region.shape);
            region = Window { start: std::array::from_fn(|a| middle[a] - shape[a] as i32 / 2), shape };
        };
        let cancelled = || self.run.observer.cancelled();
        let (mut nodes, mut best) = (Vec::new(), None::<(Patch<D>, Offer<D>)>);
        for patch in &drawn.patches {
            let window = self.window(patch, &region);
            let offer = self.canvas.offer(patch, &window, &mut worker.cut, &cancelled)?;
            nodes.push(offer.proposal.free);
            if best.as_ref().is_none_or(|(_, best)| best.gain() < offer.gain()) {
                best = Some((*patch, offer));
            }
        }
        Ok(Attempt { drawn, nodes, best })
    }

    /// Takes what was tried over a region if seams become cheaper; answers with the window that changed.
    fn take(&mut self, region: &Window<D>, tried: Attempt<D>) -> Option<Window<D>> {
        self.note_drawn(&tried.drawn);
        tried.nodes.iter().for_each(|&nodes| self.count(nodes));
        let (patch, offer) = tried.best?;
        let neighbours = self.canvas.map.patches(region);
        if !self.canvas.improve(&offer) {
            return None;
        }
        self.history.note_vectors(&patch, &neighbours);
        Some(offer.frame.window)
    }
}

#[cfg(test)]
mod tests;
