//! Coarse to fine: which levels there are, what comes of them, and what is shown meanwhile.

use std::sync::Mutex;

use selvedge_core::{
    Domain, Event, Exemplars, Grid, Guide, Observer, Patch, Plane, Role, Run, Samples, Seed, Source, SourceMap, Window,
};

use crate::agreement::{Term, of_sample};
use crate::edge_tests::of_one;
use crate::tests::{Case, case};
use crate::{Constraint, Options, levels, pieces};

/// The same with as many levels as there may be: nothing but the labelling it begins with is another.
#[test]
fn levels_end_with_whole_outputs_of_no_higher_energy() {
    let (mut lower, mut several) = (0, 0);
    for seed in 0..40 {
        let mut case = case(seed);
        // Small enough for such small cases.
        case.options.neighborhood = 0;
        case.constraints.iter_mut().for_each(|c| c.ratio = 1);
        let (_, one) = case.weave(true);
        case.options.levels = None;
        several += levels::below(&case.exemplars, &case.constraints, &case.options).unwrap().len();
        let (map, stats) = case.weave(true);
        assert_eq!(map.holes(), 0);
        assert!(stats.energy.windows(2).all(|pair| pair[1] < pair[0]), "{seed}: {:?}", stats.energy);
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let own = |p| i64::from(of_sample(&terms, &case.exemplars, p, map.ids.get(0, p)));
        assert_eq!(stats.model.agreement, map.domain().positions().map(own).sum::<i64>());
        lower += u32::from(stats.model.sum() <= one.model.sum());
        // In the counts as well.
        for threads in [1, 2, 3].into_iter().filter(|_| seed % 2 == 0) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (same, counts) = pool.install(|| case.weave(true));
            assert_eq!(same, map, "{seed} {threads}");
            assert_eq!(counts, stats, "{seed} {threads}");
        }
    }
    assert!(20 <= several && 20 <= lower, "{several} levels, {lower} of 40 no higher");
}

/// Large enough for several labels of a place to be tried together.
#[test]
fn labels_of_a_place_tried_beside_each_other_end_as_if_one_after_the_other() {
    let mut rng = Seed(5).rng();
    let (source, output) = (Domain::open([150, 140]), Domain::open([140, 150]));
    let mut noise = |domain: Domain<2>| {
        let blocks: Vec<u8> = (0..2000).map(|_| rng.below(256) as u8).collect();
        let of = |[y, x]: [u32; 2]| blocks[(y / 4 * 41 + x / 4) as usize % 2000];
        Grid::from_vec(domain, 1, domain.positions().map(of).collect()).unwrap()
    };
    let exemplars = of_one(noise(source));
    let guide = Guide::new(&exemplars, &[noise(source)], noise(output)).unwrap();
    let constraints = [Constraint::new(guide)];
    let options = Options { neighborhood: 1, levels: Some(2), tolerance: Some(60.0), ..Options::paper() };
    let woven = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| crate::analogy(&exemplars, &constraints, &options, &Run::seeded(0))).unwrap()
    };
    let one = woven(1);
    assert!(20 < one.stats.searches && 100 < one.stats.expansions, "{:?}", one.stats.searches);
    for threads in [2, 3] {
        let several = woven(threads);
        assert!(several.result == one.result && several.stats == one.stats, "{threads}");
    }
}

#[test]
fn taps_are_apart_by_the_nearest_number_of_samples_of_a_level() {
    let domain = Domain::open([96, 96]);
    let flat = |domain| Grid::try_filled(domain, 1, 7).unwrap();
    let exemplars = of_one(flat(domain));
    let ratios = |ratios: &[u32], neighborhood, levels| {
        let guide = Guide::new(&exemplars, &[flat(domain)], flat(domain)).unwrap();
        let of = |&ratio: &u32| Constraint { guide: guide.clone(), ratio, weight: 1.0 };
        let constraints: Vec<_> = ratios.iter().map(of).collect();
        let options = Options { neighborhood, levels, ..Options::paper() };
        let below = levels::below(&exemplars, &constraints, &options).unwrap();
        below.iter().map(|l| l.constraints.iter().map(|c| c.ratio).collect()).collect::<Vec<Vec<u32>>>()
    };
    assert_eq!(ratios(&[8, 1], 1, None), [[4, 1], [2, 1]]);
    assert_eq!(ratios(&[2], 1, Some(4)), [[1], [1], [1]]);
    assert_eq!(ratios(&[10], 1, None), [[5], [3]]);
    assert_eq!(ratios(&[3, 5, 7], 1, None), [[2, 3, 4], [1, 1, 2]]);
    // Two neighborhoods of 17 samples fit into 48, not into 24.
    assert_eq!(ratios(&[1], 8, None), [[1]]);
    assert_eq!(ratios(&[1], 1, Some(1)), Vec::<Vec<u32>>::new());
}

/// Each piece lies in its window, also where it goes around, and windows are no larger than that takes.
#[test]
fn pieces_that_go_around_have_windows_that_do() {
    let mut around = 0;
    for seed in 0..60 {
        let mut rng = Seed(seed).rng();
        let output = Domain { shape: [30, 36], periodic: [seed % 2 == 0, seed % 3 == 0] };
        let features = Grid::try_filled(Domain::open([70, 80]), 1, 0).unwrap();
        let exemplars = of_one(features);
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        // Boxes of labels, shifted so that some lie across the border.
        let by = [rng.below(30), rng.below(36)];
        for at in output.positions() {
            let turned = [0, 1].map(|a| if output.periodic[a] { (at[a] + by[a]) % output.shape[a] } else { at[a] });
            let label = [turned[0] / 6, turned[1] / 9].map(|n| 5 * n);
            let from = [0, 1].map(|a| turned[a] + label[a]);
            map.ids.plane_mut(0)[output.index(at)] = exemplars.table().id(0, from);
        }
        let pieces = pieces::of(&map).unwrap();
        assert_eq!(pieces.iter().map(|piece| piece.samples).sum::<usize>(), output.len());
        for piece in &pieces {
            let shown = piece.patch.samples(&exemplars, &piece.window);
            let same = piece.window.places(output).zip(shown);
            let same = same.filter(|(place, id)| place.is_some_and(|place| map.ids.plane(0)[place] == *id)).count();
            let wraps = (0..2).any(|a| piece.window.start[a] < 0 || (output.shape[a] as i32) < piece.window.end(a));
            around += u32::from(wraps);
            assert!(piece.samples <= same, "{seed}: {same} of {} samples", piece.samples);
            assert!(piece.window.len() <= (6 + 8) * (9 + 8), "{seed}: {:?}", piece.window);
        }
    }
    assert!(100 < around, "{around} go around");
}

/// None of a group may change what another of it looks at, and there are few groups.
#[test]
fn groups_hold_pieces_that_do_not_touch() {
    let mut several = 0;
    for seed in 0..200 {
        let mut rng = Seed(seed).rng();
        let output = Domain { shape: [40, 50], periodic: [seed % 2 == 0, seed % 3 == 0] };
        let patch = Patch { source: 0, offset: [0, 0] };
        let pieces: Vec<pieces::Piece> = (0..40)
            .map(|_| {
                let shape = [1 + rng.below(6), 1 + rng.below(9)];
                let start = [rng.below(40 - shape[0]) as i32, rng.below(50 - shape[1]) as i32];
                pieces::Piece { patch, window: Window { start, shape }, samples: 1 }
            })
            .collect();
        let groups = pieces::groups(&pieces, output, 40 * 50).unwrap();
        for (&first, &second) in groups.iter().flat_map(|g| g.iter().flat_map(|i| g.iter().map(move |j| (i, j)))) {
            let seen = pieces[first].window.grown(output, [1; 2], [1; 2]);
            assert!(first == second || !seen.meets(&pieces[second].window, output), "{seed}: {first} and {second}");
        }
        let mut all: Vec<usize> = groups.iter().flatten().copied().collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..pieces.len()), "{seed}: each once");
        for group in groups.iter().filter(|group| 1 < group.len()) {
            assert!(group.iter().map(|&p| pieces[p].window.len()).sum::<usize>() <= 1000);
            assert!(group.iter().all(|&p| pieces[p].window.len() <= 2000 / 32 && pieces[p].window.shape[0] <= 5));
        }
        several += groups.iter().filter(|group| 1 < group.len()).count();
    }
    assert!(500 < several, "{several} groups of several");
    // A chain of neighbours takes two, and what all lie over as many as there are.
    let output = Domain::open([40, 900]);
    let piece = |at: i32| pieces::Piece {
        patch: Patch { source: 0, offset: [0, 0] },
        window: Window { start: [0, at], shape: [4, 9] },
        samples: 1,
    };
    let of = |apart: i32| {
        let pieces: Vec<_> = (0..80).map(|i| piece(i * apart)).collect();
        pieces::groups(&pieces, output, 1 << 20).unwrap().len()
    };
    assert_eq!((of(9), of(0)), (2, 80));
}

/// What was told: a stage, an energy, a map, and what it shows.
type Told = (&'static str, Option<i64>, SourceMap<2>, [Plane<2>; 2]);

struct Watching<'a>(&'a Case, Mutex<Vec<Told>>);

impl Observer<2> for Watching<'_> {
    fn event(&self, event: &Event<'_, 2>) {
        let Some(so_far) = event.so_far else { return };
        let case = self.0;
        let guide = &case.constraints[0].guide;
        let planes = |e: &Exemplars<2>| {
            let of = |s: &std::sync::Arc<Source<2>>| Plane::new(Role::Scalar, Samples::U8(s.features.clone()));
            e.sources().iter().map(of).collect::<Vec<_>>()
        };
        let shown = [&case.exemplars, guide.exemplars()].map(|e| {
            let planes = planes(e);
            so_far.render(&planes.iter().collect::<Vec<_>>()).unwrap()
        });
        let map = so_far.as_map().unwrap();
        let map = SourceMap { ids: map.ids.clone(), table: map.table.clone() };
        self.1.lock().unwrap().push((event.stage, event.energy, map, shown));
    }
}

/// `O` and `O_Q`, at full size before each level and after each label.
#[test]
fn what_there_is_so_far_can_be_shown_at_any_time() {
    let mut several = 0;
    for seed in 0..24 {
        let mut case = case(seed);
        case.options = Options { neighborhood: 0, levels: None, ..case.options };
        case.constraints.iter_mut().for_each(|c| c.ratio = 1);
        let below = levels::below(&case.exemplars, &case.constraints, &case.options).unwrap().len();
        let watching = Watching(&case, Mutex::default());
        let run = Run { observer: &watching, ..Run::seeded(1) };
        let woven = crate::analogy(&case.exemplars, &case.constraints, &case.options, &run).unwrap();
        let told = watching.1.into_inner().unwrap();
        let output = woven.result.domain();
        assert!(told.iter().all(|(.., shown)| shown.iter().all(|plane| plane.domain() == output)));
        let levels: Vec<_> = told.iter().filter(|(stage, ..)| *stage == "cms/level").collect();
        assert_eq!(levels.len(), if below == 0 { 0 } else { below + 1 }, "{seed}");
        assert!(levels.iter().skip(1).all(|(_, _, map, _)| map.holes() == 0), "{seed}: what was carried up is whole");
        let energies: Vec<i64> = told.iter().filter_map(|(_, energy, ..)| *energy).collect();
        assert_eq!(energies, woven.stats.energy, "{seed}");
        assert_eq!(told.last().unwrap().2, woven.result, "{seed}");
        several += below;
    }
    assert!(8 <= several, "{several} levels");
}
