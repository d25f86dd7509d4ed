//! Refinement: patches over the worst seams, taken where they make seams cheaper. `[Kwatra03 4, fig. 5]`

use std::sync::PoisonError;

use selvedge_core::par;

use crate::error::Error;
use crate::options::Options;
use crate::region::patches;
use crate::weaver::Weaver;
use crate::window::Window;

/// For each so many regions of the output, one more failure in a row is borne.
const REGIONS_A_FAILURE: u64 = 32;

impl<const D: usize> Weaver<'_, D> {
    /// Lays patches over the worst seams. False if it was cancelled.
    ///
    /// # Errors
    /// [`Error::Search`], [`Error::Cut`].
    pub(crate) fn refine(&mut self) -> Result<bool, Error> {
        let mut failures = 0;
        // Of more regions, more fail in a row by chance.
        let patience = u64::from(self.options.patience) + self.canvas.cells.regions() / REGIONS_A_FAILURE;
        let most = self.stats.patches.max(4) * Options::<D>::REFINEMENTS_A_PATCH;
        let limit = self.options.refine.map_or(most, u64::from);
        self.tell("refine", 0, limit);
        while self.stats.refinements < limit && failures < patience {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            let Some(cell) = self.canvas.cells.worst() else { break };
            let region = self.canvas.cells.region(cell, self.region);
            let improved = self.improve(&region)?;
            self.stats.refinements += 1;
            if let Some(window) = improved {
                self.stats.improvements += 1;
                failures = 0;
                self.canvas.cells.readmit(&window, self.region);
            } else {
                failures += 1;
                self.canvas.cells.leave_out(cell);
            }
            self.stats.energy.push(self.canvas.energy());
            self.tell("refine", self.stats.refinements, limit);
        }
        Ok(true)
    }

    /// Tries patches over a region and takes the best; answers with the window that changed, if seams became cheaper.
    fn improve(&mut self, region: &Window<D>) -> Result<Option<Window<D>>, Error> {
        let middle = std::array::from_fn(|a| region.start[a] + region.shape[a] as i32 / 2);
        let drawn = self.choose(region, middle, self.options.tries as usize)?;
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
