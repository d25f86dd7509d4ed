//! One pass of blocks over the output. `[Efros01 2.2]`
//!
//! Blocks that do not touch are looked for at once, wave by wave (see [`BlockGrid::waves`]), each by what was laid in
//! the waves before: on any number of threads the output is the same.

use selvedge_core::{Event, Run, SourceMap, par};

use crate::block_grid::Block;
use crate::cloth::Cloth;
use crate::finding::{Find, Finder, Worker, masked, rng};
use crate::free::FreePlaces;
use crate::options::Error;
use crate::pass::{Pass, Progress};
use crate::search::{Candidate, Search, Successor};

/// Counts of one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) blocks: u64,
    /// Candidates that were drawn from, over all blocks.
    pub(crate) candidates: u64,
    /// Sum of the chosen blocks' errors.
    pub(crate) error: u64,
    /// Sum of the errors along all cuts, in squared feature units.
    pub(crate) cut_error: u64,
}

/// Lays the blocks of one pass into a map.
pub(crate) struct Quilter<'a, S: Search> {
    pub(crate) search: &'a S,
    pub(crate) pass: Pass<'a>,
    run: &'a Run<'a, 2>,
    pub(crate) cloth: Cloth<'a>,
    /// For blocks that agree with nothing.
    free: FreePlaces<'a>,
    /// Working memory of the blocks that are looked for at once.
    workers: Vec<Worker<S>>,
    pub(crate) counts: Counts,
}

impl<'a, S: Search> Quilter<'a, S> {
    pub(crate) fn new(
        search: &'a S,
        pass: Pass<'a>,
        run: &'a Run<'a, 2>,
        map: &'a mut SourceMap<2>,
    ) -> Result<Self, Error> {
        let (free, cloth) = (FreePlaces::new(pass.exemplars), Cloth::new(&pass, map)?);
        let at_once = par::at_once(search.places()).min(par::threads() as u64);
        let workers = (0..at_once).map(|_| Worker::default()).collect();
        Ok(Self { search, pass, run, cloth, free, workers, counts: Counts::default() })
    }

    /// False if the run was cancelled.
    pub(crate) fn lay_all(&mut self) -> Result<bool, Error> {
        for wave in 0..self.pass.grid.waves() {
            if !self.lay_wave(wave)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Looks for all blocks of a wave at once, then lays one after the other.
    fn lay_wave(&mut self, wave: usize) -> Result<bool, Error> {
        let numbers: Vec<usize> = self.pass.grid.wave(wave).collect();
        let mut workers = std::mem::take(&mut self.workers);
        let (finder, observer) = (self.finder(), self.run.observer);
        let found = par::map_with(&mut workers, numbers.len(), |worker, i| {
            if observer.cancelled() { Ok(None) } else { finder.find(numbers[i], worker).map(Some) }
        });
        self.workers = workers;
        for found in found {
            let Some(found) = found?.filter(|_| !observer.cancelled()) else { return Ok(false) };
            self.lay(found)?;
            let Progress { name, before, of } = self.pass.progress;
            let step = Event::step(name, before + self.counts.blocks, of);
            observer.event(&Event { so_far: Some(&*self.cloth.map), ..step });
        }
        Ok(true)
    }

    /// Lays what was found.
    fn lay(&mut self, found: Find) -> Result<(), Error> {
        let block = self.pass.grid.block(found.number);
        let (chosen, candidates) = match found.chosen {
            Some(chosen) => chosen,
            None => self.draw(found.number, &block)?,
        };
        self.cloth.lay(found.number, &block, chosen, found.cut.as_ref().map(|cut| &cut.new[..]));
        self.counts.blocks += 1;
        self.counts.candidates += u64::from(candidates);
        self.counts.error = self.counts.error.saturating_add(chosen.error);
        let cut_error = found.cut.map_or(0, |cut| cut.cost);
        self.counts.cut_error = self.counts.cut_error.saturating_add(cut_error);
        Ok(())
    }

    /// A uniform draw from all places, for a block that agrees with nothing.
    fn draw(&mut self, number: usize, block: &Block) -> Result<(Candidate, u32), Error> {
        let continued = self.cloth.continuations(&self.pass, number, block);
        let avoided = continued.iter().flat_map(Successor::around);
        let drawn = self.free.draw(block.shape(), avoided, &mut rng(&self.pass, number))?;
        drawn.ok_or_else(|| masked(block))
    }

    /// Who finds blocks by what is laid now.
    fn finder(&self) -> Finder<'_, 'a, S> {
        Finder { search: self.search, pass: &self.pass, cloth: &self.cloth }
    }
}

#[cfg(test)]
mod tests;
