//! Steps of a run, one by one.

use super::*;
use crate::candidates::variance;
use crate::options::Placement;
use crate::settings::Settings;
use selvedge_core::{Domain, Exemplars, Grid, Origin, Run, SampleId, Seed, Source, SourceMap, Start, Transform};

fn noise(side: u32) -> Exemplars<2> {
    let domain = Domain::open([side; 2]);
    let mut rng = Seed(1).rng();
    let samples = (0..domain.len()).map(|_| rng.below(256) as u8).collect();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: Grid::from_vec(domain, 1, samples).unwrap(), valid: None, origin };
    Exemplars::from_sources(vec![source], vec![1]).unwrap()
}

/// A run that goes on from a map.
fn weaver<'a>(
    exemplars: &'a Exemplars<2>,
    map: SourceMap<2>,
    options: &'a Options<2>,
    run: &'a Run<'a, 2>,
) -> Weaver<'a, 2> {
    let settings = Settings::new(exemplars, map.domain(), options, false).unwrap();
    assert_eq!(settings.scale, options.randomness * variance(exemplars));
    Weaver::new(
        exemplars,
        (selvedge_core::ValidBoxes::of(exemplars), &[]),
        &settings,
        Start { map, fixed: None, sources: None },
        options,
        run,
    )
    .unwrap()
}

/// Small regions, and no refinement.
fn small() -> Options<2> {
    Options { region: Some([8; 2]), reach: Some([4; 2]), refine: Some(0), ..Options::default() }
}

#[test]
fn regions_refined_at_once_do_not_meet_and_their_gains_add_up() {
    let (exemplars, run, options) = (noise(40), Run::seeded(3), small());
    for periodic in [[false; 2], [true, false], [true; 2]] {
        let output = Domain { shape: [70, 90], periodic };
        let map = SourceMap::unassigned(&exemplars, output).unwrap();
        let mut weaver = weaver(&exemplars, map, &options, &run);
        weaver.weave().unwrap();
        let first = weaver.canvas.cells.worst().unwrap();
        let cells = weaver.worst(BATCH);
        assert_eq!((cells.len(), cells[0]), (BATCH, first), "as many as may be, the worst first");
        let near = |cell: usize| weaver.near(&weaver.canvas.cells.region(cell, weaver.region));
        for (i, &a) in cells.iter().enumerate() {
            for &b in &cells[..i] {
                assert!(!near(a).grown(output, [1; 2], [1; 2]).meets(&near(b), output), "{a} {b}");
            }
        }
        let before = weaver.canvas.energy();
        let mut gains = 0;
        for (&cell, tried) in cells.iter().zip(weaver.try_all(&cells)) {
            let tried = tried.unwrap().unwrap();
            let gain = tried.best.as_ref().map_or(0, |(_, offer)| offer.gain().max(0));
            gains += if weaver.settle(cell, tried) { gain } else { 0 };
        }
        assert!(0 < gains);
        assert_eq!(before - weaver.canvas.energy(), gains);
    }
}

#[test]
fn the_best_of_all_tries_is_taken() {
    let (exemplars, run) = (noise(40), Run::seeded(5));
    let options = Options { tries: 6, randomness: 1.0, ..small() };
    let map = SourceMap::unassigned(&exemplars, Domain::open([50, 50])).unwrap();
    let mut weaver = weaver(&exemplars, map, &options, &run);
    weaver.weave().unwrap();
    let (mut worker, mut later) = (Worker::default(), 0);
    for cell in 0..weaver.canvas.cells.cells.len() {
        let region = weaver.canvas.cells.region(cell, weaver.region);
        let tried = weaver.attempt(&region, cell as u64, &mut worker).unwrap();
        let offer = |patch| weaver.canvas.offer(patch, &weaver.window(patch, &region), &mut worker.cut, &|| false);
        let gains: Vec<i64> = tried.drawn.patches.iter().map(offer).map(|o| o.unwrap().gain()).collect();
        assert_eq!(tried.best.map(|(_, offer)| offer.gain()), gains.iter().max().copied());
        assert_eq!(tried.nodes.len(), gains.len());
        later += u32::from(gains.first() < gains.iter().max());
    }
    assert!(0 < later, "the first is not always the best");
}

#[test]
fn an_improvement_lets_regions_around_it_be_tried_again() {
    let (exemplars, run, options) = (noise(40), Run::seeded(3), small());
    let map = SourceMap::unassigned(&exemplars, Domain::open([60, 60])).unwrap();
    let mut weaver = weaver(&exemplars, map, &options, &run);
    weaver.weave().unwrap();
    let all = 0..weaver.canvas.cells.cells.len();
    let mut worker = Worker::default();
    let mut improved = 0;
    for cell in all.clone() {
        let region = weaver.canvas.cells.region(cell, weaver.region);
        let tried = weaver.attempt(&region, 1000 + cell as u64, &mut worker).unwrap();
        all.clone().for_each(|cell| weaver.canvas.cells.leave_out(cell));
        assert_eq!(weaver.canvas.cells.worst(), None);
        let settled = weaver.settle(cell, tried);
        assert_eq!(weaver.canvas.cells.worst().is_some(), settled);
        improved += u32::from(settled);
    }
    assert!(0 < improved);
}

#[test]
fn refinement_ends_after_as_many_failures_in_a_row_as_were_asked_for() {
    let (exemplars, run) = (noise(40), Run::seeded(7));
    for patience in [1, 3] {
        // Draws that seldom bring anything.
        let options = Options { refine: None, patience, tries: 1, randomness: 1e6, ..small() };
        let map = SourceMap::unassigned(&exemplars, Domain::open([90, 90])).unwrap();
        let mut weaver = weaver(&exemplars, map, &options, &run);
        assert!(weaver.weave().unwrap());
        assert!(weaver.stats.refinements < 2 * weaver.stats.patches);
        let borne = patience as usize + (weaver.canvas.cells.regions() / REGIONS_A_FAILURE) as usize;
        let energy = &weaver.stats.energy;
        let last = energy.iter().rev().take_while(|e| Some(*e) == energy.last()).count() - 1;
        // A batch is settled to its end.
        assert!((borne..borne + BATCH).contains(&last), "{patience}: {last} of {borne}");
        let mut row = 0;
        for pair in energy.windows(2) {
            row = if pair[1] < pair[0] { 0 } else { row + 1 };
            assert!(row < borne + BATCH);
        }
    }
}

#[test]
fn entire_patches_agree_with_all_that_they_reach_and_sub_patches_with_their_region() {
    let (exemplars, run) = (noise(60), Run::seeded(1));
    // Columns 0 to 19 show the exemplar's own; from 22 on, beyond what is known, lies the region.
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([40, 50])).unwrap();
    for at in Domain::open([40, 20]).positions() {
        let id = exemplars.table().id(0, [at[0] + 9, at[1] + 4]);
        map.ids.set(0, at, id);
    }
    let region = Window { start: [16, 22], shape: [8, 8] };
    let known = Patch { source: 0, offset: [-9, -4] };
    for (placement, agree) in [(Placement::Entire, true), (Placement::Sub, false)] {
        let options = Options { placement, randomness: 0.001, ..small() };
        let weaver = weaver(&exemplars, map.clone(), &options, &run);
        let drawn = |step| weaver.choose(&region, [20, 26], 1, step, &mut Worker::default().matches).unwrap().patches;
        let found = (0..10).filter(|&step| drawn(step) == [known]).count();
        assert_eq!(found, if agree { 10 } else { 0 }, "{placement:?}");
    }
    assert!(map.ids.plane(0).contains(&SampleId::UNASSIGNED));
}

#[test]
fn copies_that_meet_their_own_reflection_are_not_drawn() {
    let one = noise(30);
    let mut sources: Vec<Source<2>> = Vec::new();
    for transform in [Transform::IDENTITY, Transform::Exact { quarter_turns: 0, mirror: true }] {
        let from = &one.sources()[0].features;
        let at = |p: [u32; 2]| if sources.is_empty() { p } else { [p[0], 29 - p[1]] };
        let samples = Domain::open([30; 2]).positions().map(|p| from.get(0, at(p))).collect();
        let features = Grid::from_vec(Domain::open([30; 2]), 1, samples).unwrap();
        sources.push(Source { features, valid: None, origin: Origin { exemplar: 0, transform } });
    }
    let (exemplars, run) = (Exemplars::from_sources(sources, vec![1]).unwrap(), Run::seeded(2));
    // The exemplar's left part up to column 20, where its mirrored twin would go on best.
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([30, 40])).unwrap();
    for at in Domain::open([30, 20]).positions() {
        map.ids.set(0, at, exemplars.table().id(0, at));
    }
    let options = Options { placement: Placement::Entire, randomness: 1.0, ..small() };
    let weaver = weaver(&exemplars, map, &options, &run);
    let region = Window { start: [11, 14], shape: [8, 8] };
    let neighbours = weaver.canvas.map.patches(&region);
    for step in 0..60 {
        let drawn = weaver.choose(&region, [15, 18], 3, step, &mut Worker::default().matches).unwrap();
        let reflects = |p: &Patch<2>| neighbours.iter().any(|n| crate::reflection::reflects(p, n, &exemplars, &region));
        assert!(!drawn.patches.iter().any(reflects));
    }
}

#[test]
fn what_was_drawn_is_not_drawn_again_until_nothing_else_is_left() {
    // Nine places where an exemplar of 10 x 10 covers a region of 8 x 8.
    let (exemplars, run) = (noise(10), Run::seeded(4));
    let options = Options { randomness: 1000.0, region: Some([8; 2]), ..small() };
    let map = SourceMap::unassigned(&exemplars, Domain::open([30, 30])).unwrap();
    for placement in [Placement::Sub, Placement::Random] {
        let options = Options { placement, ..options };
        let mut weaver = weaver(&exemplars, map.clone(), &options, &run);
        let (region, mut step) = (Window { start: [4, 4], shape: [8, 8] }, 0);
        for round in 0..3 {
            let mut seen = Vec::new();
            for _ in 0..9 {
                let drawn = weaver.choose(&region, [6, 6], 1, step, &mut Worker::default().matches).unwrap();
                weaver.note_drawn(&drawn);
                seen.extend(drawn.patches);
                step += 1;
            }
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), 9, "all places, each once, in round {round} of {placement:?}");
        }
    }
}

#[test]
fn no_patch_is_looked_for_beyond_what_sources_hold() {
    let (exemplars, run) = (noise(40), Run::seeded(5));
    let of = |reach| Options { reach: Some([reach; 2]), placement: Placement::Entire, ..small() };
    let (all, most) = (of(u32::MAX), of(32));
    let made = |options: &Options<2>| {
        let map = SourceMap::unassigned(&exemplars, Domain::open([90, 70])).unwrap();
        let mut weaver = weaver(&exemplars, map, options, &run);
        let near = weaver.near(&Window { start: [0, 0], shape: [8; 2] });
        weaver.weave().unwrap();
        (near, weaver.canvas.map)
    };
    let (near, map) = made(&all);
    assert_eq!(near, Window { start: [-32; 2], shape: [72; 2] }, "a side of 40 goes 32 beyond a region of 8");
    assert_eq!(map, made(&most).1);
}
