//! The image quilting algorithm. `[Efros01 2.2]`

use selvedge_core::{Domain, Event, Exemplars, Run, SourceMap, Woven};

use crate::block_grid::{Block, BlockGrid};
use crate::boundary_cut::{Overlaps, boundary_cut};
use crate::options::{Continuation, Error, Options, Stage};
use crate::search::{Candidate, FastSearch, Search, Template};
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
    quilt_by(FastSearch::new(exemplars, run.simd)?, exemplars, output, options, run)
}

/// The same by any search.
fn quilt_by(
    search: impl Search,
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    if output.is_empty() {
        return Err(Error::EmptyOutput { width: output.shape[1], height: output.shape[0] });
    }
    let block = options.block.unwrap_or_else(|| suggest_block(exemplars));
    check_fit(exemplars, block)?;
    let overlap = if options.stage == Stage::Random { 0 } else { options.overlap_of(block)? };
    let map = SourceMap::unassigned(exemplars, output)?;
    let grid = BlockGrid::new(output, block, overlap);
    let stats = Stats { block, overlap, ..Stats::default() };
    let mut quilter =
        Quilter { search, exemplars, options, run, grid, map, laid: Vec::new(), template: Template::default(), stats };
    let complete = quilter.lay_all()?;
    Ok(Woven { result: quilter.map, stats: quilter.stats, complete })
}

/// At least one source holds a block.
fn check_fit(exemplars: &Exemplars<2>, block: u32) -> Result<(), Error> {
    let shapes = exemplars.sources().iter().map(|s| s.domain().shape);
    let [height, width] = shapes.max_by_key(|s| s[0].min(s[1])).unwrap_or([0, 0]);
    let limit = height.min(width);
    if limit < block { Err(Error::BlockExceedsExemplar { block, width, height, limit }) } else { Ok(()) }
}

struct Quilter<'a, S> {
    search: S,
    exemplars: &'a Exemplars<2>,
    options: &'a Options,
    run: &'a Run<'a, 2>,
    grid: BlockGrid,
    map: SourceMap<2>,
    /// What was laid at each block so far.
    laid: Vec<Candidate>,
    /// The output under the block that is being laid.
    template: Template,
    stats: Stats,
}

impl<S: Search> Quilter<'_, S> {
    /// False if the run was cancelled.
    fn lay_all(&mut self) -> Result<bool, Error> {
        let blocks = self.grid.len();
        for number in 0..blocks {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            self.lay(number)?;
            let step = Event::step("quilting", number as u64 + 1, blocks as u64);
            self.run.observer.event(&Event { so_far: Some(&self.map), ..step });
        }
        Ok(true)
    }

    fn lay(&mut self, number: usize) -> Result<(), Error> {
        let block = self.grid.block(number);
        self.read_template(&block);
        let chosen = self.choose(number, &block)?;
        match self.options.stage {
            Stage::Random | Stage::Overlap => self.paste(&block, chosen, |_| true),
            Stage::Cut => {
                let new = self.cut(&block, chosen);
                self.paste(&block, chosen, |i| new[i]);
            }
        }
        self.stats.blocks += 1;
        self.stats.overlap_error += chosen.error;
        self.laid.push(chosen);
        Ok(())
    }

    /// Takes the output's features under a block.
    fn read_template(&mut self, block: &Block) {
        let (output, template) = (self.map.domain(), &mut self.template);
        template.shape = block.shape();
        let n = (template.shape[0] * template.shape[1]) as usize;
        template.mask.clear();
        template.features.clear();
        template.features.resize(n * self.exemplars.channels(), 0);
        for (i, at) in Domain::open(template.shape).positions().enumerate() {
            let id = self.map.ids.get(0, block.position(output, at));
            // Random blocks agree with nothing.
            let source = self.exemplars.table().source(id).filter(|_| self.options.stage != Stage::Random);
            template.mask.push(source.is_some());
            if let Some(source) = source {
                let from = (id.get() - self.exemplars.table().first(source)) as usize;
                let features = &self.exemplars.sources()[source].features;
                for c in 0..features.channels() {
                    template.features[c * n + i] = features.plane(c)[from];
                }
            }
        }
    }

    /// A uniform draw from the candidates within the tolerance.
    fn choose(&mut self, number: usize, block: &Block) -> Result<Candidate, Error> {
        let continued = self.continuations(number, block);
        let avoid = |source: usize, at: [u32; 2]| continued.iter().any(|&(s, p)| s == source && near(at, p));
        let mut rng = self.run.seed.derive("quilting/block", number as u64).rng();
        let drawn = self.search.draw(&self.template, self.options.per_mille(), &avoid, &mut |len| rng.below(len))?;
        let [height, width] = block.shape();
        let (chosen, candidates) = drawn.ok_or(Error::Masked { height, width })?;
        self.stats.candidates += u64::from(candidates);
        Ok(chosen)
    }

    /// Where the blocks next to this one would go on in their sources.
    fn continuations(&self, number: usize, block: &Block) -> Vec<(usize, [i64; 2])> {
        if self.options.stage == Stage::Random || self.options.continuation == Continuation::Allow {
            return Vec::new();
        }
        let output = self.map.domain();
        let go_on = |neighbor: usize| {
            let laid = self.laid[neighbor];
            let [dy, dx] = self.grid.block(neighbor).way_to(output, block);
            (laid.source, [i64::from(laid.at[0]) + dy, i64::from(laid.at[1]) + dx])
        };
        self.grid.neighbors(number).map(go_on).collect()
    }

    /// Where the chosen block shows. `[Efros01 2.1]`
    fn cut(&mut self, block: &Block, chosen: Candidate) -> Vec<bool> {
        let template = &self.template;
        let [h, w] = template.shape.map(|v| v as usize);
        let features = &self.exemplars.sources()[chosen.source].features;
        let stride = features.domain().shape[1] as usize;
        let corner = features.domain().index(chosen.at);
        let mut error = vec![0_u64; h * w];
        for (c, &weight) in self.exemplars.weights().iter().enumerate() {
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
        let cut = boundary_cut([h, w], overlaps, &error);
        self.stats.cut_error += cut.cost;
        cut.new
    }

    /// Writes the samples of the chosen block for which `new` is true.
    fn paste(&mut self, block: &Block, chosen: Candidate, new: impl Fn(usize) -> bool) {
        let (output, table) = (self.map.domain(), self.exemplars.table());
        for (_, at) in Domain::open(block.shape()).positions().enumerate().filter(|(i, _)| new(*i)) {
            let from = [chosen.at[0] + at[0], chosen.at[1] + at[1]];
            self.map.ids.set(0, block.position(output, at), table.id(chosen.source, from));
        }
    }
}

/// Within two samples on both axes.
fn near(at: [u32; 2], to: [i64; 2]) -> bool {
    at.iter().zip(to).all(|(&a, b)| (i64::from(a) - b).abs() <= 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::plain::PlainSearch;
    use selvedge_core::{Grid, Plane, Role, Samples, Seed};

    /// Smooth noise of two channels: patches fit more or less everywhere.
    fn exemplar(seed: u64, shape: [u32; 2]) -> Plane<2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(seed).rng();
        let mut value = 128_i32;
        let samples = (0..domain.len() * 2).map(|_| {
            value = (value + rng.below(41) as i32 - 20).clamp(0, 255);
            value as u8
        });
        Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 2, samples.collect()).unwrap()))
    }

    #[test]
    fn the_plain_search_quilts_the_same_picture() {
        let (a, b) = (exemplar(1, [24, 31]), exemplar(2, [19, 17]));
        let exemplars = Exemplars::of(&[std::slice::from_ref(&a), std::slice::from_ref(&b)]).unwrap();
        for (case, periodic) in [[false, false], [false, true], [true, true]].into_iter().enumerate() {
            for continuation in [Continuation::Avoid, Continuation::Allow] {
                let options = Options { block: Some(11), overlap: Some(4), continuation, ..Options::default() };
                let (output, run) = (Domain { shape: [40, 37], periodic }, Run::seeded(case as u64));
                let fast = quilt(&exemplars, output, &options, &run).unwrap();
                let plain = quilt_by(PlainSearch(&exemplars), &exemplars, output, &options, &run).unwrap();
                assert_eq!(fast.stats, plain.stats);
                assert_eq!(fast.result, plain.result);
            }
        }
    }

    #[test]
    fn one_block_is_a_copy() {
        let plane = exemplar(3, [20, 20]);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let options = Options { block: Some(12), ..Options::default() };
        let map = quilt(&exemplars, Domain::open([12, 12]), &options, &Run::seeded(4)).unwrap().result;
        for axis in 0..2 {
            assert!(map.domain().positions().all(|at| !map.is_seam(at, axis)));
        }
    }

    #[test]
    fn no_block_goes_on_where_its_neighbor_left_off() {
        let plane = exemplar(5, [40, 40]);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let output = Domain::open([40, 80]);
        let options = Options { block: Some(10), ..Options::default() };
        let fraction = |options: &Options| {
            let map = quilt(&exemplars, output, options, &Run::seeded(6)).unwrap().result;
            // Blocks step by 9 (overlap 1): the middles of neighbors continue each other if no seam parted them.
            let pairs = (0..8_u32)
                .map(|i| map.table.step(map.ids.get(0, [5, 9 * i]), [0, 9]) == Some(map.ids.get(0, [5, 9 * i + 9])));
            pairs.filter(|&same| same).count()
        };
        assert_eq!(fraction(&options), 0);
        assert!(0 < fraction(&Options { block: Some(10), ..Options::paper() }));
    }
}
