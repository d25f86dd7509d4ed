//! What repair promises of any map.

use selvedge_core::{
    Domain, ErrorKind, Exemplars, Grid, Plane, Run, SeamCosts, SeamMeasure, SimdLevel, SourceMap, Start,
};
use selvedge_hybrid::{Options, PixelSearch, RepairOptions, RepairStats, Threshold, hybrid, repair};
use selvedge_testkit::{exemplars, simple};

fn of(plane: &Plane<2>) -> Exemplars<2> {
    Exemplars::of(&[std::slice::from_ref(plane)]).unwrap()
}

/// Blocks of 16 laid and cut, never mended.
fn blocks(e: &Exemplars<2>, output: Domain<2>, seed: u64) -> SourceMap<2> {
    let options = Options {
        block: Some([16; 2]),
        k: 1.0,
        max_error: Threshold::Absolute(1.0),
        tolerance: 1.0,
        ..Options::default()
    };
    hybrid(e, output, &options, &Run::seeded(seed)).unwrap().result
}

fn mend(
    e: &Exemplars<2>,
    map: &SourceMap<2>,
    fixed: Option<Grid<bool, 2>>,
    options: &RepairOptions,
) -> (SourceMap<2>, RepairStats) {
    let woven = repair(e, Start { map: map.clone(), fixed, sources: None }, options, &Run::seeded(0)).unwrap();
    assert!(woven.complete);
    (woven.result, woven.stats)
}

#[test]
fn seams_become_cheaper_pass_by_pass_and_never_dearer() {
    for plane in [exemplars::cobbles(), exemplars::weave(), simple::spots(60, 50, 7, 1), simple::noise_rgb(50, 50, 1)] {
        let e = of(&plane);
        let [costs, gradients] =
            [SeamMeasure::Difference, SeamMeasure::Gradient].map(|m| SeamCosts::new(&e, m).unwrap());
        for periodic in [[false, true], [false; 2]] {
            let output = Domain { shape: [70, 80], periodic };
            let map = blocks(&e, output, 4);
            let options = RepairOptions::default();
            let (mended, stats) = mend(&e, &map, None, &options);
            assert!(stats.costs.is_sorted_by(|a, b| a >= b), "{:?}", stats.costs);
            assert_eq!(stats.costs.first(), Some(&costs.total(&map)));
            assert_eq!(stats.costs.last(), Some(&costs.total(&mended)));
            assert!(gradients.total(&mended) <= gradients.total(&map));
            assert!(stats.costs.last() < stats.costs.first() && stats.bad[1] < stats.bad[0], "{stats:?}");
            let differ = map.ids.plane(0).iter().zip(mended.ids.plane(0)).filter(|(a, b)| a != b).count() as u64;
            assert_eq!((stats.pixels, mended.holes()), (differ, 0));
        }
    }
}

#[test]
fn fixed_samples_and_holes_stay_and_maps_without_bad_seams_do() {
    let e = of(&simple::spots(60, 50, 7, 1));
    let output = Domain::open([64, 64]);
    let mut map = blocks(&e, output, 2);
    for at in output.positions().filter(|[y, x]| (20..23).contains(y) && *x < 30) {
        map.ids.set(0, at, selvedge_core::SampleId::UNASSIGNED);
    }
    let fixed = Grid::from_vec(output, 1, output.positions().map(|[y, x]| y < 6 || 50 < x).collect()).unwrap();
    let (mended, stats) = mend(&e, &map, Some(fixed.map(|v| v).unwrap()), &RepairOptions::default());
    assert!(0 < stats.pixels, "{stats:?}");
    let kept = |at| fixed.get(0, at) || !map.ids.get(0, at).is_assigned();
    assert!(output.positions().filter(|&at| kept(at)).all(|at| mended.ids.get(0, at) == map.ids.get(0, at)));
    assert_eq!(mended.holes(), map.holes());
    // No seam is worse than black against white; and a block alone has none.
    let lenient = RepairOptions { pixel_error: Threshold::Absolute(1.0), ..RepairOptions::default() };
    let (same, stats) = mend(&e, &map, None, &lenient);
    assert_eq!((same, stats.bad, stats.pixels), (map, [0, 0], 0));
    let whole = blocks(&e, Domain::open([16, 16]), 1);
    assert_eq!(mend(&e, &whole, None, &RepairOptions::default()).0, whole);
}

#[test]
fn the_repair_is_the_same_on_any_number_of_threads() {
    let e = of(&simple::spots(40, 36, 7, 1));
    let map = blocks(&e, Domain::periodic([48, 40]), 1);
    let on = |threads: usize, search: PixelSearch| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let start = Start { map: map.clone(), fixed: None, sources: None };
        let options = RepairOptions { search, passes: 1, ..RepairOptions::default() };
        let run = Run { simd: SimdLevel::Scalar, ..Run::seeded(threads as u64) };
        pool.install(|| repair(&e, start, &options, &run).unwrap().result)
    };
    let first = on(1, PixelSearch::Coherent);
    assert!(first != map && [2, 3].into_iter().all(|threads| on(threads, PixelSearch::Coherent) == first));
    // The exact search leaves patches, so that little of what it chooses is taken.
    assert!(on(3, PixelSearch::Exact) == on(1, PixelSearch::Exact));
}

#[test]
fn wrong_options_and_foreign_maps_are_refused() {
    let e = of(&simple::spots(30, 30, 7, 1));
    let map = SourceMap::unassigned(&e, Domain::open([9, 9])).unwrap();
    let start = |map: &SourceMap<2>| Start { map: map.clone(), fixed: None, sources: None };
    for wrong in [
        RepairOptions { radius: 0, ..RepairOptions::default() },
        RepairOptions { radius: 65, ..RepairOptions::default() },
        RepairOptions { passes: 0, ..RepairOptions::default() },
        RepairOptions { pixel_error: Threshold::Absolute(f64::NAN), ..RepairOptions::default() },
        RepairOptions { pixel_error: Threshold::OfRandom(-1.0), ..RepairOptions::default() },
    ] {
        assert_eq!(
            repair(&e, start(&map), &wrong, &Run::seeded(0)).unwrap_err().kind(),
            ErrorKind::Option,
            "{wrong:?}"
        );
    }
    let foreign = SourceMap::unassigned(&of(&simple::noise(5, 5, 1)), Domain::open([9, 9])).unwrap();
    let refused = repair(&e, start(&foreign), &RepairOptions::default(), &Run::seeded(0)).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Input);
}

#[test]
fn what_goes_on_around_an_exemplar_is_no_seam_where_it_was_used_so() {
    let e = of(&simple::noise_rgb(24, 20, 3));
    let (source, output) = (e.sources()[0].domain(), Domain::open([50, 60]));
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    output.positions().for_each(|at| {
        map.ids.set(0, at, e.table().id(0, [0, 1].map(|a| (at[a] + 7) % source.shape[a])));
    });
    let of = |circular| mend(&e, &map, None, &RepairOptions { circular, ..RepairOptions::default() });
    let (mended, stats) = of(true);
    assert_eq!((stats.bad, stats.pixels), ([0, 0], 0));
    assert!(mended == map);
    assert!(of(false).1.bad[0] != 0, "to open exemplars they are");
}
