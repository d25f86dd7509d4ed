//! Strokes laid and taken back, against merges made anew.

use selvedge_core::{Observer, Origin, Rng, SeamMeasure, Seed, Source, Transform};

use super::*;
use crate::labels::expand;

/// Pictures of a few values, some of them with holes in their masks.
fn pictures(rng: &mut Rng, shape: [u32; 2], count: usize, holes: bool) -> Exemplars<2> {
    let domain = Domain::open(shape);
    let mut source = |number: usize| {
        let features = (0..domain.len()).map(|_| 25 * rng.below(9) as u8).collect();
        // The first shows everywhere.
        let shows = |rng: &mut Rng| !holes || number == 0 || rng.below(12) != 0;
        let valid = (0..domain.len()).map(|_| shows(rng)).collect();
        Source {
            features: Grid::from_vec(domain, 1, features).unwrap(),
            valid: Some(Grid::from_vec(domain, 1, valid).unwrap().into()),
            origin: Origin { exemplar: number as u16, transform: Transform::IDENTITY },
        }
    };
    Exemplars::from_sources((0..count).map(&mut source).collect(), vec![1]).unwrap()
}

fn labels(count: usize) -> Vec<Label<2>> {
    (0..count).map(|source| Label { source, offset: [0, 0] }).collect()
}

/// A stroke over a box, where its label can show.
fn stroke(rng: &mut Rng, merge: &Merge<'_, 2>) -> StrokeDelta {
    let domain = merge.domain();
    let label = (rng.below(4) != 0).then(|| rng.below(merge.labels.len() as u32) as usize);
    let (start, sides) = (domain.shape.map(|n| rng.below(n)), [1 + rng.below(4), 1 + rng.below(4)]);
    let inside = |at: &[u32; 2]| (0..2).all(|a| start[a] <= at[a] && at[a] < start[a] + sides[a]);
    let places = domain.positions().filter(inside).map(|at| domain.index(at) as u32);
    let shows = |place: &u32| merge.check(&StrokeDelta { places: vec![*place], label }).is_ok();
    StrokeDelta { places: places.filter(shows).collect(), label }
}

/// The same strokes in a merge made anew.
fn anew<'e>(merge: &Merge<'e, 2>, run: &Run<'_, 2>) -> Merge<'e, 2> {
    let mut new =
        Merge::new(merge.exemplars, merge.domain(), merge.labels.clone(), merge.options.clone(), &Run::seeded(0))
            .unwrap();
    new.strokes.clone_from(&merge.strokes);
    if new.two.is_none() {
        for place in 0..new.strokes.len() {
            if new.strokes[place] != NONE {
                new.show(place, usize::from(new.strokes[place]));
            }
        }
    }
    assert!(new.settle(run).unwrap());
    new
}

#[test]
fn two_labels_are_cut_as_if_made_anew_whatever_came_before() {
    let (mut seams, mut undone) = (0, 0);
    for case in 0..1000 {
        let mut rng = Seed(case).rng();
        let shape = [3 + rng.below(8), 3 + rng.below(8)];
        let e = pictures(&mut rng, shape, 2, case % 3 == 0);
        let own = (case % 4 == 0).then(|| {
            let prices = (0..2 * shape[0] * shape[1]).map(|_| 30 * rng.below(40) as i32).collect();
            Grid::from_vec(Domain::open(shape), 2, prices).unwrap()
        });
        let seam = if case % 2 == 0 { SeamMeasure::Difference } else { SeamMeasure::Gradient };
        let options = LabelOptions { seam, own, ..LabelOptions::default() };
        let run = Run::seeded(0);
        let mut merge = Merge::new(&e, Domain::open(shape), labels(2), options, &Run::seeded(0)).unwrap();
        assert!(merge.two.is_some() && merge.solve(&run).unwrap());
        let mut before = vec![merge.map.clone()];
        for _ in 0..6 {
            if rng.below(4) == 0 {
                assert_eq!(merge.undo(), 1 < before.len());
                undone += usize::from(1 < before.len());
                before.truncate(1.max(before.len() - 1));
                assert_eq!(Some(&merge.map), before.last());
            } else {
                let stroke = stroke(&mut rng, &merge);
                assert!(merge.update(&stroke, &run).unwrap());
                before.push(merge.map.clone());
            }
            let new = anew(&merge, &run);
            assert_eq!(merge.map, new.map, "case {case}");
            assert_eq!((merge.price(), &merge.standing), (new.price(), &new.standing), "case {case}");
            let kept = merge.strokes.iter().zip(&merge.standing);
            assert!(kept.clone().all(|(stroke, shows)| *stroke == NONE || stroke == shows));
            seams += merge.seam().len();
        }
    }
    assert!(1000 < seams && 200 < undone, "{seams} seams, {undone} undone");
}

#[test]
fn two_labels_are_those_of_expansions() {
    let mut compared = 0;
    for case in 0..200 {
        let mut rng = Seed(4000 + case).rng();
        let shape = [3 + rng.below(7), 3 + rng.below(7)];
        let e = pictures(&mut rng, shape, 2, false);
        let bits = (0..shape[0] * shape[1]).map(|_| [1, 2, 3, 3, 3][rng.below(5) as usize]).collect();
        let only = Some(Grid::from_vec(Domain::open(shape), 1, bits).unwrap());
        let options = LabelOptions { only, seam: SeamMeasure::Difference, ..LabelOptions::default() };
        let mut merge = Merge::new(&e, Domain::open(shape), labels(2), options.clone(), &Run::seeded(0)).unwrap();
        merge.solve(&Run::seeded(0)).unwrap();
        let start = Start { map: SourceMap::unassigned(&e, Domain::open(shape)).unwrap(), fixed: None, sources: None };
        let woven = expand(&e, start, &labels(2), &options, &Run::seeded(0)).unwrap();
        assert_eq!(woven.stats.energy.last(), Some(&merge.price()), "case {case}");
        compared += usize::from(0 < merge.price());
    }
    assert!(150 < compared);
}

#[test]
fn more_labels_never_cost_more_than_the_stroke_laid_over_them() {
    let mut changed = 0;
    for case in 0..120 {
        let mut rng = Seed(7000 + case).rng();
        let shape = [4 + rng.below(40), 4 + rng.below(40)];
        let e = pictures(&mut rng, shape, 3, case % 2 == 0);
        let own = (case % 3 == 0).then(|| {
            let prices = (0..3 * shape[0] * shape[1]).map(|_| 30 * rng.below(40) as i32).collect();
            Grid::from_vec(Domain::open(shape), 3, prices).unwrap()
        });
        let options = LabelOptions { own, ..LabelOptions::default() };
        let mut merge = Merge::new(&e, Domain::open(shape), labels(3), options, &Run::seeded(0)).unwrap();
        let run = Run::seeded(0);
        assert!(merge.solve(&run).unwrap());
        let mut before = vec![merge.map.clone()];
        for _ in 0..4 {
            if rng.below(4) == 0 {
                merge.undo();
                before.truncate(1.max(before.len() - 1));
                assert_eq!(Some(&merge.map), before.last());
                continue;
            }
            let stroke = stroke(&mut rng, &merge);
            let mut laid = anew(&merge, &run);
            (laid.map, laid.standing) = (merge.map.clone(), merge.standing.clone());
            if let Some(label) = stroke.label {
                stroke.places.iter().for_each(|&place| laid.show(place as usize, label));
            }
            assert!(merge.update(&stroke, &run).unwrap());
            assert!(merge.price() <= laid.price(), "case {case}");
            let kept = merge.strokes.iter().zip(&merge.standing);
            assert!(kept.clone().all(|(stroke, shows)| *stroke == NONE || stroke == shows), "case {case}");
            changed += usize::from(Some(&merge.map) != before.last());
            before.push(merge.map.clone());
        }
    }
    assert!(100 < changed, "{changed}");
}

#[test]
fn previews_change_nothing_and_show_the_stroke() {
    let mut rng = Seed(3).rng();
    for count in [2, 3] {
        let e = pictures(&mut rng, [60, 70], count, false);
        let run = Run::seeded(0);
        let mut merge =
            Merge::new(&e, Domain::open([60, 70]), labels(count), LabelOptions::default(), &Run::seeded(0)).unwrap();
        merge.solve(&run).unwrap();
        let (map, price) = (merge.map.clone(), merge.price());
        let stroke = StrokeDelta { places: (0..5).map(|x| 70 * 30 + 40 + x).collect(), label: Some(1) };
        let shown = merge.preview(&stroke, &run).unwrap();
        assert_eq!((&merge.map, merge.price()), (&map, price));
        for &place in &stroke.places {
            let at = shown.domain().position(place as usize);
            assert_eq!(shown.locate(at), Some((1, at)));
        }
        assert_eq!(shown.holes(), 0);
        merge.update(&stroke, &run).unwrap();
        assert!(merge.price() <= merge.costs.total(&shown));
    }
}

#[test]
fn wrong_strokes_change_nothing_and_cancelled_ones_are_gone_on_with() {
    struct Stop;
    impl Observer<2> for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let run = Run::seeded(0);
    for count in [2, 3] {
        let e = pictures(&mut Seed(9).rng(), [20, 30], count, false);
        let mut merge =
            Merge::new(&e, Domain::open([20, 30]), labels(count), LabelOptions::default(), &Run::seeded(0)).unwrap();
        merge.solve(&run).unwrap();
        for (place, label) in [(600, Some(0)), (600, None), (3, Some(count))] {
            let places = if label == Some(count) { vec![place] } else { vec![0, place] };
            let error = merge.update(&StrokeDelta { places, label }, &run).unwrap_err();
            assert_eq!(error, Error::Stroke { place: place as usize, label });
        }
        assert!(merge.strokes.iter().all(|stroke| *stroke == NONE) && !merge.undo());
        let stroke = StrokeDelta { places: vec![200, 201, 202], label: Some(1) };
        assert!(!merge.update(&stroke, &Run { observer: &Stop, ..Run::seeded(0) }).unwrap());
        let other = StrokeDelta { places: vec![20], label: Some(0) };
        assert!(merge.update(&other, &run).unwrap());
        assert_eq!([200, 202, 20].map(|place| merge.label(place)), [Some(1), Some(1), Some(0)]);
        assert!(count != 2 || merge.map == anew(&merge, &run).map);
    }
}
