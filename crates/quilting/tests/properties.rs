//! What quilting promises, on generated textures and through the public interface alone.

use selvedge_core::{
    Domain, Encoder, Event, Exemplars, Grid, Limits, Observer, Plane, Render, Run, Samples, Seed, SimdLevel, Transform,
};
use selvedge_quilting::{Continuation, Error, Options, Stage, quilt};
use selvedge_testkit::{exemplars, simple};

fn bytes(plane: &Plane<2>) -> &Grid<u8, 2> {
    match &plane.samples {
        Samples::U8(grid) => grid,
        other => panic!("{} samples", other.depth().name()),
    }
}

fn weave(planes: &[&Plane<2>], output: Domain<2>, options: &Options, seed: u64) -> Plane<2> {
    let each: Vec<&[Plane<2>]> = planes.iter().map(|p| std::slice::from_ref(*p)).collect();
    let woven = quilt(&Exemplars::of(&each).unwrap(), output, options, &Run::seeded(seed)).unwrap();
    assert!(woven.complete);
    assert_eq!(woven.result.holes(), 0);
    woven.result.render(planes).unwrap()
}

/// How much the samples change from each column to the next, the last one's next being the first.
fn column_steps(picture: &Grid<u8, 2>) -> Vec<u64> {
    let [h, w] = picture.domain().shape;
    let step = |y: u32, x: u32, c: usize| u64::from(picture.get(c, [y, x]).abs_diff(picture.get(c, [y, (x + 1) % w])));
    let places = |_| (0..picture.channels()).flat_map(|c| (0..h).map(move |y| (y, c)));
    (0..w).map(|x| places(x).map(|(y, c)| step(y, x, c)).sum()).collect()
}

/// The share of interior column steps that are larger than the one across the wrap.
fn rank_of_the_wrap(picture: &Grid<u8, 2>) -> f64 {
    let steps = column_steps(picture);
    let (wrap, interior) = steps.split_last().unwrap();
    interior.iter().filter(|&s| wrap < s).count() as f64 / interior.len() as f64
}

#[test]
fn tiling_outputs_have_no_seam_of_their_own() {
    for exemplar in [exemplars::cobbles(), simple::spots(96, 96, 9, 4)] {
        let options = Options { block: Some(30), ..Options::default() };
        let mean_rank = |output: Domain<2>| {
            let ranks = (0..6).map(|seed| rank_of_the_wrap(bytes(&weave(&[&exemplar], output, &options, seed))));
            ranks.sum::<f64>() / 6.0
        };
        // Were the wrap like any other column, its mean rank would be 0.5 with a deviation of 0.12. Open outputs,
        // whose ends never met, show that the test can fail.
        let (tiled, open) = (mean_rank(Domain::periodic([64, 140])), mean_rank(Domain::open([64, 140])));
        assert!(0.15 < tiled, "the wrap is among the worst columns: {tiled}");
        assert!(open < 0.05, "open ends meet by chance: {open}");
    }
}

#[test]
fn the_map_is_the_same_on_any_number_of_threads_and_with_any_instructions() {
    let exemplar = exemplars::weave();
    let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)]).unwrap();
    let options = Options { block: Some(24), ..Options::default() };
    let output = Domain { shape: [70, 90], periodic: [false, true] };
    let on = |threads: usize, simd: SimdLevel| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let run = Run { simd, ..Run::seeded(5) };
        pool.install(|| quilt(&exemplars, output, &options, &run).unwrap().result)
    };
    let first = on(1, SimdLevel::Auto);
    for threads in [1, 2, 3, 8] {
        assert_eq!(on(threads, SimdLevel::Auto), first, "{threads} threads");
    }
    for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512] {
        assert_eq!(on(2, simd), first, "{simd:?}");
    }
    let other = quilt(&exemplars, output, &options, &Run::seeded(6)).unwrap().result;
    assert_ne!(other, first, "another seed gives another map");
}

#[test]
fn masked_samples_are_never_used() {
    let exemplar = simple::spots(64, 64, 7, 1);
    let domain = exemplar.domain();
    let mut mask = Grid::try_filled(domain, 1, true).unwrap();
    for at in domain.positions().filter(|[y, x]| (28..33).contains(y) || (x + y) % 61 == 60) {
        mask.set(0, at, false);
    }
    let planes = [std::slice::from_ref(&exemplar)];
    let encoder = Encoder::fit(&planes).unwrap();
    let exemplars = Exemplars::masked(&encoder, &planes, &[Some(mask.clone())], &[Transform::IDENTITY]).unwrap();
    let options = Options { block: Some(12), ..Options::default() };
    let map = quilt(&exemplars, Domain::periodic([50, 50]), &options, &Run::seeded(2)).unwrap().result;
    assert!(map.domain().positions().all(|at| mask.get(0, map.locate(at).unwrap().1)));

    let error = quilt(&exemplars, Domain::open([50, 50]), &Options { block: Some(40), ..options }, &Run::seeded(2));
    assert_eq!(error.unwrap_err(), Error::Masked { height: 40, width: 40 });
}

#[test]
fn every_exemplar_is_used_and_small_ones_are_passed_over() {
    let (a, b, small) = (simple::spots(50, 40, 8, 1), simple::spots(40, 60, 8, 2), simple::spots(9, 70, 8, 3));
    let planes = [&a, &b, &small].map(std::slice::from_ref);
    let exemplars = Exemplars::of(&planes).unwrap();
    let options = Options { block: Some(16), ..Options::default() };
    let map = quilt(&exemplars, Domain::open([120, 120]), &options, &Run::seeded(3)).unwrap().result;
    let mut used = [0; 3];
    map.domain().positions().for_each(|at| used[map.locate(at).unwrap().0] += 1);
    assert!(0 < used[0] && 0 < used[1]);
    assert_eq!(used[2], 0);
}

#[test]
fn odd_exemplars_and_outputs_are_filled() {
    for [w, h] in [[1, 1], [1, 40], [40, 1], [2, 3], [33, 7]] {
        for exemplar in [simple::constant(w, h, 77), simple::noise(w, h, 1)] {
            for output in
                [Domain::open([1, 1]), Domain::periodic([1, 1]), Domain::periodic([13, 29]), Domain::open([50, 3])]
            {
                weave(&[&exemplar], output, &Options::default(), 1);
                weave(&[&exemplar], output, &Options { stage: Stage::Random, ..Options::default() }, 1);
            }
        }
    }
}

#[test]
fn each_stage_of_figure_2_has_less_visible_seams() {
    let exemplar = exemplars::scales();
    let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)]).unwrap();
    let features = &exemplars.sources()[0].features;
    // The mean step over seams, in grey levels: what the eye sees of them.
    let visible = |stage: Stage| {
        let options = Options { block: Some(32), stage, continuation: Continuation::Allow, ..Options::default() };
        let map = quilt(&exemplars, Domain::open([180, 180]), &options, &Run::seeded(1)).unwrap().result;
        let (mut sum, mut n) = (0_u64, 0_u64);
        for at in map.domain().positions().filter(|&at| map.is_seam(at, 1)) {
            let ends = [at, map.domain().next(at, 1).unwrap()].map(|p| map.locate(p).unwrap().1);
            sum += (0..3).map(|c| u64::from(features.get(c, ends[0]).abs_diff(features.get(c, ends[1])))).sum::<u64>();
            n += 3;
        }
        sum as f64 / n as f64
    };
    let (random, overlap, cut) = (visible(Stage::Random), visible(Stage::Overlap), visible(Stage::Cut));
    assert!(overlap < random && cut < overlap, "{random} {overlap} {cut}");
}

#[test]
fn wrong_options_are_errors_with_numbers() {
    let exemplar = simple::noise(20, 10, 1);
    let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)]).unwrap();
    let fail = |output, options: Options| quilt(&exemplars, output, &options, &Run::seeded(0)).unwrap_err();
    let d = Options::default();
    let output = Domain::open([8, 8]);
    let large = fail(output, Options { block: Some(11), ..d });
    assert_eq!(
        large.to_string(),
        "20x10 px is smaller than the 11 px block; use a block of at most 10 or a larger exemplar"
    );
    assert_eq!(fail(output, Options { block: Some(0), ..d }), Error::Block);
    let overlap = Error::Overlap { overlap: 6, block: 10, limit: 5 };
    assert_eq!(fail(output, Options { block: Some(10), overlap: Some(6), ..d }), overlap);
    assert!(matches!(fail(output, Options { tolerance: f64::NAN, ..d }), Error::Tolerance { .. }));
    assert_eq!(fail(Domain::open([0, 8]), d), Error::EmptyOutput { width: 8, height: 0 });
}

/// Cancels after some events.
struct Impatient(std::sync::atomic::AtomicU32);

impl Observer<2> for Impatient {
    fn event(&self, event: &Event<'_, 2>) {
        assert!(0 < event.done && event.done <= event.of);
        self.0.fetch_sub(1, std::sync::atomic::Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.0.load(std::sync::atomic::Ordering::Relaxed) == 0
    }
}

#[test]
fn a_cancelled_run_gives_what_it_has() {
    let exemplar = simple::noise(40, 40, 1);
    let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)]).unwrap();
    let observer = Impatient(3.into());
    let run = Run { seed: Seed(1), limits: Limits::default(), observer: &observer, simd: SimdLevel::Auto };
    let options = Options { block: Some(10), ..Options::default() };
    let woven = quilt(&exemplars, Domain::open([100, 100]), &options, &run).unwrap();
    assert!(!woven.complete);
    assert_eq!(woven.stats.blocks, 3);
    assert_eq!(woven.result.holes(), 100 * 100 - 10 * 10 - 2 * 10 * 9);
}

#[test]
fn spread_shows_more_of_the_exemplar() {
    let exemplar = exemplars::cobbles();
    let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)]).unwrap();
    // Samples that appear at least once, over three seeds.
    let used = |spread: f64| {
        let options = Options { block: Some(40), spread, ..Options::default() };
        let of_seed = |seed| {
            let map = quilt(&exemplars, Domain::open([300, 300]), &options, &Run::seeded(seed)).unwrap().result;
            let mut used = vec![false; exemplar.domain().len()];
            map.ids.plane(0).iter().for_each(|id| used[id.get() as usize] = true);
            used.iter().filter(|&&u| u).count()
        };
        (0..3).map(of_seed).sum::<usize>()
    };
    let (spread, literal) = (used(0.3), used(0.0));
    assert!(literal * 21 < spread * 20, "{literal} {spread}: a twentieth more at least");
}
