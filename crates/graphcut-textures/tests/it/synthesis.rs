//! The method through its public interface: what it promises whatever the exemplar.

use crate::common::{PLACEMENTS, blobs, of, weave};
use selvedge_core::{
    Domain, Encoder, Error as CoreError, ErrorKind, Exemplar, Exemplars, Grid, Plane, Render, Role, Run, SampleId,
    Samples, SeamCosts, SeamMeasure, Seed, SimdLevel, SourceMap, Transform, Woven,
};
use selvedge_graphcut_textures::{Error, Options, Placement, Start, Stats, cover, graphcut, graphcut_from, plan};

#[test]
fn everything_is_covered_and_seams_never_become_dearer() {
    let e = of(&blobs([24, 30], 1));
    for placement in PLACEMENTS {
        for seam in [SeamMeasure::Difference, SeamMeasure::Gradient] {
            for periodic in [[false, false], [true, true], [false, true]] {
                let options = Options { placement, seam, refine: Some(12), ..Options::default() };
                let (map, stats) = weave(&e, Domain { shape: [50, 41], periodic }, &options);
                assert!(stats.energy.is_sorted_by(|a, b| a >= b), "{:?}", stats.energy);
                let total = SeamCosts::new(&e, seam).unwrap().total(&map);
                assert_eq!(stats.energy.last(), Some(&total), "the energy is the price of the map's seams");
                assert_ne!(stats.settings.placement, Placement::Auto);
            }
        }
    }
}

#[test]
fn what_is_covered_first_and_refined_later_is_the_same() {
    let parts = |woven: Woven<SourceMap<2>, Stats<2>>| (woven.result, woven.stats, woven.complete);
    let e = of(&blobs([24, 30], 1));
    for placement in [Placement::Random, Placement::Entire, Placement::Sub] {
        for periodic in [[false, false], [true, true]] {
            let (output, run) = (Domain { shape: [44, 50], periodic }, Run::seeded(5));
            let options = Options { placement, ..Options::default() };
            let covered = cover(&e, output, &options, &run).unwrap();
            let draft = graphcut(&e, output, &Options { refine: Some(0), ..options }, &run).unwrap();
            assert_eq!(parts(covered.woven.clone()), parts(draft), "the first part is a run without refinement");
            let whole = graphcut(&e, output, &options, &run).unwrap();
            assert!(0 < whole.stats.improvements, "something is refined");
            assert_eq!(parts(covered.refine(&e, &run).unwrap()), parts(whole));
        }
    }
    // Several levels begin again.
    let large = of(&blobs([70, 64], 2));
    let (options, run) = (Options { levels: Some(2), ..Options::default() }, Run::seeded(6));
    let covered = cover(&large, Domain::open([90, 100]), &options, &run).unwrap();
    let whole = graphcut(&large, Domain::open([90, 100]), &options, &run).unwrap();
    assert_eq!(whole.stats.settings.levels, 2);
    assert_eq!(parts(covered.refine(&large, &run).unwrap()), parts(whole));
}

#[test]
fn clips_are_woven_by_the_same_code() {
    let e = of(&blobs([6, 12, 14], 2));
    for placement in [Placement::Random, Placement::Sub, Placement::Entire] {
        let output = Domain { shape: [9, 16, 18], periodic: [true, false, false] };
        let options = Options { placement, refine: Some(4), ..Options::default() };
        let (map, stats) = weave(&e, output, &options);
        assert!(stats.energy.is_sorted_by(|a, b| a >= b), "{:?}", stats.energy);
        let seams = map.domain().positions().filter(|&at| (0..3).any(|axis| map.is_seam(at, axis)));
        assert_ne!(seams.count(), 0, "no exemplar of 6 frames fills 9 without a seam");
    }
}

#[test]
fn wrapped_seams_are_no_worse_than_inner_ones() {
    let e = of(&blobs([40, 40], 3));
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    for placement in PLACEMENTS {
        for (side, region) in [(56, None), (40, Some([40; 2])), (24, Some([40; 2])), (30, Some([30; 2])), (25, None)] {
            let options = Options { placement, region, ..Options::default() };
            let (mut wrapped, mut inner) = (0, 0);
            for seed in 0..6 {
                let output = Domain::periodic([side, side]);
                let map = graphcut(&e, output, &options, &Run::seeded(seed)).unwrap().result;
                for at in output.positions() {
                    for axis in 0..2 {
                        let cost = i64::from(costs.at(&map, at, axis));
                        if at[axis] + 1 == side { wrapped += cost } else { inner += cost }
                    }
                }
            }
            // Of `side` columns one wraps; a straight uncut seam costs several times the mean.
            assert!(wrapped * i64::from(side - 1) <= 2 * inner, "{placement:?} {side} {region:?}: {wrapped} {inner}");
        }
    }
}

#[test]
fn regular_exemplars_are_matched_whole_and_scattered_ones_in_part() {
    let domain = Domain::open([64, 64]);
    let samples = domain.positions().map(|[y, x]| if (y / 8 + x / 8) % 2 == 0 { 220 } else { 30 }).collect();
    let board = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()));
    let output = Domain::open([70, 70]);
    let (_, regular) = weave(&of(&board), output, &Options::default());
    assert_eq!(regular.settings.placement, Placement::Entire);
    let blobs = of(&blobs([64, 64], 4));
    // An output of six times the samples still shows few copies, if they are laid by no region of one's own.
    for (shape, region, placement) in [
        ([128, 192], None, Placement::Entire),
        ([128, 193], None, Placement::Sub),
        ([70, 70], Some([16; 2]), Placement::Sub),
    ] {
        let options = Options { region, refine: Some(0), ..Options::default() };
        let planned = plan(&blobs, Domain::open(shape), None, &options, &Run::<2>::seeded(0).limits).unwrap();
        assert_eq!(planned.settings.placement, placement, "{shape:?} {region:?}");
    }
}

#[test]
fn variety_keeps_patches_from_forming_a_lattice() {
    let e = of(&blobs([48, 48], 12));
    let most_repeated = |variety: f64| {
        let options = Options { variety: Some(variety), randomness: 0.05, refine: Some(0), ..Options::default() };
        let (map, _) = weave(&e, Domain::open([200, 200]), &options);
        let mut vectors = std::collections::BTreeMap::new();
        for at in map.domain().positions().filter(|&at| map.is_seam(at, 1) && at[1] + 1 < 200) {
            let [a, b] = [at, [at[0], at[1] + 1]].map(|p| map.locate(p).unwrap().1);
            let vector = [0, 1].map(|axis| (a[axis] as i32 - b[axis] as i32).div_euclid(4));
            *vectors.entry(vector).or_insert(0_u32) += 1;
        }
        vectors.into_values().max().unwrap()
    };
    let (without, with) = (most_repeated(0.0), most_repeated(3.0));
    assert!(with < without, "{with} seams have one vector, and {without} without variety");
}

#[test]
fn simd_levels_make_no_difference() {
    let e = of(&blobs([40, 40], 13));
    for placement in [Placement::Sub, Placement::Entire] {
        let options = Options { placement, refine: Some(5), ..Options::default() };
        let on = |simd| graphcut(&e, Domain::open([60, 60]), &options, &Run { simd, ..Run::seeded(2) }).unwrap().result;
        assert_eq!(on(SimdLevel::Scalar), on(SimdLevel::Auto));
    }
}

#[test]
fn the_map_does_not_depend_on_threads() {
    let e = of(&blobs([32, 32], 4));
    for placement in PLACEMENTS {
        // Few enough samples for several regions at once.
        let options = Options { placement, tries: 3, refine: Some(20), region: Some([10; 2]), ..Options::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| weave(&e, Domain::periodic([70, 84]), &options))
        };
        let one = on(1);
        assert!([2, 3, 8].into_iter().all(|threads| on(threads) == one));
    }
}

#[test]
fn regions_and_reach_have_a_length_along_each_axis() {
    // Wider than the exemplar is high.
    let e = of(&blobs([20, 60], 5));
    for placement in PLACEMENTS {
        let options = Options { placement, region: Some([9, 30]), reach: Some([3, 0]), ..Options::default() };
        let (_, stats) = weave(&e, Domain { shape: [40, 70], periodic: [true, false] }, &options);
        assert_eq!((stats.settings.region, stats.settings.reach), ([9, 30], [3, 0]));
        assert!(stats.energy.is_sorted_by(|a, b| a >= b));
    }
    let clip = of(&blobs([6, 20, 22], 6));
    let options = Options { region: Some([3, 10, 8]), reach: Some([1, 4, 9]), refine: Some(3), ..Options::default() };
    weave(&clip, Domain::open([10, 24, 30]), &options);

    // Around a single hole nothing changes beyond the region and its reach, however bad it is there.
    let (output, hole) = (Domain::open([50, 50]), [24, 25]);
    let e = of(&blobs([50, 50], 7));
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    let mut rng = Seed(7).rng();
    map.ids.plane_mut(0).fill_with(|| SampleId::new(rng.below(2500)));
    map.ids.set(0, hole, SampleId::UNASSIGNED);
    let mut widest = [0; 2];
    for seed in 0..40 {
        let start = Start { map: map.clone(), fixed: None, sources: None };
        let (region, reach) = ([3, 5], [2, 9]);
        let options = Options {
            placement: Placement::Random,
            region: Some(region),
            reach: Some(reach),
            refine: Some(0),
            ..Options::default()
        };
        let woven = graphcut_from(&e, start, &options, &Run::seeded(seed)).unwrap().result;
        for at in output.positions().filter(|&at| woven.ids.get(0, at) != map.ids.get(0, at)) {
            widest = std::array::from_fn(|axis| widest[axis].max(at[axis].abs_diff(hole[axis])));
        }
        assert!(widest[0] <= 1 + 2 && widest[1] <= 2 + 9, "{widest:?}");
    }
    assert!(1 < widest[0] && 8 < widest[1], "patches reach as far as they may somewhere: {widest:?}");
    let fails = |region| {
        let options = Options { region: Some(region), ..Options::default() };
        graphcut(&of(&blobs([20, 60], 5)), output, &options, &Run::seeded(0)).unwrap_err()
    };
    let error = fails([21, 3]);
    assert_eq!(error, Error::RegionExceedsExemplar { region: vec![21, 3], largest: vec![20, 60] });
    assert!(error.to_string().contains("a region of [21, 3] samples (the largest is [20, 60])"), "{error}");
    assert!(fails([21; 2]).to_string().contains("a region of 21 samples a side"));
}

#[test]
fn refinement_goes_on_elsewhere_when_the_worst_seams_cannot_be_mended() {
    // On the left, seams that are fixed, dearer than all others; on the right, one that any patch mends.
    let domain = Domain::open([40, 160]);
    let value = |[y, x]: [u32; 2]| {
        (Seed(2).derive("grain", u64::from(y * 160 + x)).0 % 24) as u8 + if x < 20 { 200 } else { 0 }
    };
    let grid = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
    let e = of(&Plane::new(Role::Scalar, Samples::U8(grid)));
    let output = Domain::open([40, 120]);
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    let mut fixed = Grid::try_filled(output, 1, false).unwrap();
    for [y, x] in output.positions() {
        // Stripes of the bright and the dark part by turns, then two dark pieces that do not fit.
        let from = if x < 32 {
            x / 4 % 2 * 60 + x % 4
        } else if x < 90 {
            x + 20
        } else {
            x + 21
        };
        map.ids.set(0, [y, x], e.table().id(0, [y, from]));
        fixed.set(0, [y, x], x < 32);
    }
    // Windows that are not remembered would be tried again and again: as many failures in a row end the run.
    let options = Options {
        placement: Placement::Sub,
        seam: SeamMeasure::Difference,
        region: Some([8; 2]),
        patience: 120,
        refine: Some(200),
        ..Options::default()
    };
    let start = Start { map, fixed: Some(fixed), sources: None };
    let woven = graphcut_from(&e, start, &options, &Run::seeded(3)).unwrap();
    assert!(0 < woven.stats.improvements, "{:?}", woven.stats);
    assert!(woven.stats.energy.is_sorted_by(|a, b| a >= b));
}

#[test]
fn several_exemplars_and_orientations_are_used() {
    let (a, b) = (blobs([26, 20], 8), blobs([20, 30], 8));
    let planes = [std::slice::from_ref(&a), std::slice::from_ref(&b)];
    let turns: Vec<Transform> = (0..4).map(|quarter_turns| Transform::Exact { quarter_turns, mirror: false }).collect();
    let turned = planes.map(|planes| Exemplar::new(planes).shown(&turns));
    let e = Exemplars::new(&Encoder::fit(&planes).unwrap(), &turned).unwrap();
    let options = Options { placement: Placement::Random, refine: Some(0), ..Options::default() };
    let (map, _) = weave(&e, Domain::open([90, 90]), &options);
    let used: std::collections::BTreeSet<usize> =
        map.domain().positions().filter_map(|p| map.locate(p)).map(|(s, _)| s).collect();
    assert!(6 <= used.len(), "{used:?} of 8");
    map.render(&[&a, &b]).unwrap();
}

#[test]
fn constant_and_tiny_exemplars_end() {
    let constant = |shape| {
        let grid = Grid::try_filled(Domain::open(shape), 1, 9_u8).unwrap();
        of(&Plane::new(Role::Scalar, Samples::U8(grid)))
    };
    for placement in PLACEMENTS {
        let options = Options { placement, ..Options::default() };
        for (shape, output) in [([16, 16], [40, 40]), ([1, 1], [7, 5]), ([1, 9], [6, 20]), ([3, 2], [3, 2])] {
            let (_, stats) = weave(&constant(shape), Domain::open(output), &options);
            assert_eq!(stats.energy, [0], "{shape:?}");
            weave(&constant(shape), Domain::periodic(output), &options);
        }
    }
}

#[test]
fn wrong_input_is_an_error_with_its_numbers() {
    let e = of(&blobs([16, 20], 9));
    let run = Run::seeded(0);
    let fails = |output, options: &Options<2>| graphcut(&e, output, options, &run).unwrap_err();
    let output = Domain::open([20, 20]);
    let options = Options::default();
    let region = fails(output, &Options { region: Some([17; 2]), ..options });
    assert_eq!(region, Error::RegionExceedsExemplar { region: vec![17; 2], largest: vec![16, 20] });
    assert_eq!(region.kind(), ErrorKind::Input);
    assert!(matches!(fails(Domain::open([0, 5]), &options), Error::Core(selvedge_core::Error::EmptyOutput { .. })));
    for wrong in [
        Options { randomness: f64::NAN, ..options },
        Options { randomness: -1.0, ..options },
        Options { variety: Some(f64::INFINITY), ..options },
        Options { region: Some([4, 0]), ..options },
        Options { tries: 0, ..options },
        Options { tries: 65, ..options },
        Options { patience: 0, ..options },
    ] {
        assert_eq!(fails(output, &wrong).kind(), ErrorKind::Option);
    }
    let start = |fixed: Option<Grid<bool, 2>>, sources: Option<Grid<u64, 2>>| {
        let map = SourceMap::unassigned(&e, output).unwrap();
        graphcut_from(&e, Start { map, fixed, sources }, &options, &run).unwrap_err()
    };
    let other = Domain::open([20, 21]);
    assert!(matches!(start(Grid::try_filled(other, 1, true).ok(), None), Error::Core(CoreError::StartShape { .. })));
    assert!(matches!(start(None, Grid::try_filled(other, 1, 1).ok()), Error::Core(CoreError::StartShape { .. })));
    assert_eq!(start(None, Grid::try_filled(output, 1, 2).ok()), Error::Core(CoreError::NoSource { at: vec![0, 0] }));
    let small = Run { limits: selvedge_core::Limits { memory: 1000, ..run.limits }, ..run };
    assert_eq!(graphcut(&e, output, &options, &small).unwrap_err().kind(), ErrorKind::Memory);
    let map = SourceMap::unassigned(&of(&blobs([5, 5], 1)), output).unwrap();
    let foreign = graphcut_from(&e, Start { map, fixed: None, sources: None }, &options, &run);
    assert!(matches!(foreign, Err(Error::Core(CoreError::ForeignMap { .. }))));
    // As many samples, in other sources.
    let halves = [blobs([16, 10], 1), blobs([16, 10], 2)];
    let planes = halves.each_ref().map(std::slice::from_ref);
    let map = SourceMap::unassigned(&Exemplars::of(&planes).unwrap(), output).unwrap();
    let foreign = graphcut_from(&e, Start { map, fixed: None, sources: None }, &options, &run);
    assert!(matches!(foreign, Err(Error::Core(CoreError::ForeignMap { found: 2, sources: 1, .. }))));
    assert!(matches!(
        start(Grid::from_vec(output, 0, Vec::new()).ok(), None),
        Error::Core(CoreError::Channels { found: 0, .. })
    ));
    let many: Vec<Plane<2>> = (0..65).map(|i| blobs([16, 20], i)).collect();
    let planes: Vec<&[Plane<2>]> = many.iter().map(std::slice::from_ref).collect();
    let many = Exemplars::of(&planes).unwrap();
    let map = SourceMap::unassigned(&many, output).unwrap();
    let start = Start { map, fixed: None, sources: Grid::try_filled(output, 1, 1).ok() };
    let found = graphcut_from(&many, start, &options, &run);
    assert!(matches!(found, Err(Error::Core(CoreError::TooManySources { found: 65, most: 64 }))));
}

struct Stop(std::sync::atomic::AtomicU32);
impl selvedge_core::Observer<2> for Stop {
    fn cancelled(&self) -> bool {
        use std::sync::atomic::Ordering;
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_err()
    }
}

#[test]
fn a_cancelled_run_answers_with_its_best_so_far() {
    let e = of(&blobs([16, 16], 10));
    let stop = Stop(5.into());
    let run = Run { observer: &stop, ..Run::seeded(0) };
    let woven = graphcut(&e, Domain::open([60, 60]), &Options::default(), &run).unwrap();
    assert!(!woven.complete && 0 < woven.result.holes());
}

#[test]
fn a_plan_tells_what_a_run_chooses_and_refuses_what_a_run_refuses() {
    let e = of(&blobs([40, 44], 3));
    let output = Domain::open([60, 70]);
    for placement in PLACEMENTS {
        let options = Options { placement, refine: Some(0), ..Options::default() };
        let planned = plan(&e, output, None, &options, &Run::<2>::seeded(0).limits).unwrap();
        let (_, stats) = weave(&e, output, &options);
        let chosen = (
            stats.settings.placement,
            stats.settings.regularity,
            stats.settings.region,
            stats.settings.reach,
            stats.settings.variety,
            stats.settings.apart,
        );
        let told = (
            planned.settings.placement,
            planned.settings.regularity,
            planned.settings.region,
            planned.settings.reach,
            planned.settings.variety,
            planned.settings.apart,
        );
        assert_eq!(told, chosen);
    }
    // Of two sources, the one that the field lets show is measured.
    let planes = [blobs([40, 44], 3), blobs([24, 24], 4)];
    let planes = [std::slice::from_ref(&planes[0]), std::slice::from_ref(&planes[1])];
    let both = Exemplars::of(&planes).unwrap();
    let field = Grid::try_filled(output, 1, 0b10).unwrap();
    let limits = Run::<2>::seeded(0).limits;
    let options = Options { region: Some([30; 2]), ..Options::default() };
    assert!(plan(&both, output, None, &options, &limits).is_ok());
    let refused = plan(&both, output, Some(&field), &options, &limits);
    assert!(matches!(refused, Err(Error::RegionExceedsExemplar { .. })), "{refused:?}");
    assert!(plan(&e, output, None, &Options { tries: 0, ..options }, &limits).is_err());
    assert!(plan(&e, Domain::open([0, 9]), None, &options, &limits).is_err());
    let short = selvedge_core::Limits { memory: 1000, ..limits };
    assert_eq!(plan(&e, output, None, &options, &short).unwrap_err().kind(), ErrorKind::Memory);
}
