//! What strangers met: stripes of one piece, stones melted into plates, courses that do not close.

use selvedge_analysis::Texture;
use selvedge_core::{Domain, Exemplars, Run, SourceMap};
use selvedge_graphcut_textures::{Options, Placement, graphcut, plan};
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
    let region = plan(e, output, None, options, &Run::<2>::seeded(0).limits).unwrap().region[0];
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
        (planned.apart, planned.region[0])
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
    // Of hardly more than the exemplar readers liked neither way better.
    let small = plan(&stones, Domain::open([384, 384]), None, &usual, &Run::<2>::seeded(0).limits).unwrap();
    assert_eq!((small.apart, small.placement), (0, Placement::Entire));
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
        assert!(25 < planned.region[0] && largest <= planned.region[0], "{:?}", planned.region);
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
