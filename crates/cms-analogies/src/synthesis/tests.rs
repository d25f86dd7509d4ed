//! What is remembered of searches, for how long, and what labels promise.

use super::*;
use crate::agreement::of_sample;
use crate::edge_tests::of_one;
use crate::pieces;
use crate::tests::{case, shown};
use selvedge_core::{Domain, Grid, Guide, Seed};

/// The samples of a window are within so many steps of one of another, along both axes.
fn is_near(output: Domain<2>, window: &Window<2>, at: [u32; 2], steps: u32) -> bool {
    window.places(output).flatten().map(|place| output.position(place)).any(|other| {
        (0..2).all(|a| {
            let d = at[a].abs_diff(other[a]);
            (if output.periodic[a] { d.min(output.shape[a] - d) } else { d }) <= steps
        })
    })
}

#[test]
fn a_change_is_forgotten_as_far_as_it_could_matter() {
    for case in 0..60 {
        let mut rng = Seed(case).rng();
        let output = Domain { shape: [12, 14], periodic: [case % 2 == 0, case % 3 == 0] };
        let features = Grid::try_filled(Domain::open([5, 4]), 1, 0).unwrap();
        let exemplars = of_one(features);
        let options = Options { neighborhood: 2, ..Options::paper() };
        let map = SourceMap::unassigned(&exemplars, output).unwrap();
        let run = Run::seeded(0);
        let (of, start) = ((&exemplars, Vec::new()), (map, None));
        let mut weaver = Weaver::new(of, start, &[true], &options, &run, true).unwrap();
        let label = |y: u32, x: u32| Patch { source: 0, offset: [y as i32, x as i32] };
        let labels: Vec<Patch<2>> = (0..6).map(|_| label(rng.below(8), rng.below(11))).collect();
        let known: Vec<usize> = (0..12).map(|_| rng.below(output.len() as u32) as usize).collect();
        for &place in &known {
            let labels = labels.iter().map(|label| (*label, false)).collect();
            weaver.tried.insert(place, Tried { labels, is_idle: false });
        }
        let changed =
            Window { start: [rng.below(10) as i32, rng.below(12) as i32], shape: [1 + rng.below(2), 1 + rng.below(2)] };
        weaver.forget(&changed);
        for place in known {
            let at = output.position(place);
            let was_seen = is_near(output, &changed, at, options.neighborhood);
            assert_eq!(weaver.tried.contains_key(&place), !was_seen, "{output:?}, {changed:?}: {at:?}");
            for (label, again) in weaver.tried.get(&place).into_iter().flat_map(|tried| &tried.labels) {
                let mut shown = label.footprint(&exemplars, &Window::all(output)).places(output).flatten();
                let beside = shown.any(|p| is_near(output, &changed, output.position(p), 1));
                assert_eq!(*again, beside, "{output:?}, {changed:?}: {label:?}");
            }
        }
    }
}

/// What a label promises: of each sample of a window what it would cost less, if it would.
#[test]
fn promises_are_what_agreement_alone_would_save() {
    let mut some = 0;
    for seed in 0..60 {
        let case = case(seed);
        // Of outputs that go around all is looked at, and a label may meet itself.
        if case.output().periodic != [false; 2] {
            continue;
        }
        let (map, _) = case.weave(true);
        let (output, mut rng) = (case.output(), Seed(seed).rng());
        let copy = SourceMap { ids: map.ids.clone(), table: map.table.clone() };
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let labelling = Labelling::new(&case.exemplars, terms.clone(), copy, None, &case.options).unwrap();
        let expansions = Expansions::new(&case.exemplars, None, true);
        let source = rng.below(2) as usize;
        let offset = output.shape.map(|side| rng.below(side) as i32 - 2);
        let patch = Patch { source, offset };
        let start = output.shape.map(|side| rng.below(side));
        let shape = [0, 1].map(|a| 1 + rng.below(output.shape[a] - start[a]));
        let window = Window { start: start.map(|p| p as i32), shape };
        let saved = |at: [u32; 2]| {
            let new = shown(&case, &patch, at.map(|p| p as i32))?;
            let price = |id| i64::from(of_sample(&terms, &case.exemplars, at, id) + labelling.uses.price(id));
            Some((price(map.ids.get(0, at)) - price(new)).max(0))
        };
        let places = window.places(output).flatten().map(|place| output.position(place));
        let expected: i64 = places.filter_map(saved).sum();
        assert_eq!(expansions.promise(&labelling, &patch, &window, &mut Desk::default()).unwrap(), expected, "{seed}");
        some += u32::from(0 < expected);
    }
    assert!(5 <= some, "{some} promised something");
}

/// Pieces that are settled beside each other, beside the same one after the other in the order of their groups.
#[test]
fn pieces_settled_beside_each_other_end_as_if_settled_one_after_the_other() {
    let mut together = 0;
    for seed in 0..4 {
        let mut rng = Seed(seed).rng();
        let (source, output) = (Domain::open([70, 90]), Domain::open([90, 100]));
        let mut noise = |domain: Domain<2>| {
            Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap()
        };
        let exemplars = of_one(noise(source));
        let guide = Guide::new(&exemplars, &[noise(source)], noise(output)).unwrap();
        let constraints = [Constraint::new(guide)];
        let options = Options { neighborhood: 1, ..Options::paper() };
        // Blocks of random labels.
        let mut begun = SourceMap::unassigned(&exemplars, output).unwrap();
        let side = 3 + seed as u32;
        let of: Vec<u32> = (0..900).map(|_| rng.below(40)).collect();
        for at in output.positions() {
            let by = of[(at[0] / side * 30 + at[1] / side) as usize % 900];
            let from = [(at[0] + by) % source.shape[0], (at[1] + 3 * by) % source.shape[1]];
            begun.ids.plane_mut(0)[output.index(at)] = exemplars.table().id(0, from);
        }
        let run = Run::seeded(0);
        let weaver = || {
            let terms = Term::list(&exemplars, &constraints, &options);
            let map = SourceMap { ids: begun.ids.clone(), table: begun.table.clone() };
            Weaver::new((&exemplars, terms), (map, None), &[true], &options, &run, true).unwrap()
        };
        let mut one = weaver();
        one.labelling.wait(true).unwrap();
        for round in 0..=levels::MOVES {
            let pieces = pieces::of(&one.labelling.map).unwrap();
            let groups = pieces::groups(&pieces, output, one.expansions.room(output)).unwrap();
            for &number in groups.iter().flatten() {
                let trial = one.settled(round, &pieces, &[number]).remove(0).unwrap();
                trial.map(|trial| one.lay(trial).unwrap());
            }
            together += groups.iter().filter(|group| 1 < group.len()).count();
        }
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let several = pool.install(|| {
                let mut weaver = weaver();
                assert!(weaver.settle().unwrap());
                weaver
            });
            assert!(several.labelling.map == one.labelling.map, "{seed} {threads}");
            assert_eq!(several.labelling.energy(), one.labelling.energy(), "{seed} {threads}");
            let counts = |weaver: &Weaver<'_, '_>| (weaver.stats.expansions, weaver.stats.nodes, weaver.stats.pruned);
            assert_eq!(counts(&several), counts(&one), "{seed} {threads}");
        }
    }
    assert!(50 < together, "{together} groups of several pieces");
}
