//! Image quilting: one pass of blocks that agree with their neighbours. `[Efros01 2.2]`

use selvedge_core::{Bytes, Domain, Exemplars, Run, SourceMap, Woven};

use crate::auto_block::suggest_block;
use crate::block_grid::BlockGrid;
use crate::estimate::{measuring, planned};
use crate::fit::{check_fit, check_places};
use crate::options::{Error, Options, SearchBy, Stage, per_mille};
use crate::pass::{Pass, Progress};
use crate::quilter::Quilter;
use crate::search::{BlockSearch, FromAbove, Reduced, Search, halvings};

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

/// What [`quilt`] will do: options checked against exemplars, output and limits, and what they leave open chosen.
///
/// ```
/// use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Run, Samples};
/// use selvedge_quilting::{Options, Plan};
/// # fn main() -> Result<(), selvedge_quilting::Error> {
/// let noise = (0..64 * 64_u32).map(|i| (i * i / 7) as u8).collect();
/// let plane = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(Domain::open([64, 64]), 1, noise)?));
/// let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
/// let options = Options { block: Some(18), ..Options::default() };
/// let plan = Plan::new(&exemplars, Domain::open([256, 256]), &options, &Run::seeded(0))?;
/// assert_eq!((plan.block(), plan.overlap(), plan.blocks()), (18, 4, 18 * 18));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Plan<'e> {
    exemplars: &'e Exemplars<2>,
    output: Domain<2>,
    options: Options,
    block: u32,
    overlap: u32,
}

impl<'e> Plan<'e> {
    /// Checks the options, then exemplars and output, then whether the run's limits allow for measuring; then chooses
    /// the block, if it is left open. Whether they allow for the work is checked when it begins.
    ///
    /// # Errors
    /// Those of [`quilt`].
    pub fn new(
        exemplars: &'e Exemplars<2>,
        output: Domain<2>,
        options: &Options,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        options.validate()?;
        check_fit(exemplars, output, options.block)?;
        run.limits.admit(output, measured(exemplars, options))?;
        let block = options.block.map_or_else(|| suggest_block(exemplars), Ok)?;
        check_fit(exemplars, output, Some(block))?;
        let overlap = if options.stage == Stage::Random { 0 } else { options.overlap_of(block)? };
        check_places(exemplars, &BlockGrid::new(output, block, overlap).block(0))?;
        Ok(Self { exemplars, output, options: *options, block, overlap })
    }

    /// Side of the blocks in samples.
    pub fn block(&self) -> u32 {
        self.block
    }

    /// Overlap of the blocks in samples; more where a periodic axis closes.
    pub fn overlap(&self) -> u32 {
        self.overlap
    }

    /// How many blocks will be laid.
    pub fn blocks(&self) -> u64 {
        self.grid().len() as u64
    }

    /// How often exemplars may be halved before blocks are looked for in them ([`SearchBy::Auto`]): 0 if they are
    /// small, have masks, or the overlap is narrow.
    pub fn halvings(&self) -> u32 {
        halvings(self.exemplars, self.overlap)
    }

    /// Bytes that choosing the block and the work take at most, beside the exemplars, on the threads of this pool.
    pub fn bytes(&self) -> Bytes {
        self.bytes_of(self.output)
    }

    /// The same with blocks of the same size for another output.
    pub fn bytes_of(&self, output: Domain<2>) -> Bytes {
        let halvings = if self.options.search == SearchBy::Auto { self.halvings() } else { 0 };
        let grid = BlockGrid::new(output, self.block, self.overlap);
        let work = planned(self.exemplars, output, &grid, halvings);
        measured(self.exemplars, &self.options).then(work)
    }

    /// Lays the blocks.
    ///
    /// # Errors
    /// What only the work can show: masks that leave no place for a cropped block, or no memory.
    pub fn weave(&self, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        run.limits.admit(self.output, self.bytes())?;
        if self.options.search == SearchBy::Auto {
            let reduced = Reduced::new(self.exemplars, self.overlap)?;
            if let Some(search) = FromAbove::new(self.exemplars, &reduced, None, run.simd)? {
                return self.weave_by(search, run);
            }
        }
        self.weave_by(BlockSearch::new(self.exemplars, None, run.simd)?, run)
    }

    /// The same by any search.
    fn weave_by(&self, search: impl Search, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        let mut map = SourceMap::unassigned(self.exemplars, self.output)?;
        let mut quilter = Quilter::new(&search, self.pass(run), run, &mut map)?;
        let complete = quilter.lay_all()?;
        let counts = quilter.counts;
        let stats = Stats {
            block: self.block,
            overlap: self.overlap,
            blocks: counts.blocks,
            candidates: counts.candidates,
            overlap_error: counts.error,
            cut_error: counts.cut_error,
        };
        Ok(Woven { result: map, stats, complete })
    }

    fn grid(&self) -> BlockGrid {
        BlockGrid::new(self.output, self.block, self.overlap)
    }

    /// What the only pass is told.
    pub(crate) fn pass(&self, run: &Run<'_, 2>) -> Pass<'e> {
        let grid = self.grid();
        Pass {
            exemplars: self.exemplars,
            block: self.block,
            per_mille: per_mille(self.options.tolerance),
            stage: self.options.stage,
            continuation: self.options.continuation,
            // Blocks that agree with nothing spread by themselves.
            spread: if self.overlap == 0 { 0.0 } else { self.options.spread },
            steering: None,
            seed: run.seed,
            progress: Progress { name: "quilting", before: 0, of: grid.len() as u64 },
            grid,
        }
    }
}

fn measured(exemplars: &Exemplars<2>, options: &Options) -> Bytes {
    measuring(&exemplars.domains(), exemplars.channels(), exemplars.is_masked(), options)
}

/// Quilts an output from blocks of the exemplars. `[Efros01 2.2]`
///
/// Each block is drawn from all those of all sources whose overlap error is within the tolerance of the least, then cut
/// along the path of least error against what is there.
///
/// Blocks are laid in waves: block `j` of row `i` is in wave `2 i + j`, and the blocks of a wave, which neither touch
/// nor follow from each other, are looked for at once. Where columns are periodic, each block is a wave. Every block
/// sees the neighbours that it would see in raster order.
///
/// With [`Options::spread`] above 0 an error counts more where the waves before used its place more often than others,
/// and the tolerance is one on what errors count. As these counts go from wave to wave, the output is then another one
/// than that of raster order; with 0 it is the same.
///
/// Periodic axes of `output` close without a seam of their own: at least two blocks go round them, shortened where that
/// many do not fit.
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars without a valid block, an empty output, one
/// over the run's limits (its plan's [bytes](Plan::bytes) count against their memory), or no memory for it.
///
/// From 384 samples a side of all exemplars on, without masks, and where the overlap is wide enough, blocks are looked
/// for at a fraction of the size and compared exactly around the best of what is found there, unless
/// [`SearchBy::Exact`] is asked for.
///
/// # Complexity
/// With `n` exemplar samples, `c` channels and `b = output samples / (block - overlap)^2` blocks: time `O(b * c * n)`
/// for searches of short overlaps or `O(b * c * n log n)` by Fourier transforms, whichever is less, of the smallest
/// size, and `O(b * block^2)` for cuts, but for the last ones of a periodic output, which take `O(overlap^4)` each.
/// Space `O(output + c * n)`.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Block number `i` draws from `"quilting/block"`, `i`.
pub fn quilt(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    Plan::new(exemplars, output, options, run)?.weave(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Continuation;
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
                let plan = Plan::new(&exemplars, output, &options, &run).unwrap();
                let plain = plan.weave_by(PlainSearch::new(&exemplars, None), &run).unwrap();
                assert_eq!((plan.block(), plan.overlap(), plan.blocks()), (11, 4, fast.stats.blocks));
                assert_eq!(fast.stats, plain.stats);
                assert_eq!(fast.result, plain.result);
            }
        }
    }

    /// Exemplars of the end-to-end suite.
    const SUITE: [(&str, &[u8]); 9] = [
        ("cobbles", include_bytes!("../../../fixtures/cobbles.png")),
        ("cobbles with a hole", include_bytes!("../../../fixtures/cobbles-hole.png")),
        ("weave", include_bytes!("../../../fixtures/weave.png")),
        ("scales", include_bytes!("../../../fixtures/scales.png")),
        ("stars", include_bytes!("../../../fixtures/stars.png")),
        ("grass", include_bytes!("../../../fixtures/grass-grey.png")),
        ("grey bricks", include_bytes!("../../../fixtures/brick-grey.png")),
        ("bricks", include_bytes!("../../../fixtures/bricks/albedo.png")),
        ("heights of bricks", include_bytes!("../../../fixtures/bricks/height.png")),
    ];

    #[test]
    fn the_plain_search_quilts_the_same_picture_from_every_exemplar_of_the_suite() {
        for (name, file) in SUITE {
            let plane = selvedge_testkit::from_png(Role::Color, file).unwrap();
            let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
            // Ls of 432 samples: multiplied with vectors, transformed without.
            let options = Options { block: Some(24), overlap: Some(12), ..Options::default() };
            let output = Domain { shape: [40, 36], periodic: [false, true] };
            let plan = Plan::new(&exemplars, output, &options, &Run::seeded(1)).unwrap();
            let plain = plan.weave_by(PlainSearch::new(&exemplars, None), &Run::seeded(1)).unwrap();
            for simd in [selvedge_core::SimdLevel::Scalar, selvedge_core::SimdLevel::Auto] {
                let fast = quilt(&exemplars, output, &options, &Run { simd, ..Run::seeded(1) }).unwrap();
                assert_eq!(fast.stats, plain.stats, "{name}");
                assert_eq!(fast.result, plain.result, "{name}");
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
        let avoid = Continuation::Avoid;
        let options = Options { block: Some(10), overlap: Some(1), continuation: avoid, ..Options::default() };
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
