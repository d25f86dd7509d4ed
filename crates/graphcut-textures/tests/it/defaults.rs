//! What strangers met: stripes of one piece, stones melted into plates, courses that do not close.

use selvedge_analysis::Texture;
use selvedge_core::{Domain, Exemplars, Run, SourceMap, Window};
use selvedge_graphcut_textures::{Options, Placement, Stutter, graphcut, plan};
use selvedge_testkit::exemplars::{bricks, cobbles, planks, weave};

use crate::common::of;

/// The share of seams on both sides of which the same shows, moved by less than `near` samples along every axis.
fn stutters(map: &SourceMap<2>, near: u32) -> f64 {
    let edges = map.domain().positions().flat_map(|at| (0..2).map(move |axis| (at, axis)));
    let seams = edges.filter(|&(at, axis)| map.is_seam(at, axis)).filter_map(|(at, axis)| {
        let [(_, a), (_, b)] = [map.locate(at)?, map.locate(map.domain().next(at, axis)?)?];
        let moved = |i: usize| (i64::from(b[i]) - i64::from(a[i]) - i64::from(i == axis)).unsigned_abs();
        Some((0..2).all(|i| moved(i) < u64::from(near)))
    });
    let all: Vec<bool> = seams.collect();
    all.iter().filter(|s| **s).count() as f64 / all.len().max(1) as f64
}

/// Of a few runs, the share of seams that stutter within a region of the planned size.
fn stuttering(e: &Exemplars<2>, options: &Options<2>) -> f64 {
    let output = Domain::open([300, 340]);
    let region = plan(e, output, None, options, &Run::<2>::seeded(0).limits).unwrap().settings.region[0];
    let of = |seed| stutters(&graphcut(e, output, options, &Run::seeded(seed)).unwrap().result, region);
    (0..3).map(of).sum::<f64>() / 3.0
}

#[test]
fn boards_do_not_come_out_in_stripes_of_one_piece() {
    let e = of(&planks());
    let options = Options { refine: Some(0), ..Options::default() };
    let (by_default, without) = (stuttering(&e, &options), stuttering(&e, &Options { apart: Some(0), ..options }));
    assert!(by_default < 0.02 && 0.15 < without, "{by_default} and {without} of all seams");
}

#[test]
fn patches_lie_apart_where_nothing_comes_again_and_nobody_named_a_region() {
    let apart = |e: &Exemplars<2>, options: &Options<2>| {
        let planned = plan(e, Domain::open([600, 600]), None, options, &Run::<2>::seeded(0).limits).unwrap();
        (planned.settings.apart, planned.settings.region[0])
    };
    let (stones, cloth, usual) = (of(&cobbles()), of(&weave()), Options::default());
    assert_eq!(apart(&stones, &usual), (72, 48));
    for placement in [Placement::Entire, Placement::Sub] {
        // What says the placement alone is laid as what chooses it.
        assert_eq!(apart(&stones, &Options { placement, reach: Some([72; 2]), ..usual }), (72, 48));
        assert_eq!(apart(&stones, &Options { placement, region: Some([20; 2]), ..usual }), (0, 20));
        assert_eq!(apart(&stones, &Options { placement, region: Some([20; 2]), apart: Some(9), ..usual }).0, 9);
        assert_eq!(apart(&cloth, &Options { placement, ..usual }).0, 0, "a weave has a lattice");
    }
    assert_eq!(apart(&stones, &Options { placement: Placement::Random, ..usual }).0, 0);
    assert_eq!(apart(&stones, &Options::paper()).0, 0);
}

#[test]
fn a_patch_may_stutter_once_where_few_copies_show() {
    let stones = of(&cobbles());
    let stutter = |side, options: Options<2>| {
        let planned = plan(&stones, Domain::open([side; 2]), None, &options, &Run::<2>::seeded(0).limits).unwrap();
        (planned.settings.apart, planned.settings.stutter)
    };
    let usual = Options::default();
    assert_eq!(stutter(384, usual), (72, Stutter::Once));
    assert_eq!(stutter(600, usual), (72, Stutter::Never));
    assert_eq!(stutter(384, Options { apart: Some(72), ..usual }), (72, Stutter::Never), "who says how far says all");
    assert_eq!(stutter(384, Options { region: Some([48; 2]), ..usual }), (0, Stutter::Never));
    for stutter_of in [Stutter::Never, Stutter::Once] {
        let told = Options { stutter: stutter_of, ..usual };
        assert_eq!([stutter(384, told), stutter(600, told)], [(72, stutter_of); 2]);
    }
}

#[test]
fn what_was_chosen_is_woven_without_choosing_again() {
    let limits = Run::<2>::seeded(0).limits;
    for (e, sides) in [(of(&cobbles()), [400, 600]), (of(&weave()), [300, 600]), (of(&planks()), [200, 400])] {
        for side in sides {
            let (output, usual) = (Domain::open([side, side + 20]), Options { refine: Some(2), ..Options::default() });
            let planned = plan(&e, output, None, &usual, &limits).unwrap();
            let chosen = planned.chosen();
            let again = plan(&e, output, None, &chosen, &limits).unwrap();
            assert_eq!((again.settings.regularity, again.settings.is_orderly), (None, false), "nothing is measured");
            let regularity = planned.settings.regularity;
            assert_eq!(again.chosen(), chosen);
            let woven = |options| graphcut(&e, output, options, &Run::seeded(1)).unwrap();
            let (first, second) = (woven(&usual), woven(&chosen));
            assert_eq!(first.result, second.result, "{side}");
            let mut told = second.stats;
            (told.settings.regularity, told.settings.is_orderly) = (regularity, planned.settings.is_orderly);
            assert_eq!(first.stats, told);
        }
    }
}

/// Of the moves by less than `near` samples between patches that meet, the share that was made before, in any step of
/// four samples: what stripes consist of.
fn made_again(map: &SourceMap<2>, near: u32) -> f64 {
    let around = |start: [i32; 2]| map.patches(&Window { start, shape: [2, 2] });
    let mut pairs = std::collections::BTreeSet::new();
    for at in map.domain().positions().filter(|at| (0..2).all(|i| at[i] + 1 < map.domain().shape[i])) {
        let here = around(at.map(|c| c as i32));
        pairs.extend(here.iter().flat_map(|a| here.iter().map(move |b| (*a, *b))).filter(|(a, b)| a < b));
    }
    let moves = pairs.iter().map(|(a, b)| [0, 1].map(|i| b.offset[i] - a.offset[i]));
    let short: Vec<_> = moves.filter(|v| v.iter().all(|c| c.unsigned_abs() < near)).collect();
    let different: std::collections::BTreeSet<_> = short.iter().map(|v| v.map(|c| c.div_euclid(4))).collect();
    1.0 - different.len() as f64 / short.len().max(1) as f64
}

#[test]
fn short_moves_are_made_again_less_often_where_each_may_be_made_once() {
    let e = of(&planks());
    let options = Options { region: Some([24; 2]), reach: Some([24; 2]), refine: Some(0), ..Options::default() };
    let again = |apart, stutter| {
        let options = Options { apart: Some(apart), stutter, ..options };
        let of = |seed| graphcut(&e, Domain::open([240, 260]), &options, &Run::seeded(seed)).unwrap().result;
        (0..3).map(|seed| made_again(&of(seed), 36)).sum::<f64>() / 3.0
    };
    let [without, once, never] =
        [(0, Stutter::Never), (36, Stutter::Once), (36, Stutter::Never)].map(|(apart, stutter)| again(apart, stutter));
    assert!(never + 0.1 < once && once + 0.1 < without, "{never}, {once} and {without} of short moves");
}

#[test]
fn whatever_patches_cannot_lie_apart_from_is_covered_all_the_same() {
    let e = of(&planks());
    let options = Options { apart: Some(u32::MAX), refine: Some(3), ..Options::default() };
    assert_eq!(graphcut(&e, Domain::periodic([150, 170]), &options, &Run::seeded(1)).unwrap().result.holes(), 0);
}

#[test]
fn regions_hold_the_structures_of_stones() {
    // Stones of 25 px came out as plates where regions were of 16.
    let stones = of(&cobbles());
    let source = &stones.sources()[0];
    let texture = Texture::of(&source.features, None, stones.weights()).unwrap();
    let largest = texture.feature_size.min(source.domain().shape[0] / 4);
    for output in [[200, 300], [768, 768]] {
        let planned =
            plan(&stones, Domain::open(output), None, &Options::default(), &Run::<2>::seeded(0).limits).unwrap();
        assert!(
            25 < planned.settings.region[0] && largest <= planned.settings.region[0],
            "{:?}",
            planned.settings.region
        );
    }
}

#[test]
fn courses_of_bricks_close_where_an_output_is_as_long_as_some_of_them() {
    let e = of(&bricks().albedo);
    let lattice = Texture::of(&e.sources()[0].features, None, e.weights()).unwrap().order().unwrap();
    let options = Options { refine: Some(0), ..Options::default() };
    // What a seam all along the wrap costs, however it is laid.
    let price = |height: u32| {
        let output = Domain::periodic([height, 224]);
        let energy = |seed| *graphcut(&e, output, &options, &Run::seeded(seed)).unwrap().stats.energy.last().unwrap();
        (0..3).map(energy).sum::<i64>() as f64 / output.len() as f64
    };
    let closed = lattice.closing(0, 210);
    let courses = price(closed);
    // Half a course more.
    let torn = price(closed + 9);
    assert!(1.05 * courses < torn, "{courses} at {closed} rows, {torn} at 9 more");
}
