//! The image quilting algorithm. `[Efros01 2.2]`

use selvedge_core::{Domain, Event, Exemplars, Run, SampleId, SourceMap, Woven};

use crate::block_grid::{Block, blocks};
use crate::boundary_cut::{Overlaps, boundary_cut};
use crate::options::{Continuation, Error, Options, Stage};
use crate::search::{Candidate, Template, ValidBlocks, within};
use crate::suggest_block;

/// Counts of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Side of the blocks that was used.
    pub block: u32,
    /// Overlap that was used.
    pub overlap: u32,
    /// Blocks laid.
    pub blocks: u64,
    /// Candidates that were drawn from, over all blocks.
    pub candidates: u64,
    /// Sum of the chosen blocks' overlap errors, in squared feature units.
    pub overlap_error: u64,
    /// Sum of the errors along all cuts, in squared feature units.
    pub cut_error: u64,
}

/// Quilts an output from blocks of the exemplars, in raster order. `[Efros01 2.2]`
///
/// Each block is drawn from all those of all sources whose overlap error is within the tolerance of the least, then
/// cut along the path of least error against what is there. Periodic axes of `output` close without a seam of their own.
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars without a valid block, an empty output, or
/// no memory for the map.
///
/// # Complexity
/// Time `O(output samples / step^2 * candidates * overlap samples * channels)`, space `O(output + exemplars)`.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Block number `i` draws from `"quilting/block"`, `i`.
pub fn quilt(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    options.validate()?;
    if output.is_empty() {
        return Err(Error::EmptyOutput { width: output.shape[1], height: output.shape[0] });
    }
    let block = options.block.unwrap_or_else(|| suggest_block(exemplars));
    check_fit(exemplars, block)?;
    let overlap = if options.stage == Stage::Random { 0 } else { options.overlap_of(block)? };
    let mut quilter = Quilter {
        exemplars,
        options,
        run,
        valid: ValidBlocks::new(exemplars),
        map: SourceMap::unassigned(exemplars, output)?,
        laid: Vec::new(),
        stats: Stats { block, overlap, ..Stats::default() },
    };
    let blocks = blocks(output, block, overlap);
    for (i, block) in blocks.iter().enumerate() {
        if run.observer.cancelled() {
            return Ok(Woven { result: quilter.map, stats: quilter.stats, complete: false });
        }
        quilter.lay(i, block)?;
        let so_far = Event { so_far: Some(&quilter.map), ..Event::step("quilting", i as u64 + 1, blocks.len() as u64) };
        run.observer.event(&so_far);
    }
    Ok(Woven { result: quilter.map, stats: quilter.stats, complete: true })
}

/// At least one source holds a block.
fn check_fit(exemplars: &Exemplars<2>, block: u32) -> Result<(), Error> {
    let shapes = exemplars.sources().iter().map(|s| s.domain().shape);
    let [height, width] = shapes.max_by_key(|s| s[0].min(s[1])).unwrap_or([0, 0]);
    let limit = height.min(width);
    if limit < block { Err(Error::BlockExceedsExemplar { block, width, height, limit }) } else { Ok(()) }
}

struct Quilter<'a> {
    exemplars: &'a Exemplars<2>,
    options: &'a Options,
    run: &'a Run<'a, 2>,
    valid: ValidBlocks,
    map: SourceMap<2>,
    /// Blocks laid so far, with what was laid.
    laid: Vec<(Block, Candidate)>,
    stats: Stats,
}

impl Quilter<'_> {
    fn lay(&mut self, number: usize, block: &Block) -> Result<(), Error> {
        let template = self.template(block);
        let chosen = self.choose(number, block, &template)?;
        let new = match self.options.stage {
            Stage::Random | Stage::Overlap => vec![true; template.mask.len()],
            Stage::Cut => self.cut(block, &template, chosen),
        };
        let output = self.map.domain();
        for (at, _) in Domain::open(block.shape()).positions().zip(new).filter(|(_, new)| *new) {
            let from = [chosen.at[0] + at[0], chosen.at[1] + at[1]];
            self.map.ids.set(0, block.position(output, at), self.exemplars.table().id(chosen.source, from));
        }
        self.stats.blocks += 1;
        self.stats.overlap_error += chosen.error;
        self.laid.push((*block, chosen));
        Ok(())
    }

    /// The output's features under a block.
    fn template(&self, block: &Block) -> Template {
        let (shape, output) = (block.shape(), self.map.domain());
        let ids: Vec<SampleId> =
            Domain::open(shape).positions().map(|at| self.map.ids.get(0, block.position(output, at))).collect();
        let feature = |c: usize, id: SampleId| match self.exemplars.locate(id) {
            Some((s, at)) => self.exemplars.sources()[s].features.get(c, at),
            None => 0,
        };
        let features = (0..self.exemplars.channels()).map(|c| ids.iter().map(|&id| feature(c, id)).collect()).collect();
        Template { shape, features, mask: ids.iter().map(|id| id.is_assigned()).collect() }
    }

    /// A uniform draw from the candidates within the tolerance.
    fn choose(&mut self, number: usize, block: &Block, template: &Template) -> Result<Candidate, Error> {
        let template = match self.options.stage {
            Stage::Random => &Template { mask: vec![false; template.mask.len()], ..template.clone() },
            Stage::Overlap | Stage::Cut => template,
        };
        let continued = self.continuations(number, block);
        let avoid = |source: usize, at: [u32; 2]| continued.iter().any(|&(s, p)| s == source && near(at, p));
        let candidates = within(self.exemplars, &self.valid, template, self.options.per_mille(), avoid);
        let [height, width] = template.shape;
        if candidates.is_empty() {
            return Err(Error::Masked { height, width });
        }
        self.stats.candidates += candidates.len() as u64;
        let mut rng = self.run.seed.derive("quilting/block", number as u64).rng();
        Ok(candidates[rng.below(candidates.len() as u32) as usize])
    }

    /// Where the blocks next to this one would go on in their sources.
    fn continuations(&self, number: usize, block: &Block) -> Vec<(usize, [i64; 2])> {
        if self.options.stage == Stage::Random || self.options.continuation == Continuation::Allow {
            return Vec::new();
        }
        let output = self.map.domain();
        let gap = |axis: usize, from: u32, to: u32| {
            let (d, side) = (i64::from(to) - i64::from(from), i64::from(output.shape[axis]));
            if output.periodic[axis] { (d + side / 2).rem_euclid(side) - side / 2 } else { d }
        };
        self.laid[..number]
            .iter()
            .filter_map(|(old, laid)| {
                let (dy, dx) =
                    (gap(0, old.rows.start, block.rows.start), gap(1, old.columns.start, block.columns.start));
                let reach = |old: u32, new: u32, d: i64| -i64::from(new) < d && d < i64::from(old);
                let touches = reach(old.rows.len, block.rows.len, dy) && reach(old.columns.len, block.columns.len, dx);
                touches.then(|| (laid.source, [i64::from(laid.at[0]) + dy, i64::from(laid.at[1]) + dx]))
            })
            .collect()
    }

    /// Where the chosen block shows. `[Efros01 2.1]`
    fn cut(&mut self, block: &Block, template: &Template, chosen: Candidate) -> Vec<bool> {
        let [h, w] = template.shape.map(|v| v as usize);
        let features = &self.exemplars.sources()[chosen.source].features;
        let mut error = vec![0_u64; h * w];
        for (c, &weight) in self.exemplars.weights().iter().enumerate() {
            for (i, e) in error.iter_mut().enumerate().filter(|(i, _)| template.mask[*i]) {
                let new = features.get(c, [chosen.at[0] + (i / w) as u32, chosen.at[1] + (i % w) as u32]);
                *e += u64::from(new.abs_diff(template.features[c][i])).pow(2) * u64::from(weight);
            }
        }
        let overlaps = Overlaps {
            left: block.columns.before as usize,
            top: block.rows.before as usize,
            right: block.columns.after as usize,
            bottom: block.rows.after as usize,
        };
        let cut = boundary_cut([h, w], overlaps, &error);
        self.stats.cut_error += cut.cost;
        cut.new
    }
}

/// Within two samples on both axes.
fn near(at: [u32; 2], to: [i64; 2]) -> bool {
    at.iter().zip(to).all(|(&a, b)| (i64::from(a) - b).abs() <= 2)
}
