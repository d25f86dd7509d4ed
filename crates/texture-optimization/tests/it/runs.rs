//! Whole runs.

use selvedge_core::{
    Domain, Encoder, Event, Exemplar, Exemplars, Grid, Guidance, Guide, Observer, Plane, Render, Role, Run, SampleId,
    Samples, SourceMap,
};
use selvedge_fft_ssd::{Field, Windows, nearest};
use selvedge_testkit::from_png;
use selvedge_texture_optimization::{
    Control, Finish, Level, Optimized, Options, Plan, Search, Wanted, optimize, optimize_from,
};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

const SCALES: &[u8] = include_bytes!("../../../../fixtures/scales.png");

/// A part of the scales: small enough for searches by the definition.
fn scales(side: u32) -> Plane<2> {
    let Samples::U8(whole) = from_png(Role::Color, SCALES).unwrap().samples else { panic!("8 bits") };
    let domain = Domain::open([side, side]);
    let part = (0..whole.channels()).flat_map(|c| domain.positions().map(move |at| (c, at)));
    let part = part.map(|(c, at)| whole.get(c, at)).collect();
    Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, whole.channels(), part).unwrap()))
}

fn exemplars(plane: &Plane<2>) -> Exemplars<2> {
    Exemplars::of(&[std::slice::from_ref(plane)]).unwrap()
}

fn levels(all: &[(u32, u32)]) -> Vec<Level> {
    all.iter().map(|&(scale, size)| Level { scale, size }).collect()
}

fn bytes(result: &Optimized, plane: &Plane<2>) -> Vec<u8> {
    let Samples::U8(out) = result.render(&[plane]).unwrap().samples else { panic!("8 bits") };
    out.into_vec()
}

#[test]
fn the_robust_energy_never_rises_where_search_and_average_agree() {
    let plane = scales(26);
    let exemplars = exemplars(&plane);
    for (seed, robust, gradient) in [(1, 0.8, 0.0), (2, 0.8, 10.0), (3, 2.0, 0.0), (4, 1.5, 0.0)] {
        // Differences take three times as long.
        let schedule = levels(if gradient == 0.0 { &[(2, 8), (1, 12), (1, 8)] } else { &[(2, 8), (1, 8)] });
        let options = Options { schedule, robust, gradient, search: Search::Reference, ..Options::paper() };
        let output = Domain { shape: [29, 33], periodic: [seed % 2 == 0, false] };
        let woven = optimize(&exemplars, output, &options, &Run::seeded(seed)).unwrap();
        for level in &woven.stats.levels {
            assert!(level.settled, "{level:?}");
            assert_eq!(level.rises, 0, "{level:?}");
            assert!(level.robust.windows(2).all(|e| e[1] <= e[0] * (1.0 + 1e-12)), "{level:?}");
        }
        let falls = woven.stats.levels.iter().map(|l| l.robust.len()).sum::<usize>();
        assert!(5 < falls, "a run that ends at once shows nothing: {falls}");
    }
}

#[test]
fn threads_and_instructions_change_nothing() {
    let plane = scales(40);
    let exemplars = exemplars(&plane);
    let output = Domain { shape: [50, 61], periodic: [false, true] };
    let of = |threads: usize, simd, spread: f64| {
        let options = Options { iterations: 4, spread, ..Options::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let run = Run { simd, ..Run::seeded(5) };
        let woven = pool.install(|| optimize(&exemplars, output, &options, &run)).unwrap();
        (bytes(&woven.result, &plane), woven.result, woven.stats)
    };
    for spread in [0.0, 0.2] {
        let one = of(1, selvedge_core::SimdLevel::Auto, spread);
        assert_eq!(one.2.levels.len(), 6);
        for (threads, simd) in [(2, selvedge_core::SimdLevel::Avx2), (3, selvedge_core::SimdLevel::Scalar)] {
            assert!(of(threads, simd, spread) == one, "{threads} threads, spread {spread}");
        }
    }
}

#[test]
fn a_copy_of_the_exemplar_stays_what_it_is() {
    let plane = scales(40);
    let exemplars = exemplars(&plane);
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([24, 30])).unwrap();
    for at in map.domain().positions() {
        map.ids.set(0, at, exemplars.table().id(0, [at[0] + 3, at[1] + 7]));
    }
    let options = Options { schedule: levels(&[(1, 16), (1, 8)]), ..Options::paper() };
    let woven = optimize_from(&exemplars, &map, &Control::default(), &options, &Run::seeded(0)).unwrap();
    assert_eq!(bytes(&woven.result, &plane), bytes(&Optimized::Map(map), &plane));
    assert_eq!(woven.stats.energy(), Some(0.0));
}

#[test]
fn odd_samples_at_the_edges_are_mended() {
    let plane = scales(40);
    let exemplars = exemplars(&plane);
    let copy = |at: [u32; 2]| exemplars.table().id(0, at);
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([29, 31])).unwrap();
    for at in map.domain().positions() {
        map.ids.set(0, at, copy(at));
    }
    let clean = bytes(&Optimized::Map(map.clone()), &plane);
    // The lightest sample, where the picture is darkest, in all corners.
    let light = |id: u32| {
        let (_, at) = exemplars.locate(SampleId::new(id)).unwrap();
        (0..exemplars.channels()).map(|c| u32::from(exemplars.sources()[0].features.get(c, at))).sum::<u32>()
    };
    let lightest = (0..exemplars.table().len()).max_by_key(|&id| light(id)).unwrap();
    for at in [[0, 0], [0, 30], [28, 0], [28, 30]] {
        map.ids.set(0, at, SampleId::new(lightest));
    }
    let options = Options { schedule: levels(&[(1, 8)]), ..Options::paper() };
    let woven = optimize_from(&exemplars, &map, &Control::default(), &options, &Run::seeded(0)).unwrap();
    assert_ne!(bytes(&Optimized::Map(map), &plane), clean);
    assert_eq!(bytes(&woven.result, &plane), clean);
}

/// How uneven the use of an exemplar is: the mean deviation of how often each 8 by 8 samples of it show, in means.
fn unevenness(exemplars: &Exemplars<2>, map: &SourceMap<2>, side: u32) -> f64 {
    let mut uses = vec![0.0; (side / 8 * (side / 8)) as usize];
    for at in map.domain().positions() {
        let (_, [y, x]) = exemplars.locate(map.ids.get(0, at)).unwrap();
        uses[(y / 8 * (side / 8) + x / 8) as usize] += 1.0;
    }
    let mean = map.domain().len() as f64 / uses.len() as f64;
    uses.iter().map(|n: &f64| (n / mean - 1.0).abs()).sum::<f64>() / uses.len() as f64
}

#[test]
fn a_spread_uses_the_exemplar_more_evenly_and_none_changes_nothing() {
    let plane = scales(64);
    let exemplars = exemplars(&plane);
    let output = Domain { shape: [90, 104], periodic: [true, false] };
    for (search, complete) in [(Search::Coherent, None), (Search::Exact, None), (Search::Coherent, Some(0.5))] {
        let of = |spread: f64| {
            let options = Options { iterations: 3, search, complete, spread, ..Options::default() };
            optimize(&exemplars, output, &options, &Run::seeded(5)).unwrap()
        };
        let uneven = |spread: f64| {
            let Optimized::Map(map) = of(spread).result else { panic!("its finish is a map") };
            unevenness(&exemplars, &map, 64)
        };
        let (plain, some, more) = (uneven(0.0), uneven(0.3), uneven(3.0));
        assert!(some < plain && more < 0.8 * plain, "{search:?} {complete:?}: {plain}, {some}, {more}");
        // A spread that rounds to nothing.
        assert!(of(0.0004).result == of(0.0).result);
    }
    let wrong = Options { spread: 10.5, ..Options::default() };
    assert_eq!(wrong.validate().unwrap_err().to_string(), "spread is 10.5, which is out of range");
}

/// Cancels after so many looks.
struct After(AtomicU32, u32);

impl Observer<2> for After {
    fn event(&self, _: &Event<'_, 2>) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.1 <= self.0.load(Ordering::Relaxed)
    }
}

#[test]
fn a_run_that_is_cancelled_answers_with_what_there_is() {
    let plane = scales(40);
    let exemplars = exemplars(&plane);
    let output = Domain::open([50, 61]);
    for events in [1, 6, 1000] {
        let observer = After(AtomicU32::new(0), events);
        let run = Run { observer: &observer, ..Run::seeded(5) };
        let woven = optimize(&exemplars, output, &Options { iterations: 10, ..Options::paper() }, &run).unwrap();
        assert_eq!(woven.complete, events == 1000);
        assert_eq!(woven.result.domain(), output);
        assert_eq!(matches!(woven.result, Optimized::Map(_)), !woven.complete);
        assert!(woven.result.as_map().is_none_or(|map| map.holes() == 0));
    }
    // What would have become a map is one, however far it came.
    for events in 1..12 {
        let observer = After(AtomicU32::new(0), events);
        let run = Run { observer: &observer, ..Run::seeded(5) };
        let woven = optimize(&exemplars, output, &Options::default(), &run).unwrap();
        assert!(!woven.complete && woven.result.as_map().is_some(), "{events}");
    }
}

#[test]
fn a_plan_names_the_levels_that_fit() {
    let plane = scales(30);
    let exemplars = exemplars(&plane);
    let plan = Plan::new(&exemplars, Domain::open([64, 64]), &Options::paper(), &Run::seeded(0)).unwrap();
    assert_eq!(plan.levels(), levels(&[(2, 8), (1, 16), (1, 8)]));
    assert_eq!(plan.left_out(), levels(&[(4, 8), (2, 16), (1, 32)]));
}

/// The part of the exemplar's neighborhoods, a step apart, of which an output has nothing near: by mean squared
/// distance.
fn lacking(plane: &Plane<2>, result: &Optimized) -> f64 {
    let (Samples::U8(there), Samples::U8(here)) = (result.render(&[plane]).unwrap().samples, &plane.samples) else {
        panic!("8 bits")
    };
    let windows = Windows { side: 8, step: 4 };
    let simd = selvedge_core::SimdLevel::Auto;
    let found = nearest(Field::new(here), &[Field::new(&there)], &[1; 3], windows, simd).unwrap();
    let errors: Vec<f64> = found.samples().iter().flatten().map(|n| n.error as f64 / 192.0).collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn completeness_brings_in_what_an_output_lacks_and_the_finish_is_made_of_samples() {
    let plane = scales(48);
    let exemplars = exemplars(&plane);
    let output = Domain { shape: [75, 66], periodic: [false, true] };
    let of = |complete, finish| {
        let options = Options { complete, finish, iterations: 4, ..Options::default() };
        optimize(&exemplars, output, &options, &Run::seeded(2)).unwrap()
    };
    let [plain, complete] = [None, Some(0.1)].map(|complete| of(complete, Finish::Average));
    let [without, with] = [&plain, &complete].map(|woven| lacking(&plane, &woven.result));
    assert!(with < 0.9 * without, "{with} of {without}");
    let sharp = of(Some(0.1), Finish::Coherent);
    let map = sharp.result.as_map().expect("samples that continue each other are a map");
    assert_eq!(map.holes(), 0);
    // Averages have less contrast than what they are averages of.
    let contrast = |result: &Optimized| {
        let bytes = bytes(result, &plane);
        bytes.windows(2).map(|p| f64::from(p[0].abs_diff(p[1]))).sum::<f64>() / bytes.len() as f64
    };
    let (before, after) = (contrast(&complete.result), contrast(&sharp.result));
    assert!(before < after, "{after} of {before}");
    // Most samples go on with their neighbour's patch.
    let seams = map.domain().positions().filter(|&at| map.is_seam(at, 1)).count();
    assert!(seams * 5 < map.domain().len(), "{seams} seams");
}

#[test]
fn a_copy_of_the_exemplar_is_finished_as_itself() {
    let plane = scales(40);
    let exemplars = exemplars(&plane);
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([24, 30])).unwrap();
    for at in map.domain().positions() {
        map.ids.set(0, at, exemplars.table().id(0, [at[0] + 3, at[1] + 7]));
    }
    let options = Options { schedule: levels(&[(1, 8)]), complete: None, ..Options::default() };
    let woven = optimize_from(&exemplars, &map, &Control::default(), &options, &Run::seeded(0)).unwrap();
    assert_eq!(woven.result, Optimized::Map(map));
}

#[test]
fn wished_colours_come_where_they_are_wanted_and_fixed_samples_stay() {
    let plane = scales(48);
    let exemplars = exemplars(&plane);
    let output = Domain::open([64, 64]);
    let run = Run::seeded(4);
    let of_exemplar = |at: [u32; 2]| exemplars.table().id(0, [at[0] % 48, at[1] % 48]);
    let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
    output.positions().for_each(|at| map.ids.set(0, at, of_exemplar(at)));
    // Light in the middle, dark nowhere.
    let inside = |at: [u32; 2]| at.iter().all(|p| (24..40).contains(p));
    let features = Grid::try_filled(output, exemplars.channels(), 250).unwrap();
    let weight = |lambda: f32| {
        let of = output.positions().map(|at| if inside(at) { lambda } else { 0.0 }).collect();
        Grid::from_vec(output, 1, of).unwrap()
    };
    let fixed = Grid::from_vec(output, 1, output.positions().map(|at| at[0] < 9).collect()).unwrap();
    let light = |lambda: f32, finish| {
        let wanted = Some(Wanted { features: features.clone(), weight: weight(lambda) });
        let control = Control { wanted, fixed: Some(fixed.clone()), ..Control::default() };
        let options = Options { finish, iterations: 4, ..Options::default() };
        let woven = optimize_from(&exemplars, &map, &control, &options, &run).unwrap();
        let (shown, before) = (bytes(&woven.result, &plane), bytes(&Optimized::Map(map.clone()), &plane));
        for (i, at) in output.positions().enumerate().filter(|(_, at)| at[0] < 9) {
            (0..3).for_each(|c| assert_eq!(shown[c * output.len() + i], before[c * output.len() + i], "{at:?} {c}"));
        }
        let all: Vec<u32> = (0..output.len())
            .filter(|&i| inside(output.position(i)))
            .map(|i| (0..3).map(|c| u32::from(shown[c * output.len() + i])).sum())
            .collect();
        f64::from(all.iter().sum::<u32>()) / all.len() as f64 / 3.0
    };
    for finish in [Finish::Average, Finish::Coherent] {
        let [without, little, much] = [0.0, 0.3, 3.0].map(|lambda| light(lambda, finish));
        // The lightest of these scales is not far from what a little brings.
        assert!(without + 20.0 < little && without + 20.0 < much, "{without} {little} {much}");
    }
}

#[test]
fn a_guide_says_from_where_and_one_of_no_weight_says_nothing() {
    let plane = scales(48);
    let exemplars = exemplars(&plane);
    let output = Domain { shape: [60, 64], periodic: [true, false] };
    // The exemplar's left and right, asked for above and below.
    let map = Domain::open([48, 48]).positions().map(|at| if at[1] < 24 { 40 } else { 200 }).collect();
    let map = Grid::from_vec(Domain::open([48, 48]), 1, map).unwrap();
    let target = output.positions().map(|at| if at[0] < 30 { 40 } else { 200 }).collect();
    let guide = Guide::new(&exemplars, &[map], Grid::from_vec(output, 1, target).unwrap()).unwrap();
    let of = |guidance, finish| {
        let options = Options { finish, iterations: 3, ..Options::default() };
        let plan = Plan::new(&exemplars, output, &options, &Run::seeded(3)).unwrap();
        plan.weave(None, &Control { guidance, ..Control::default() }, &Run::seeded(3)).unwrap()
    };
    let weighing = |weight| Some(Guidance { guide: guide.clone(), weight });
    let plain = of(None, Finish::Coherent);
    assert!(of(weighing(0.0), Finish::Coherent).result == plain.result);
    let follows = |result: &Optimized| {
        let map = result.as_map().unwrap();
        let of = |at: &[u32; 2]| {
            let (_, from) = exemplars.locate(map.ids.get(0, *at)).unwrap();
            (from[1] < 24) == (at[0] < 30)
        };
        output.positions().filter(of).count() as f64 / output.len() as f64
    };
    let (without, with) = (follows(&plain.result), follows(&of(weighing(1.0), Finish::Coherent).result));
    assert!(without < 0.7 && 0.9 < with, "{without} {with}");
    let averaged = of(weighing(1.0), Finish::Average);
    assert_ne!(bytes(&averaged.result, &plane), bytes(&of(None, Finish::Average).result, &plane));
}

#[test]
fn what_a_mask_hides_changes_nothing() {
    let plane = scales(44);
    let Samples::U8(shown) = &plane.samples else { panic!("8 bits") };
    let domain = plane.domain();
    let inside = |[y, x]: [u32; 2]| !(y % 11 == 3 && x % 13 == 5);
    let mask = Grid::from_vec(domain, 1, domain.positions().map(inside).collect()).unwrap();
    let of = |hidden: u8, seed| {
        let mut features = shown.clone();
        for at in domain.positions().filter(|&at| !inside(at)) {
            (0..3).for_each(|c| features.set(c, at, hidden));
        }
        let plane = Plane::new(Role::Color, Samples::U8(features));
        let planes = std::slice::from_ref(&plane);
        let encoder = Encoder::fit(&[planes]).unwrap();
        let exemplars = Exemplars::new(&encoder, &[Exemplar::new(planes).masked(Some(&mask))]).unwrap();
        let options = Options { iterations: 3, schedule: levels(&[(2, 8), (1, 8)]), ..Options::default() };
        let woven = optimize(&exemplars, Domain::open([40, 44]), &options, &Run::seeded(seed)).unwrap();
        (woven.result, woven.stats)
    };
    (0..4).for_each(|seed| assert!(of(0, seed) == of(255, seed), "{seed}"));
}

/// Steps done, of how many, whether an energy was told, and the map that was shown.
type Step = (u64, u64, bool, Option<SourceMap<2>>);

struct Told(Mutex<Vec<Step>>);

impl Observer<2> for Told {
    fn event(&self, event: &Event<'_, 2>) {
        let map = event.so_far.map(|so_far| so_far.as_map().unwrap().clone());
        self.0.lock().unwrap().push((event.done, event.of, event.energy.is_some(), map));
    }
}

#[test]
fn every_iteration_is_progress_and_the_last_one_is_all_of_it() {
    let plane = scales(40);
    let told = Told(Mutex::default());
    let run = Run { observer: &told, ..Run::seeded(5) };
    let options = Options { iterations: 3, search: Search::Exact, ..Options::default() };
    let woven = optimize(&exemplars(&plane), Domain::open([50, 61]), &options, &run).unwrap();
    assert!(woven.stats.levels.iter().all(|level| !level.settled), "each level has all of its iterations");
    let told = told.0.into_inner().unwrap();
    // Iterations at 1/4, 1/2 twice, 1 thrice.
    let work: u64 = [1, 16, 16, 256, 256, 256].map(|each| 3 * each).iter().sum();
    let of = |at: usize| (told[at].0, told[at].1, told[at].2);
    assert_eq!((of(0), of(told.len() - 1)), ((1, work, true), (work, work, true)));
    // Each level ends with a map of the output's size without holes.
    for (number, (.., map)) in told.iter().enumerate() {
        assert_eq!(
            map.as_ref().map(|map| (map.domain().shape, map.holes())),
            (number % 3 == 2).then_some(([50, 61], 0))
        );
    }
    // As the last of all is: of the mean distance that was told.
    let distances = woven.stats.distances.as_ref().unwrap();
    let mean = distances.samples().iter().map(|&d| f64::from(d)).sum::<f64>() / distances.samples().len() as f64;
    assert!((mean / woven.stats.energy().unwrap() - 1.0).abs() < 1e-5);
    assert_eq!(distances.domain().shape, [22, 28]);
    assert_eq!(told.len(), woven.stats.iterations());
    assert!(told.windows(2).all(|two| two[0].0 < two[1].0));
}
