//! One pass of blocks over the output. `[Efros01 2.2]`
//!
//! Blocks that do not touch are looked for at once, wave by wave (see [`BlockGrid::waves`]), each by what was laid in
//! the waves before: on any number of threads the output is the same.

use selvedge_core::{Event, Exemplars, Rng, Run, SampleId, Seed, SourceMap, par, try_vec};

use crate::block_grid::{Block, BlockGrid};
use crate::finding::{Found, Worker, around, masked};
use crate::free::FreePlaces;
use crate::options::{Continuation, Error, Stage};
use crate::search::{Candidate, Search};
use crate::transfer::Steering;
use crate::usage::Usage;

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

/// What a pass is told.
pub(crate) struct Pass<'a> {
    pub(crate) exemplars: &'a Exemplars<2>,
    pub(crate) grid: BlockGrid,
    /// Side of the blocks.
    pub(crate) block: u32,
    /// See [`per_mille`](crate::options::per_mille).
    pub(crate) per_mille: u32,
    pub(crate) stage: Stage,
    pub(crate) continuation: Continuation,
    /// See [`Options::spread`](crate::Options::spread).
    pub(crate) spread: f64,
    /// What the blocks follow besides their neighbours.
    pub(crate) steering: Option<Steering<'a>>,
    pub(crate) seed: Seed,
    pub(crate) progress: Progress,
}

/// What the observer is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    pub(crate) name: &'static str,
    /// Blocks of the passes before.
    pub(crate) before: u64,
    /// Blocks of all passes.
    pub(crate) of: u64,
}

/// Lays the blocks of one pass into a map.
pub(crate) struct Quilter<'a, S: Search> {
    pub(crate) search: &'a S,
    pub(crate) pass: Pass<'a>,
    run: &'a Run<'a, 2>,
    pub(crate) map: &'a mut SourceMap<2>,
    /// What was laid at each block so far.
    pub(crate) laid: Vec<Option<Candidate>>,
    /// How often the parts of the exemplars were laid.
    pub(crate) usage: Usage,
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
        let usage = Usage::new(pass.exemplars, pass.block, pass.spread)?;
        let (free, laid) = (FreePlaces::new(pass.exemplars), try_vec(pass.grid.len(), None)?);
        let at_once = par::at_once(pass.exemplars.table().len().into()).min(par::threads() as u64);
        let workers = (0..at_once).map(|_| Worker::new(&pass)).collect::<Result<_, _>>()?;
        Ok(Self { search, pass, run, map, laid, usage, free, workers, counts: Counts::default() })
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
        let this = &*self;
        let cancelled = || this.run.observer.cancelled();
        let found = par::map_with(&mut workers, numbers.len(), |worker, i| {
            if cancelled() { Ok(None) } else { this.find(numbers[i], worker).map(Some) }
        });
        self.workers = workers;
        for found in found {
            let Some(found) = found?.filter(|_| !self.run.observer.cancelled()) else { return Ok(false) };
            self.lay(found)?;
            let Progress { name, before, of } = self.pass.progress;
            let step = Event::step(name, before + self.counts.blocks, of);
            self.run.observer.event(&Event { so_far: Some(&*self.map), ..step });
        }
        Ok(true)
    }

    /// Lays what was found.
    fn lay(&mut self, found: Found) -> Result<(), Error> {
        let block = self.pass.grid.block(found.number);
        let (chosen, candidates) = match found.chosen {
            Some(chosen) => chosen,
            None => self.draw(found.number, &block)?,
        };
        self.paste(&block, chosen, found.cut.as_ref().map(|cut| &cut.new[..]));
        self.counts.blocks += 1;
        self.counts.candidates += u64::from(candidates);
        self.counts.error = self.counts.error.saturating_add(chosen.error);
        let cut_error = found.cut.map_or(0, |cut| cut.cost);
        self.counts.cut_error = self.counts.cut_error.saturating_add(cut_error);
        self.usage.note(&chosen);
        self.laid[found.number] = Some(chosen);
        Ok(())
    }

    /// A uniform draw from all places, for a block that agrees with nothing.
    fn draw(&mut self, number: usize, block: &Block) -> Result<(Candidate, u32), Error> {
        let continued = self.continuations(number, block);
        let mut rng = self.rng(number);
        let drawn = self.free.draw(block.shape(), continued.iter().flat_map(around), &mut rng)?;
        drawn.ok_or(masked(block))
    }

    /// The random numbers of a block.
    pub(crate) fn rng(&self, number: usize) -> Rng {
        self.pass.seed.derive("quilting/block", number as u64).rng()
    }

    /// Where the blocks next to this one would go on in their sources.
    pub(crate) fn continuations(&self, number: usize, block: &Block) -> Vec<(usize, [i64; 2])> {
        if self.pass.stage == Stage::Random || self.pass.continuation == Continuation::Allow {
            return Vec::new();
        }
        let output = self.map.domain();
        let go_on = |neighbor: usize| {
            let laid = self.laid[neighbor]?;
            let [dy, dx] = self.pass.grid.block(neighbor).way_to(output, block);
            Some((laid.source, [i64::from(laid.at[0]) + dy, i64::from(laid.at[1]) + dx]))
        };
        self.pass.grid.neighbors(number).filter_map(go_on).collect()
    }

    /// Writes the samples of the chosen block for which `new` is true; all if there is no such list.
    fn paste(&mut self, block: &Block, chosen: Candidate, new: Option<&[bool]>) {
        let (output, table) = (self.map.domain(), self.pass.exemplars.table());
        let [height, width] = block.shape().map(|side| side as usize);
        // Blocks of a periodic output may reach over the end of a row.
        let inside = width.min((output.shape[1] - block.columns.start) as usize);
        let ids = self.map.ids.plane_mut(0);
        for y in 0..height {
            let first = table.id(chosen.source, [chosen.at[0] + y as u32, chosen.at[1]]).get();
            let row = new.map(|new| &new[y * width..][..width]);
            for columns in [0..inside, inside..width] {
                let to = output.index(block.position(output, [y as u32, columns.start as u32]));
                for (x, id) in columns.clone().zip(&mut ids[to..]) {
                    if row.is_none_or(|row| row[x]) {
                        *id = SampleId::new(first + x as u32);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
