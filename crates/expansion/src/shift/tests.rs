//! Shifted patches: true gains, what has to stay, and patches that fall into place.

use super::*;
use crate::band::tests::patched;
use selvedge_core::{Origin, SeamMeasure, Seed, Source, Transform, Window};

fn check_shift<const D: usize>(case: u64, most: u32) -> i64 {
    let mut rng = Seed(case).derive("shift", D as u64).rng();
    let (e, mut map) = patched::<D>(&mut rng, most, case.is_multiple_of(3));
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let before = map.clone();
    let fixed: Vec<bool> = (0..map.domain().len()).map(|i| case.is_multiple_of(4) && i % 11 == 3).collect();
    let fixed = Grid::from_vec(map.domain(), 1, fixed).unwrap();
    let free = std::array::from_fn(|a| a == 0 || !case.is_multiple_of(5));
    let gain = shift(&e, &mut map, &costs, (free, Some(&fixed)), &|| false).unwrap();
    assert_eq!(costs.total(&before) - costs.total(&map), gain, "case {case}: gains are true");
    assert!(0 <= gain);
    for (i, (&was, &is)) in before.ids.plane(0).iter().zip(map.ids.plane(0)).enumerate() {
        assert_eq!(was.is_assigned(), is.is_assigned());
        assert!(was == is || !fixed.samples()[i]);
        let Some((source, at)) = e.locate(is) else { continue };
        assert!(was == is || e.sources()[source].valid.as_deref().is_none_or(|v| v.get(0, at)));
        assert!(was == is || ways(free).any(|by| step(&e, was, by) == Some(is)), "one sample, of the same source");
    }
    gain
}

#[test]
fn shifted_maps_are_cheaper_and_keep_what_has_to_stay() {
    let gained: i64 =
        (0..60).map(|case| check_shift::<1>(case, 30) + check_shift::<2>(case, 14) + check_shift::<3>(case, 6)).sum();
    assert!(0 < gained);
}

#[test]
fn a_patch_that_lies_a_sample_off_falls_into_place() {
    let domain = Domain::open([30, 30]);
    let mut rng = Seed(1).rng();
    let features = Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap();
    let source = Source { features, valid: None, origin: Origin { exemplar: 0, transform: Transform::IDENTITY } };
    let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    for by in ways([true; 2]) {
        let output = Domain::open([20, 20]);
        let mut map = SourceMap::unassigned(&e, output).unwrap();
        for (patch, window) in [
            (Patch { source: 0, offset: [-5, -5] }, Window::all(output)),
            (Patch { source: 0, offset: by.map(|by| by - 5) }, Window { start: [4, 6], shape: [9, 8] }),
        ] {
            let samples = patch.samples(&e, &window);
            window.places(output).zip(samples).for_each(|(at, id)| map.ids.plane_mut(0)[at.unwrap()] = id);
        }
        let before = costs.total(&map);
        assert!(0 < before);
        assert_eq!(shift(&e, &mut map, &costs, ([true; 2], None), &|| false).unwrap(), before, "{by:?}");
        assert_eq!(costs.total(&map), 0);
    }
}

#[test]
fn a_patch_that_goes_on_around_the_output_as_another_is_not_torn() {
    // Around 25 places of a source of 16 samples two patches lie, which go on in each other where the output closes.
    let (domain, output) = (Domain::periodic([16]), Domain::periodic([25]));
    let mut going_on = 0;
    for case in 0..200 {
        let mut rng = Seed(case).derive("wrap", 0).rng();
        let features = (0..16).map(|_| rng.below(256) as u8).collect();
        let features = Grid::from_vec(domain, 1, features).unwrap();
        let source = Source { features, valid: None, origin: Origin { exemplar: 0, transform: Transform::IDENTITY } };
        let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        let mut map = SourceMap::unassigned(&e, output).unwrap();
        let other = rng.below(16);
        for (place, id) in map.ids.plane_mut(0).iter_mut().enumerate() {
            let place = place as u32;
            // What the last place shows, 24 % 16, goes on at the first.
            let shown = if place < 6 { 9 + place } else { place + if place < 20 { other } else { 0 } };
            *id = SampleId::new(shown % 16);
        }
        going_on += u32::from(costs.continued(map.ids.plane(0)[24], 0) == Some(map.ids.plane(0)[0]));
        let before = costs.total(&map);
        let gain = shift(&e, &mut map, &costs, ([true], None), &|| false).unwrap();
        assert_eq!(before - costs.total(&map), gain, "case {case}");
        assert!(0 <= gain);
    }
    assert_eq!(going_on, 200);
}

#[test]
fn whoever_asks_it_to_stop_has_a_whole_map() {
    let mut rng = Seed(4).rng();
    let (e, mut map) = patched::<2>(&mut rng, 14, false);
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let before = map.clone();
    assert!(shift(&e, &mut map, &costs, ([true; 2], None), &|| true).unwrap_err().is_cancelled());
    assert_eq!(map, before);
}
