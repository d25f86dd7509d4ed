//! Settled maps: true gains, what has to stay, tiles.

use super::*;
use crate::band::tests::patched;
use selvedge_core::{Origin, SeamMeasure, Seed, Source, Transform};

/// Every sample is unassigned or valid.
fn is_of<const D: usize>(exemplars: &Exemplars<D>, id: SampleId) -> bool {
    exemplars
        .locate(id)
        .is_none_or(|(source, at)| exemplars.sources()[source].valid.as_deref().is_none_or(|v| v.get(0, at)))
}

fn check_settling<const D: usize>(case: u64, most: u32) -> i64 {
    let mut rng = Seed(case).derive("settle", D as u64).rng();
    let (e, mut map) = patched::<D>(&mut rng, most, case.is_multiple_of(3));
    let measure = if case.is_multiple_of(2) { SeamMeasure::Difference } else { SeamMeasure::Gradient };
    let costs = SeamCosts::new(&e, measure).unwrap();
    let before = map.clone();
    let salt = rng.below(7) as usize;
    let fixed: Vec<bool> = (0..map.domain().len()).map(|i| (i + salt).is_multiple_of(7)).collect();
    let fixed = Grid::from_vec(map.domain(), 1, fixed).unwrap();
    let sources = (0..map.domain().len()).map(|i| if (i + salt).is_multiple_of(5) { 1 } else { 3 }).collect();
    let sources = Grid::from_vec(map.domain(), 1, sources).unwrap();
    let kept = Pins { fixed: Some(&fixed), sources: Some(&sources) };
    let width = [0, 2, 5, u32::MAX][rng.below(4) as usize];
    let gain = settle(&e, &mut map, &costs, kept, width, &|| false, &|_, _| {}).unwrap();
    assert_eq!(costs.total(&before) - costs.total(&map), gain, "case {case}: gains are true");
    assert!(0 <= gain);
    for (i, (&was, &is)) in before.ids.plane(0).iter().zip(map.ids.plane(0)).enumerate() {
        assert_eq!(was.is_assigned(), is.is_assigned(), "holes stay");
        assert!(is_of(&e, is));
        assert!(was == is || !fixed.samples()[i], "case {case}: what is fixed stays");
        let source = e.table().source(is).unwrap_or(0);
        assert!(was == is || sources.samples()[i] >> source & 1 == 1, "case {case}: only what may show comes");
    }
    gain
}

#[test]
fn settled_maps_are_cheaper_and_keep_what_has_to_stay() {
    let small = |case| check_settling::<1>(case, 20) + check_settling::<2>(case, 14) + check_settling::<3>(case, 6);
    let gained: i64 = (0..60).map(small).sum();
    // More than one tile along an axis.
    let large: i64 = (0..12).map(|case| check_settling::<1>(case, 400) + check_settling::<2>(case, 150)).sum();
    assert!(0 < gained && 0 < large);
}

#[test]
fn tiles_cover_an_output_once_and_none_of_a_group_touch() {
    for case in 0..300 {
        let mut rng = Seed(case).derive("tiles", 0).rng();
        let shape = std::array::from_fn(|_| 1 + rng.below(23));
        let output: Domain<2> = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 0) };
        let side = 2 + rng.below(5);
        let shift = rng.below(side);
        let groups = tiles(output, side, shift);
        let mut covered = vec![0; output.len()];
        for (tile, place) in groups.iter().flatten().flat_map(|t| t.places(output).map(move |place| (t, place))) {
            covered[place.expect("inside")] += 1;
            assert!(tile.shape.iter().all(|&n| n <= side));
        }
        assert!(covered.iter().all(|&n| n == 1), "{output:?} {side} {shift}");
        for group in &groups {
            for (i, a) in group.iter().enumerate() {
                let around = a.grown(output, [1; 2], [1; 2]);
                assert!(group[..i].iter().all(|b| !b.meets(&around, output)), "{output:?} {side} {shift}");
            }
        }
    }
}

#[test]
fn a_seam_along_the_border_of_tiles_leaves_it() {
    const TILE: u32 = tile_side::<1>();
    // Two patches that agree at two samples alone, inside of a tile that holds but one of them.
    let (cheap, second) = (TILE as usize + 6, TILE as usize + 30);
    let mut rng = Seed(1).rng();
    let mut row: Vec<u8> = (0..4 * TILE).map(|_| rng.below(256) as u8).collect();
    row.copy_within(cheap..cheap + 2, cheap + second);
    let features = Grid::from_vec(Domain::open([4 * TILE]), 1, row).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let e = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
    let mut map = SourceMap::unassigned(&e, Domain::open([2 * TILE])).unwrap();
    for (x, id) in (0..).zip(map.ids.plane_mut(0)) {
        *id = SampleId::new(if x < TILE { x } else { x + second as u32 });
    }
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let before = costs.total(&map);
    let gain = settle(&e, &mut map, &costs, Pins::default(), 16, &|| false, &|_, _| {}).unwrap();
    assert!(0 < before);
    assert_eq!((gain, costs.total(&map)), (before, 0));
}

#[test]
fn who_asks_to_stop_is_heard() {
    let (e, mut map) = patched::<2>(&mut Seed(3).rng(), 40, false);
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let before = map.clone();
    let stopped = settle(&e, &mut map, &costs, Pins::default(), 4, &|| true, &|_, _| {}).unwrap_err();
    assert!(stopped.is_cancelled());
    assert_eq!(map, before);
}
