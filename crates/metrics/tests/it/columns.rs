//! What the columns say of outputs whose fault is known, and of plain loops.

use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, SampleId, Samples, Seed, SimdLevel, SourceMap};
use selvedge_metrics::{Columns, Error, Judge, preference, washed_out};
use selvedge_testkit::exemplars;

/// A part of the weave: a lattice with details.
fn weave() -> Exemplars<2> {
    Exemplars::of(&[&[exemplars::weave()]]).unwrap()
}

fn judge(of: &Exemplars<2>) -> Judge {
    Judge::new(of, SimdLevel::Auto).unwrap()
}

/// The map that shows, at each position, the exemplar's sample that `at` names.
fn map(of: &Exemplars<2>, domain: Domain<2>, at: impl Fn([u32; 2]) -> [u32; 2]) -> SourceMap<2> {
    let ids = domain.positions().map(|p| of.table().id(0, at(p))).collect();
    SourceMap::new(Grid::from_vec(domain, 1, ids).unwrap(), of.table().clone()).unwrap()
}

fn picture(of: &Exemplars<2>, map: &SourceMap<2>) -> Grid<u8, 2> {
    let from = &of.sources()[0].features;
    let mut out = Grid::try_filled(map.domain(), from.channels(), 0_u8).unwrap();
    for c in 0..from.channels() {
        let plane: Vec<u8> = map.ids.plane(0).iter().map(|id: &SampleId| from.plane(c)[id.get() as usize]).collect();
        out.plane_mut(c).copy_from_slice(&plane);
    }
    out
}

/// Columns of the output that a map shows.
fn columns(of: &Exemplars<2>, map: &SourceMap<2>) -> Columns {
    judge(of).columns(&picture(of, map), Some(map)).unwrap()
}

#[test]
fn a_copy_is_perfect() {
    let of = weave();
    let found = columns(&of, &map(&of, of.sources()[0].domain(), |p| p));
    let none = [found.coherence, found.coherence_2, found.coherence_4, found.arrangement, found.worst];
    assert_eq!(none, [0.0; 5], "{found:?}");
    assert_eq!([found.completeness_2, found.completeness_4, found.colour, found.shade, found.scale], [0.0; 5]);
    let seams = found.seams.unwrap();
    assert_eq!((seams.energy, seams.density, seams.torn, seams.used), (0.0, 0.0, 0.0, 1.0));
    assert!(found.lattice.abs() < 0.1 && found.sharpness == 0.0 && found.bland.abs() < 1e-9, "{found:?}");
}

/// Blocks of the exemplar at random: each fault shows in its column, and the copy is preferred.
#[test]
fn what_became_one_blur_is_washed_out() {
    let of = weave();
    let whole = picture(&of, &map(&of, of.sources()[0].domain(), |p| p));
    assert_eq!(washed_out(&of, &whole), Ok(0.0));
    // Its left half keeps a twelfth of its contrast about the middle of the scale, or half of it.
    let faded = |parts: i32| {
        let [_, width] = whole.domain().shape;
        let value = |c: usize, [y, x]: [u32; 2]| match i32::from(whole.get(c, [y, x])) {
            v if width / 2 < x => v as u8,
            v => (128 + (v - 128) / parts) as u8,
        };
        let samples = (0..whole.channels()).flat_map(|c| whole.domain().positions().map(move |at| (c, at)));
        Grid::from_vec(whole.domain(), whole.channels(), samples.map(|(c, at)| value(c, at)).collect()).unwrap()
    };
    let share = washed_out(&of, &faded(12)).unwrap();
    assert!((0.3..0.6).contains(&share), "{share}");
    assert_eq!(washed_out(&of, &faded(2)), Ok(0.0));
    let one = Grid::try_filled(Domain::open([64, 64]), whole.channels(), 90).unwrap();
    assert_eq!(washed_out(&of, &one), Ok(1.0));
    let small = Grid::try_filled(Domain::open([8, 64]), whole.channels(), 90).unwrap();
    assert_eq!(washed_out(&of, &small), Ok(0.0), "it holds no window");
}

#[test]
fn random_blocks_break_seams_structure_and_lattice() {
    let of = weave();
    let [h, w] = of.sources()[0].domain().shape;
    let blocks = map(&of, Domain::open([h, w]), |[y, x]| {
        let mut rng = Seed(3).derive("test/block", u64::from(y / 20 * 1000 + x / 20)).rng();
        [rng.below(h - 20) + y % 20, rng.below(w - 20) + x % 20]
    });
    let (good, bad) = (columns(&of, &map(&of, Domain::open([h, w]), |p| p)), columns(&of, &blocks));
    let seams = bad.seams.unwrap();
    assert!(0.6 < seams.colour && seams.colour < 1.4, "chance meetings cost about 1: {seams:?}");
    assert!(0.05 < seams.density && seams.density < 0.15 && 0.0 < seams.torn && seams.used < 1.0, "{seams:?}");
    assert!(0.1 < bad.coherence && 0.1 < bad.worst && 0.1 < bad.arrangement && 0.1 < bad.lattice, "{bad:?}");
    assert!(preference(&bad) + 1.0 < preference(&good));
}

#[test]
fn a_lattice_of_copies_repeats_itself_and_a_part_alone_is_incomplete() {
    let of = weave();
    let [h, w] = of.sources()[0].domain().shape;
    let tiled = columns(&of, &map(&of, Domain::open([2 * h, 2 * w]), |[y, x]| [y % h, x % w]));
    assert!(0.5 < tiled.repeats && (tiled.scale - 1.0).abs() < 1e-9, "{tiled:?}");
    let part = columns(&of, &map(&of, Domain::open([h, w]), |[y, x]| [y % 40, x % 40]));
    assert!(tiled.completeness_2 < part.completeness_2 && tiled.unevenness + 0.5 < part.unevenness, "{part:?}");
}

#[test]
fn blur_tint_and_wrap_have_their_columns() {
    let of = weave();
    let [h, w] = of.sources()[0].domain().shape;
    let copy = picture(&of, &map(&of, Domain::open([h, w]), |p| p));
    let mut soft = copy.clone();
    for c in 0..soft.channels() {
        let from = copy.plane(c);
        for (i, v) in soft.plane_mut(c).iter_mut().enumerate().take((h * w - w - 1) as usize) {
            let four = [i, i + 1, i + w as usize, i + w as usize + 1].map(|j| u32::from(from[j]));
            *v = (four.iter().sum::<u32>() / 4) as u8;
        }
    }
    let judge = judge(&of);
    let ask = |grid: &Grid<u8, 2>| judge.columns(grid, None).unwrap();
    assert!(ask(&soft).sharpness < -0.5, "{:?}", ask(&soft));
    let tinted = copy.map(|v| v.saturating_add(40)).unwrap();
    assert!(0.2 < ask(&tinted).colour && ask(&copy).colour == 0.0);
    let flat = copy.map(|v| v / 64 + 90).unwrap();
    assert!(0.5 < ask(&flat).bland, "{:?}", ask(&flat));
    // Half a period of the weave does not close.
    let open = Grid::from_vec(Domain::periodic([h, w]), copy.channels(), copy.clone().into_vec()).unwrap();
    let cut = map(&of, Domain::periodic([h - 5, w - 5]), |p| p);
    assert!(ask(&picture(&of, &cut)).wrap > 0.2 && ask(&copy).wrap == 0.0, "{}", ask(&open).wrap);
}

#[test]
fn a_joint_on_the_wrap_is_no_tear() {
    // A wall that closes after 96 samples, of which the exemplar holds somewhat more: joints at multiples of 12 and 24.
    let wall = |[y, x]: [u32; 2]| {
        let (course, across) = (y / 12 % 8, (x + y / 12 % 2 * 12) % 96);
        let brick = 120 + (course * 37 + across / 24 * 61) % 90;
        (if y % 12 == 0 || across % 24 == 0 { 40 } else { brick }) as u8
    };
    let of = |domain: Domain<2>| Grid::from_vec(domain, 1, domain.positions().map(wall).collect()).unwrap();
    let plane = Plane::new(Role::Color, Samples::U8(of(Domain::open([120, 130]))));
    let judge = judge(&Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap());
    let torn = |shape| judge.columns(&of(Domain::periodic(shape)), None).unwrap().wrap;
    assert_eq!(torn([96, 96]), 0.0, "joints lie on both wraps");
    // A course of half its height, and narrow bricks at one place of each second course.
    let [course, narrow] = [[89, 96], [96, 103]].map(torn);
    assert!(0.8 < course && 0.3 < narrow, "{course} {narrow}");
}

#[test]
fn instructions_and_threads_change_nothing() {
    let of = weave();
    let [h, w] = of.sources()[0].domain().shape;
    let map = map(&of, Domain::open([h + 30, w]), |[y, x]| [(y + x / 30) % h, x]);
    let out = picture(&of, &map);
    let ask = |simd| Judge::new(&of, simd).unwrap().columns(&out, Some(&map)).unwrap();
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let expected = pool(1).install(|| ask(SimdLevel::Scalar));
    assert_eq!(pool(3).install(|| ask(SimdLevel::Auto)), expected);
}

#[test]
fn what_does_not_fit_is_refused() {
    let of = weave();
    let judge = judge(&of);
    let domain = of.sources()[0].domain();
    let grey = Grid::try_filled(domain, 1, 0_u8).unwrap();
    assert!(matches!(judge.columns(&grey, None), Err(Error::Channels { .. })));
    let small = Grid::try_filled(Domain::open([31, 200]), of.channels(), 0_u8).unwrap();
    assert!(matches!(judge.columns(&small, None), Err(Error::TooSmall { .. })));
    let out = Grid::try_filled(domain, of.channels(), 0_u8).unwrap();
    let other = map(&of, Domain::open([40, 40]), |p| p);
    assert!(matches!(judge.columns(&out, Some(&other)), Err(Error::Map { .. })));
}
