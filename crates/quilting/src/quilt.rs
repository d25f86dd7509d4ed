//! Image quilting: one pass of blocks that agree with their neighbours. `[Efros01 2.2]`

use selvedge_core::{Domain, Exemplars, Limits, Run, Seed, SourceMap, Woven};

use crate::block_grid::BlockGrid;
use crate::options::{Error, Options, Stage, per_mille};
use crate::quilter::{Pass, Progress, Quilter};
use crate::search::{FastSearch, Search};
use crate::{estimate, suggest_block};

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

/// Quilts an output from blocks of the exemplars. `[Efros01 2.2]`
///
/// Each block is drawn from all those of all sources whose overlap error is within the tolerance of the least, then cut
/// along the path of least error against what is there.
///
/// Blocks are laid in waves: block `j` of row `i` is in wave `2 i + j`, and the blocks of a wave, which neither touch nor
/// follow from each other, are looked for at once. Where columns are periodic, each block is a wave. Every block sees the
/// neighbours that it would see in raster order.
///
/// With [`Options::spread`] above 0 an error counts more where the waves before used its place more often than others, and
/// the tolerance is one on what errors count. As these counts go from wave to wave, the output is then another one than
/// that of raster order; with 0 it is the same.
///
/// Periodic axes of `output` close without a seam of their own: at least two blocks go round them, shortened where that
/// many do not fit.
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars without a valid block, an empty output, one
/// over the run's limits (its [`estimate`](crate::estimate()) counts against their memory), or no memory for it.
///
/// # Complexity
/// With `n` exemplar samples, `c` channels and `b = output samples / (block - overlap)^2` blocks: time `O(b * c * n)` for
/// searches of short overlaps or `O(b * c * n log n)` by Fourier transforms, whichever is less, and `O(b * block^2)` for
/// cuts, but for the last ones of a periodic output, which take `O(overlap^4)` each. Space `O(output + c * n)`.
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
    check_limits(output, estimate(&domains(exemplars), exemplars.channels(), output, options), run)?;
    quilt_by(FastSearch::new(exemplars, None, run.simd)?, exemplars, output, options, run)
}

/// The same by any search.
fn quilt_by(
    search: impl Search,
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    let block = options.block.map_or_else(|| suggest_block(exemplars), Ok)?;
    check_fit(exemplars, output, block)?;
    let mut map = SourceMap::unassigned(exemplars, output)?;
    let pass = pass(exemplars, output, options, block, run.seed)?;
    let mut quilter = Quilter::new(&search, pass, run, &mut map)?;
    let complete = quilter.lay_all()?;
    let counts = quilter.counts;
    let stats = Stats {
        block,
        overlap: overlap(options, block)?,
        blocks: counts.blocks,
        candidates: counts.candidates,
        overlap_error: counts.error,
        cut_error: counts.cut_error,
    };
    Ok(Woven { result: map, stats, complete })
}

/// What the only pass is told.
pub(crate) fn pass<'a>(
    exemplars: &'a Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    block: u32,
    seed: Seed,
) -> Result<Pass<'a>, Error> {
    let overlap = overlap(options, block)?;
    let grid = BlockGrid::new(output, block, overlap);
    Ok(Pass {
        exemplars,
        block,
        per_mille: per_mille(options.tolerance),
        stage: options.stage,
        continuation: options.continuation,
        // Blocks that agree with nothing spread by themselves.
        spread: if overlap == 0 { 0.0 } else { options.spread },
        steering: None,
        seed,
        progress: Progress { name: "quilting", before: 0, of: grid.len() as u64 },
        grid,
    })
}

fn overlap(options: &Options, block: u32) -> Result<u32, Error> {
    if options.stage == Stage::Random { Ok(0) } else { options.overlap_of(block) }
}

/// The output and the memory that it takes are within the run's limits.
pub(crate) fn check_limits(output: Domain<2>, needed: u64, run: &Run<'_, 2>) -> Result<(), Error> {
    let ([height, width], Limits { memory: budget, side, samples }) = (output.shape, run.limits);
    if side < height.max(width) || samples < u64::from(height) * u64::from(width) {
        return Err(Error::OutputExceedsLimits { width, height, side, samples });
    }
    if budget < needed { Err(Error::Memory { needed, budget }) } else { Ok(()) }
}

/// The domains of all sources.
pub(crate) fn domains(exemplars: &Exemplars<2>) -> Vec<Domain<2>> {
    exemplars.sources().iter().map(|s| s.domain()).collect()
}

/// There is something to fill, and at least one source holds a block.
pub(crate) fn check_fit(exemplars: &Exemplars<2>, output: Domain<2>, block: u32) -> Result<(), Error> {
    if output.is_empty() {
        return Err(Error::EmptyOutput { width: output.shape[1], height: output.shape[0] });
    }
    let shapes = exemplars.sources().iter().map(|s| s.domain().shape);
    let [height, width] = shapes.max_by_key(|s| s[0].min(s[1])).unwrap_or([0, 0]);
    let limit = height.min(width);
    if limit < block { Err(Error::BlockExceedsExemplar { block, width, height, limit }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Continuation;
    use crate::search::plain::PlainSearch;
    use selvedge_core::{Grid, Plane, Role, Samples};

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
                let plain = quilt_by(PlainSearch::new(&exemplars, None), &exemplars, output, &options, &run).unwrap();
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
            let plain = PlainSearch::new(&exemplars, None);
            let plain = quilt_by(plain, &exemplars, output, &options, &Run::seeded(1)).unwrap();
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
