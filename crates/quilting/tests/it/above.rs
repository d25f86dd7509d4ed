//! What holds for quilts from large exemplars, whose blocks are looked for at half the size first.

use selvedge_core::{Bytes, Domain, Exemplars, Limits, Plane, Render, Run, SimdLevel, SourceMap};
use selvedge_quilting::{Options, Plan};
use selvedge_testkit::simple;

fn options() -> Options {
    Options { block: Some(72), overlap: Some(18), ..Options::default() }
}

/// Two exemplars of sizes that half is no half of.
fn planes() -> [Plane<2>; 2] {
    [simple::spots(391, 387, 13, 1), simple::spots(402, 399, 9, 2)]
}

fn weave(exemplars: &Exemplars<2>, output: Domain<2>, run: &Run<'_, 2>) -> SourceMap<2> {
    let plan = Plan::new(exemplars, output, &options(), run).unwrap();
    assert_eq!(plan.halvings(), 1);
    plan.weave(run).unwrap().result
}

#[test]
fn the_map_is_the_same_on_any_number_of_threads_with_any_instructions_and_within_any_limit() {
    let planes = planes();
    let exemplars = Exemplars::of(&planes.each_ref().map(std::slice::from_ref)).unwrap();
    // The last blocks are cropped to fewer samples than an overlap has.
    let output = Domain { shape: [200, 220], periodic: [false, true] };
    let on = |threads: usize, run: Run<'_, 2>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| weave(&exemplars, output, &run))
    };
    let first = on(1, Run::seeded(5));
    assert_eq!(first.holes(), 0);
    assert!([2, 3].into_iter().all(|threads| on(threads, Run::seeded(5)) == first));
    for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni] {
        assert_eq!(on(2, Run { simd, ..Run::seeded(5) }), first, "{simd:?}");
    }
    // What is just enough.
    let plan = Plan::new(&exemplars, output, &options(), &Run::seeded(5)).unwrap();
    let Bytes(memory) = plan.bytes();
    assert_eq!(on(2, Run { limits: Limits { memory, ..Limits::default() }, ..Run::seeded(5) }), first);
    assert_ne!(on(2, Run::seeded(6)), first, "another seed gives another map");
}

/// Halved, both hold halves of it.
#[test]
fn a_block_that_one_exemplar_alone_holds_is_taken_from_that_one() {
    let planes = [simple::spots(404, 406, 13, 1), simple::spots(400, 400, 9, 2)];
    let exemplars = Exemplars::of(&planes.each_ref().map(std::slice::from_ref)).unwrap();
    let options = Options { block: Some(401), overlap: Some(100), ..Options::default() };
    for seed in 0..3 {
        let plan = Plan::new(&exemplars, Domain::open([404, 750]), &options, &Run::seeded(seed)).unwrap();
        assert_eq!(plan.halvings(), 1);
        let map = plan.weave(&Run::seeded(seed)).unwrap().result;
        let whole = Domain::open([200, 401]).positions();
        assert!(whole.into_iter().all(|at| map.locate(at).is_some_and(|(source, _)| source == 0)), "{seed}");
    }
}

#[test]
fn blocks_of_all_exemplars_are_laid_and_tiling_closes() {
    let planes = planes();
    let exemplars = Exemplars::of(&planes.each_ref().map(std::slice::from_ref)).unwrap();
    let output = Domain::periodic([230, 250]);
    let [mut wrap, mut open] = [0_u64; 2];
    let mut used = [0; 2];
    for seed in 0..4 {
        let map = weave(&exemplars, output, &Run::seeded(seed));
        output.positions().for_each(|at| used[map.locate(at).unwrap().0] += 1);
        wrap += steps_across(&map, &planes);
        let ends = Plan::new(&exemplars, Domain::open(output.shape), &options(), &Run::seeded(seed)).unwrap();
        open += steps_across(&ends.weave(&Run::seeded(seed)).unwrap().result, &planes);
    }
    assert!(used.into_iter().all(|n| 0 < n), "{used:?}");
    assert!(wrap * 2 < open, "{wrap} across the wrap, {open} where ends meet by chance");
}

/// How much samples differ from the last column to the first.
fn steps_across(map: &SourceMap<2>, planes: &[Plane<2>; 2]) -> u64 {
    let picture = map.render(&planes.each_ref()).unwrap();
    let grid = selvedge_testkit::bytes(&picture);
    let [h, w] = map.domain().shape.map(|n| n as usize);
    (0..h).map(|y| u64::from(grid[y * w].abs_diff(grid[y * w + w - 1]))).sum()
}
