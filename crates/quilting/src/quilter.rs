//! One pass of blocks over the output, in raster order. `[Efros01 2.2]`

use selvedge_core::{Domain, Event, Exemplars, Run, Seed, SourceMap, try_vec};

use crate::block_grid::{Block, BlockGrid};
use crate::boundary_cut::{Overlaps, boundary_cut};
use crate::free::FreePlaces;
use crate::options::{Continuation, Error, Stage};
use crate::search::{Candidate, Search, Space, Template, Term};
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
pub(crate) struct Quilter<'a, S> {
    search: &'a mut S,
    pass: Pass<'a>,
    run: &'a Run<'a, 2>,
    map: &'a mut SourceMap<2>,
    /// What was laid at each block so far.
    laid: Vec<Candidate>,
    /// How often the parts of the exemplars were laid.
    usage: Usage,
    /// For blocks that agree with nothing.
    free: FreePlaces<'a>,
    /// The output under the block that is being laid, where blocks of this pass lie.
    overlap: Template,
    pub(crate) counts: Counts,
}

impl<'a, S: Search> Quilter<'a, S> {
    pub(crate) fn new(
        search: &'a mut S,
        pass: Pass<'a>,
        run: &'a Run<'a, 2>,
        map: &'a mut SourceMap<2>,
    ) -> Result<Self, Error> {
        let usage = Usage::new(pass.exemplars, pass.block, pass.spread)?;
        let (free, overlap) = (FreePlaces::new(pass.exemplars), Template::for_blocks(pass.block, pass.exemplars)?);
        let mut laid = Vec::new();
        reserve(&mut laid, pass.grid.len())?;
        Ok(Self { search, pass, run, map, laid, overlap, counts: Counts::default(), usage, free })
    }

    /// False if the run was cancelled.
    pub(crate) fn lay_all(&mut self) -> Result<bool, Error> {
        let Progress { name, before, of } = self.pass.progress;
        for number in 0..self.pass.grid.len() {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            self.lay(number)?;
            let step = Event::step(name, before + number as u64 + 1, of);
            self.run.observer.event(&Event { so_far: Some(&*self.map), ..step });
        }
        Ok(true)
    }

    fn lay(&mut self, number: usize) -> Result<(), Error> {
        let block = self.pass.grid.block(number);
        // Random blocks agree with nothing.
        let compared = |p| self.pass.stage != Stage::Random && block.is_overlap(p);
        self.overlap.read(self.pass.exemplars, self.map, &block, compared)?;
        let chosen = self.choose(number, &block)?;
        match self.pass.stage {
            Stage::Random | Stage::Overlap => self.paste(&block, chosen, |_| true),
            Stage::Cut => {
                let new = self.cut(&block, chosen)?;
                self.paste(&block, chosen, |i| new[i]);
            }
        }
        self.counts.blocks += 1;
        self.counts.error = self.counts.error.saturating_add(chosen.error);
        self.laid.push(chosen);
        Ok(())
    }

    /// A uniform draw from the candidates within the tolerance.
    fn choose(&mut self, number: usize, block: &Block) -> Result<Candidate, Error> {
        let continued = self.continuations(number, block);
        let mut rng = self.pass.seed.derive("quilting/block", number as u64).rng();
        let [height, width] = block.shape();
        let masked = Error::Masked { height, width };
        if self.pass.steering.is_none() && self.usage.is_even() && !self.overlap.mask.contains(&true) {
            let drawn = self.free.draw(block.shape(), continued.iter().flat_map(around), &mut rng)?;
            let (chosen, candidates) = drawn.ok_or(masked)?;
            self.usage.note(&chosen);
            self.counts.candidates += u64::from(candidates);
            return Ok(chosen);
        }
        let avoid = |source: usize, at: [u32; 2]| continued.iter().any(|&(s, p)| s == source && near(at, p));
        let agree = [Term { space: Space::Texture, template: &self.overlap, weight: 1 }];
        let steering = self.pass.steering.as_mut();
        let terms = steering.map(|s| s.terms(self.pass.exemplars, block, &self.overlap)).transpose()?;
        let terms = terms.as_deref().unwrap_or(&agree);
        let per_mille = self.pass.per_mille;
        let usage = &self.usage;
        let near = self.search.near(terms, &|best| usage.widened(per_mille, best), &avoid)?;
        let (chosen, candidates) = self.usage.draw(near, per_mille, &mut rng)?.ok_or(masked)?;
        self.counts.candidates += u64::from(candidates);
        Ok(chosen)
    }

    /// Where the blocks next to this one would go on in their sources.
    fn continuations(&self, number: usize, block: &Block) -> Vec<(usize, [i64; 2])> {
        if self.pass.stage == Stage::Random || self.pass.continuation == Continuation::Allow {
            return Vec::new();
        }
        let output = self.map.domain();
        let go_on = |neighbor: usize| {
            let laid = self.laid[neighbor];
            let [dy, dx] = self.pass.grid.block(neighbor).way_to(output, block);
            (laid.source, [i64::from(laid.at[0]) + dy, i64::from(laid.at[1]) + dx])
        };
        self.pass.grid.neighbors(number).map(go_on).collect()
    }

    /// Where the chosen block shows. `[Efros01 2.1]`
    fn cut(&mut self, block: &Block, chosen: Candidate) -> Result<Vec<bool>, Error> {
        let template = &self.overlap;
        let [h, w] = template.shape.map(|v| v as usize);
        let features = &self.pass.exemplars.sources()[chosen.source].features;
        let stride = features.domain().shape[1] as usize;
        let corner = features.domain().index(chosen.at);
        let mut error = try_vec(h * w, 0_u64)?;
        for (c, &weight) in self.pass.exemplars.weights().iter().enumerate() {
            let (old, new) = (&template.features[c * h * w..][..h * w], features.plane(c));
            for (i, e) in error.iter_mut().enumerate().filter(|(i, _)| template.mask[*i]) {
                let d = new[corner + i / w * stride + i % w].abs_diff(old[i]);
                *e += u64::from(u32::from(d) * u32::from(d)) * u64::from(weight);
            }
        }
        let overlaps = Overlaps {
            left: block.columns.before as usize,
            top: block.rows.before as usize,
            right: block.columns.after as usize,
            bottom: block.rows.after as usize,
        };
        let cut = boundary_cut([h, w], overlaps, &error)?;
        self.counts.cut_error = self.counts.cut_error.saturating_add(cut.cost);
        Ok(cut.new)
    }

    /// Writes the samples of the chosen block for which `new` is true.
    fn paste(&mut self, block: &Block, chosen: Candidate, new: impl Fn(usize) -> bool) {
        let (output, table) = (self.map.domain(), self.pass.exemplars.table());
        for (_, at) in Domain::open(block.shape()).positions().enumerate().filter(|(i, _)| new(*i)) {
            let from = [chosen.at[0] + at[0], chosen.at[1] + at[1]];
            self.map.ids.set(0, block.position(output, at), table.id(chosen.source, from));
        }
    }
}

impl Template {
    /// One that takes no more memory for blocks up to this side.
    fn for_blocks(side: u32, exemplars: &Exemplars<2>) -> Result<Self, Error> {
        let samples = side as usize * side as usize;
        let mut template = Self { shape: [0; 2], mask: Vec::new(), features: Vec::new() };
        reserve(&mut template.mask, samples)?;
        reserve(&mut template.features, samples * exemplars.channels())?;
        Ok(template)
    }

    /// Takes the features of a map's samples under a block where they are compared.
    pub(crate) fn read(
        &mut self,
        exemplars: &Exemplars<2>,
        map: &SourceMap<2>,
        block: &Block,
        compared: impl Fn([u32; 2]) -> bool,
    ) -> Result<(), Error> {
        let (output, table) = (map.domain(), exemplars.table());
        self.shape = block.shape();
        let n = (self.shape[0] * self.shape[1]) as usize;
        self.clear(n, exemplars.channels())?;
        self.features.resize(n * exemplars.channels(), 0);
        for (i, p) in Domain::open(self.shape).positions().enumerate() {
            let id = map.ids.get(0, block.position(output, p));
            let source = Some(id).filter(|_| compared(p)).and_then(|id| table.source(id));
            self.mask.push(source.is_some());
            if let Some(source) = source {
                let from = (id.get() - table.first(source)) as usize;
                let features = &exemplars.sources()[source].features;
                for c in 0..features.channels() {
                    self.features[c * n + i] = features.plane(c)[from];
                }
            }
        }
        Ok(())
    }

    /// Empties the buffers and makes room for so many samples and channels.
    pub(crate) fn clear(&mut self, samples: usize, channels: usize) -> Result<(), Error> {
        self.mask.clear();
        self.features.clear();
        reserve(&mut self.mask, samples)?;
        reserve(&mut self.features, samples * channels)
    }

    /// Compared samples.
    pub(crate) fn samples(&self) -> u64 {
        self.mask.iter().filter(|&&on| on).count() as u64
    }
}

/// Makes room for that many items more.
pub(crate) fn reserve<T>(items: &mut Vec<T>, more: usize) -> Result<(), Error> {
    let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
    items.try_reserve(more).map_err(|_| selvedge_core::Error::Allocation { bytes }.into())
}

/// How far from a continuation a block is one itself, in samples on each axis.
const NEAR: i64 = 2;

fn near(at: [u32; 2], to: [i64; 2]) -> bool {
    at.iter().zip(to).all(|(&a, b)| (i64::from(a) - b).abs() <= NEAR)
}

/// All places near a continuation.
fn around(&(source, [y, x]): &(usize, [i64; 2])) -> impl Iterator<Item = (usize, [i64; 2])> {
    (y - NEAR..=y + NEAR).flat_map(move |y| (x - NEAR..=x + NEAR).map(move |x| (source, [y, x])))
}

#[cfg(test)]
mod tests;
