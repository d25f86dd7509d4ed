//! What hybrid synthesis promises, on generated textures and through the public interface alone.

use selvedge_core::{
    Bytes, Domain, Encoder, Error as CoreError, ErrorKind, Event, Exemplar, Exemplars, Grid, Limits, Observer, Plane,
    Run, SampleId, Samples, SeamCosts, SeamMeasure, SimdLevel, SourceMap, Start,
};
use selvedge_hybrid::{
    Error, Layout, Options, PixelSearch, Plan, Resynthesize, Split, Stats, Threshold, hybrid, hybrid_from,
};
use selvedge_testkit::{exemplars, simple};

fn of(plane: &Plane<2>) -> Exemplars<2> {
    Exemplars::of(&[std::slice::from_ref(plane)]).unwrap()
}

fn weave(exemplar: &Plane<2>, output: Domain<2>, options: &Options, seed: u64) -> (SourceMap<2>, Stats) {
    let woven = hybrid(&of(exemplar), output, options, &Run::seeded(seed)).unwrap();
    assert!(woven.complete);
    assert_eq!(woven.result.holes(), 0);
    (woven.result, woven.stats)
}

fn blocks(side: u32) -> Options {
    Options { block: Some([side; 2]), ..Options::default() }
}

#[test]
fn everything_is_filled_whatever_the_options_and_exemplars_are() {
    let planes = [simple::spots(40, 33, 7, 1), simple::constant(33, 47, 9), simple::noise_rgb(36, 36, 2)];
    for (i, plane) in planes.iter().enumerate() {
        for output in
            [Domain::open([50, 37]), Domain { shape: [37, 50], periodic: [false, true] }, Domain::periodic([19, 70])]
        {
            for options in [
                blocks(16),
                Options { layout: Layout::Brick, k: 0.0, resynthesize: Resynthesize::Overlap, ..blocks(8) },
                Options { circular: true, k: 1.0, block: Some([8, 16]), ..blocks(8) },
                Options { max_error: Threshold::OfRandom(0.01), search: PixelSearch::Coherent, k: 0.1, ..blocks(4) },
                Options { block: None, tolerance: 0.0, spread: 0.0, ..blocks(1) },
            ] {
                weave(plane, output, &options, i as u64);
            }
        }
    }
    for [w, h] in [[1, 1], [1, 40], [2, 3]] {
        weave(&simple::noise(w, h, 1), Domain::open([9, 13]), &Options::default(), 1);
    }
}

#[test]
fn without_limits_blocks_are_never_split_nor_resynthesised() {
    let options = Options { max_error: Threshold::Absolute(1.0), k: 1.0, ..blocks(16) };
    let (map, stats) = weave(&exemplars::cobbles(), Domain::open([64, 80]), &options, 3);
    assert_eq!((stats.levels.len(), stats.levels[0].blocks, stats.levels[0].splits), (1, 20, 0));
    assert_eq!((stats.cuts, stats.resyntheses, stats.pixels), (19, 0, 0));
    assert_eq!(stats.laid, vec![0; 64 * 80]);
    // Each block is a copy but for its overlaps: what lies further in than those of the next ones is whole.
    for (y, x) in (0..4).flat_map(|y| (0..5).map(move |x| (y, x))) {
        let (first, at) = (map.ids.get(0, [16 * y, 16 * x]), |dy: u32, dx: u32| [16 * y + dy, 16 * x + dx]);
        for (dy, dx) in (0..12).flat_map(|dy| (0..12).map(move |dx| (dy, dx))) {
            assert_eq!(map.table.step(first, [dy as i32, dx as i32]), Some(map.ids.get(0, at(dy, dx))), "{y} {x}");
        }
    }
}

#[test]
fn without_any_error_allowed_all_that_differs_is_single_samples() {
    let options = Options { max_error: Threshold::Absolute(0.0), split: Split::Always, ..blocks(8) };
    let (_, stats) = weave(&simple::noise(24, 24, 3), Domain::open([48, 40]), &options, 1);
    let (last, whole) = stats.levels.split_last().unwrap();
    assert_eq!((stats.levels.len(), last.splits), (4, 0));
    assert!(whole.iter().all(|level| level.error == 0.0), "what was laid whole fits perfectly: {:?}", stats.levels);
    assert!(300 < last.blocks && 0 < stats.unsplittable && stats.unsplittable <= last.blocks, "{stats:?}");
}

/// A picture with every value times two.
fn doubled(plane: &Plane<2>) -> Plane<2> {
    let Samples::U8(grid) = &plane.samples else { panic!("8 bits") };
    Plane::new(plane.role, Samples::U8(grid.map(|v| v * 2).unwrap()))
}

#[test]
fn automatic_thresholds_follow_the_contrast_of_the_exemplar() {
    let half = simple::spots(48, 48, 7, 5);
    let Samples::U8(grid) = &half.samples else { panic!("8 bits") };
    let half = Plane::new(half.role, Samples::U8(grid.map(|v| v / 2).unwrap()));
    let options =
        Options { resynthesize: Resynthesize::Overlap, k: 0.3, max_error: Threshold::OfRandom(0.2), ..blocks(16) };
    let (one, one_stats) = weave(&half, Domain::open([70, 70]), &options, 2);
    let (two, two_stats) = weave(&doubled(&half), Domain::open([70, 70]), &options, 2);
    assert_eq!(one, two);
    assert!(0 < one_stats.pixels && 0 < one_stats.levels[0].splits && one_stats.pixels == two_stats.pixels);
    assert!((two_stats.max_error / one_stats.max_error - 4.0).abs() < 1e-6);
}

#[test]
fn the_map_is_the_same_on_any_number_of_threads_and_with_any_instructions() {
    let exemplars = of(&exemplars::weave());
    for search in [PixelSearch::Coherent, PixelSearch::Exact] {
        let options = Options {
            search,
            resynthesize: Resynthesize::Overlap,
            pixel_error: Threshold::OfRandom(0.5),
            ..blocks(16)
        };
        let output = Domain { shape: [40, 52], periodic: [false, true] };
        let on = |threads: usize, simd: SimdLevel| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let run = Run { simd, ..Run::seeded(5) };
            pool.install(|| hybrid(&exemplars, output, &options, &run).unwrap().result)
        };
        let first = on(1, SimdLevel::Auto);
        for threads in [2, 3] {
            assert_eq!(on(threads, SimdLevel::Auto), first, "{threads} threads");
        }
        for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512] {
            assert_eq!(on(2, simd), first, "{simd:?}");
        }
        assert_ne!(hybrid(&exemplars, output, &options, &Run::seeded(6)).unwrap().result, first, "another seed");
    }
}

#[test]
fn masked_samples_are_never_used() {
    let exemplar = simple::spots(64, 64, 7, 1);
    let domain = exemplar.domain();
    let mut mask = Grid::try_filled(domain, 1, true).unwrap();
    for at in domain.positions().filter(|[y, x]| (28..33).contains(y) || (x + y) % 31 == 30) {
        mask.set(0, at, false);
    }
    let planes = [std::slice::from_ref(&exemplar)];
    let exemplars =
        Exemplars::new(&Encoder::fit(&planes).unwrap(), &[Exemplar::new(planes[0]).masked(Some(&mask))]).unwrap();
    for options in [blocks(8), Options { circular: true, k: 0.0, pixel_error: Threshold::OfRandom(0.02), ..blocks(32) }]
    {
        let map = hybrid(&exemplars, Domain::periodic([50, 50]), &options, &Run::seeded(2)).unwrap().result;
        assert!(map.domain().positions().all(|at| mask.get(0, map.locate(at).unwrap().1)));
    }
}

#[test]
fn what_is_fixed_stays_and_holes_are_filled() {
    let exemplar = exemplars::cobbles();
    let exemplars = of(&exemplar);
    let (start, _) = weave(&exemplar, Domain::open([80, 80]), &Options { k: 1.0, ..blocks(4) }, 1);
    let mut holed = start.clone();
    let in_hole = |[y, x]: [u32; 2]| (y as i32 - 40).pow(2) + (x as i32 - 33).pow(2) < 400;
    start.domain().positions().filter(|&at| in_hole(at)).for_each(|at| holed.ids.set(0, at, SampleId::UNASSIGNED));
    let fixed = Grid::try_filled(start.domain(), 1, true).unwrap();
    let begin = Start { map: holed.clone(), fixed: Some(fixed), sources: None };
    let options = Options { pixel_error: Threshold::OfRandom(0.05), k: 0.0, ..blocks(16) };
    let filled = hybrid_from(&exemplars, begin, None, &options, &Run::seeded(9)).unwrap();
    assert_eq!(filled.result.holes(), 0);
    assert!(0 < filled.stats.pixels, "{:?}", filled.stats);
    let changed = |at: [u32; 2]| filled.result.ids.get(0, at) != start.ids.get(0, at);
    assert!(start.domain().positions().all(|at| in_hole(at) || !changed(at)));
    let stood = filled.stats.laid.iter().map(|&laid| laid == Stats::STOOD);
    assert!(start.domain().positions().zip(stood).all(|(at, stood)| stood != in_hole(at)));
    let chosen = filled.stats.laid.iter().filter(|&&laid| laid == Stats::CHOSEN).count() as u64;
    assert!((1..=filled.stats.pixels).contains(&chosen), "later blocks may lie over them: {chosen}");
    // Nothing is laid where nothing is missing.
    let begin = Start { map: start.clone(), fixed: None, sources: None };
    let same = hybrid_from(&exemplars, begin, None, &options, &Run::seeded(9)).unwrap();
    assert_eq!((same.result, same.stats.levels.len()), (start, 0));
}

#[test]
fn seams_where_an_output_closes_cost_no_more_than_others() {
    let exemplar = exemplars::cobbles();
    let costs = SeamCosts::new(&of(&exemplar), SeamMeasure::Difference).unwrap();
    // What the wraps cost of what all rows and columns do in the mean.
    let share = |periodic: bool| {
        let output = if periodic { Domain::periodic([96, 96]) } else { Domain::open([96, 96]) };
        let mut sums = [0, 0];
        for seed in 0..8 {
            let mut map = weave(&exemplar, output, &blocks(16), seed).0;
            map.ids = map.ids.with_periodic([true; 2]);
            let at = |at, axis| i64::from(costs.at(&map, at, axis));
            sums[0] += (0..96).map(|i| at([95, i], 0) + at([i, 95], 1)).sum::<i64>() * 96;
            sums[1] += costs.total(&map);
        }
        sums[0] as f64 / sums[1] as f64
    };
    // Seams lie where blocks end, of which six close each axis: with one in 16 columns, those cost 16 times the mean if
    // they are as good.
    let (closed, open) = (share(true), share(false));
    assert!(closed < 3.0 && 2.0 * closed < open, "{closed} {open}");
}

#[test]
fn bad_input_is_named_with_numbers_and_a_remedy() {
    let e = of(&simple::spots(40, 50, 7, 1));
    let run = Run::seeded(0);
    let fails = |output: Domain<2>, options: &Options| Plan::new(&e, output, options, &run).unwrap_err();
    let output = Domain::open([20, 20]);
    for wrong in [
        Options { k: -0.1, ..blocks(8) },
        Options { k: f64::NAN, ..blocks(8) },
        Options { max_error: Threshold::Absolute(1.5), ..blocks(8) },
        Options { pixel_error: Threshold::Absolute(f64::NAN), ..blocks(8) },
        Options { max_error: Threshold::OfRandom(-1.0), ..blocks(8) },
        Options { tolerance: f64::INFINITY, ..blocks(8) },
        Options { spread: 11.0, ..blocks(8) },
        blocks(24),
        blocks(0),
    ] {
        assert_eq!(fails(output, &wrong).kind(), ErrorKind::Option, "{wrong:?}");
    }
    let large = fails(output, &blocks(64));
    assert_eq!(large.to_string(), "40x50 px is smaller than the block of 64x64 px with its overlap");
    // One that leaves no room for an overlap would be laid once, and split everywhere else.
    let tight = of(&simple::noise(32, 32, 1));
    let plan = |shape| Plan::new(&tight, Domain::open(shape), &blocks(32), &run);
    assert_eq!(plan([33, 32]).unwrap_err().remedy(), "use a block of at most 16 or a larger exemplar");
    assert!(plan([32, 32]).is_ok());
    assert_eq!(
        (large.kind(), large.remedy().as_str()),
        (ErrorKind::Input, "use a block of at most 16 or a larger exemplar")
    );
    assert!(matches!(fails(Domain::open([0, 5]), &blocks(8)), Error::Core(selvedge_core::Error::EmptyOutput { .. })));
    let small = Run { limits: Limits { memory: 1000, ..run.limits }, ..run };
    // What is chosen by a look at the exemplars takes memory at once; the work does when it begins.
    let looked = Plan::new(&e, output, &Options::default(), &small).unwrap_err();
    let over = Plan::new(&e, output, &blocks(8), &small).unwrap().weave(&small).unwrap_err();
    for error in [looked, over] {
        assert!(matches!(error, Error::Core(CoreError::OverBudget { budget: Bytes(1000), .. })));
    }
    let foreign = SourceMap::unassigned(&of(&simple::noise(5, 5, 1)), output).unwrap();
    let foreign = hybrid_from(&e, Start { map: foreign, fixed: None, sources: None }, None, &blocks(8), &run);
    assert!(matches!(foreign, Err(Error::Core(CoreError::ForeignMap { .. }))));
}

struct Stop(std::sync::atomic::AtomicU32);
impl Observer<2> for Stop {
    fn event(&self, event: &Event<'_, 2>) {
        assert!(event.so_far.is_some() && event.of == 16);
        self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        5 <= self.0.load(std::sync::atomic::Ordering::Relaxed)
    }
}

#[test]
fn a_run_that_is_cancelled_answers_with_what_it_has() {
    let stop = Stop(0.into());
    let run = Run { observer: &stop, ..Run::seeded(0) };
    let woven = hybrid(&of(&exemplars::weave()), Domain::open([64, 64]), &blocks(16), &run).unwrap();
    assert!(!woven.complete);
    assert!(0 < woven.result.holes() && woven.result.holes() < 64 * 64 * 3 / 4);
}
