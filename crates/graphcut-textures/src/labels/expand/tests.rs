//! Labels against all labellings, and what is promised of them.

use selvedge_core::{Domain, Grid, Observer, Origin, Rng, SampleId, SeamCosts, SeamMeasure, Seed, Source, Transform};
use selvedge_core::{Exemplars, Run, SourceMap, Start};

use super::*;

/// Noise of few values, so that prices are often equal.
fn exemplars(shape: [u32; 2], seed: u64) -> Exemplars<2> {
    let mut rng = Seed(seed).rng();
    let domain = Domain::open(shape);
    let features = Grid::from_vec(domain, 1, (0..domain.len()).map(|_| 30 * rng.below(8) as u8).collect()).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
}

fn empty(e: &Exemplars<2>, output: Domain<2>) -> Start<2> {
    Start { map: SourceMap::unassigned(e, output).unwrap(), fixed: None, sources: None }
}

/// Labels that are defined everywhere, and beyond.
fn covering(rng: &mut Rng, count: usize) -> Vec<Label<2>> {
    let mut labels: Vec<Label<2>> = Vec::new();
    while labels.len() < count {
        let label = Label { source: 0, offset: std::array::from_fn(|_| -1 - rng.below(6) as i32) };
        if !labels.contains(&label) {
            labels.push(label);
        }
    }
    labels
}

fn sample(e: &Exemplars<2>, label: &Label<2>, at: [u32; 2]) -> SampleId {
    e.table().id(label.source, std::array::from_fn(|a| (at[a] as i32 - label.offset[a]) as u32))
}

/// A field in which some places let few labels show.
fn field(rng: &mut Rng, output: Domain<2>, labels: usize) -> Grid<u64, 2> {
    let all = (1_u64 << labels) - 1;
    let bits = |rng: &mut Rng| match rng.below(3) {
        0 => 1 + u64::from(rng.below(all as u32)),
        _ => all,
    };
    Grid::from_vec(output, 1, (0..output.len()).map(|_| bits(rng)).collect()).unwrap()
}

fn prices(rng: &mut Rng, output: Domain<2>, labels: usize) -> Grid<i32, 2> {
    let own = (0..output.len() * labels).map(|_| 50 * rng.below(40) as i32).collect();
    Grid::from_vec(output, labels, own).unwrap()
}

/// The least price of all labellings that a field allows.
fn least(e: &Exemplars<2>, output: Domain<2>, labels: &[Label<2>], options: &LabelOptions<2>) -> i64 {
    let costs = SeamCosts::new(e, options.seam).unwrap();
    let (n, count) = (output.len(), labels.len());
    let mut map = SourceMap::unassigned(e, output).unwrap();
    let mut best = i64::MAX;
    'all: for number in 0..count.pow(n as u32) {
        let (mut rest, mut price) = (number, 0);
        for (place, at) in output.positions().enumerate() {
            let label = rest % count;
            rest /= count;
            if options.only.as_ref().is_some_and(|only| only.plane(0)[place] >> label & 1 == 0) {
                continue 'all;
            }
            price += options.own.as_ref().map_or(0, |own| i64::from(own.plane(label)[place]));
            map.ids.plane_mut(0)[place] = sample(e, &labels[label], at);
        }
        best = best.min(price + costs.total(&map));
    }
    best
}

#[test]
fn two_labels_are_the_best_of_all_labellings() {
    let mut seams = 0;
    for case in 0..150 {
        let mut rng = Seed(case).rng();
        let e = exemplars([12, 12], case);
        let output = Domain { shape: [3, 4], periodic: [false, case % 3 == 0] };
        let labels = covering(&mut rng, 2);
        for seam in [SeamMeasure::Difference, SeamMeasure::Gradient] {
            let options = LabelOptions {
                seam,
                only: Some(field(&mut rng, output, 2)),
                own: (case % 2 == 0).then(|| prices(&mut rng, output, 2)),
                ..LabelOptions::default()
            };
            let woven = expand(&e, empty(&e, output), &labels, &options, &Run::seeded(0)).unwrap();
            let found = *woven.stats.energy.last().unwrap();
            // Around a border a label is no metric: there it does not go on.
            if woven.stats.truncated == 0 {
                assert_eq!(found, least(&e, output, &labels, &options), "case {case} {seam:?}");
                seams += usize::from(0 < found);
            }
        }
    }
    assert!(200 < seams, "only {seams} cases had anything to decide");
}

/// A label that is given twice, at other prices: what a cut does not tell apart, it must not change.
#[test]
fn labels_of_one_sample_have_each_its_own_price() {
    for case in 0..150 {
        let mut rng = Seed(70 + case).rng();
        let (e, output) = (exemplars([12, 12], case), Domain::open([3, 3]));
        let mut labels = covering(&mut rng, 2);
        labels.insert(case as usize % 3, labels[case as usize % 2]);
        let own = Some(prices(&mut rng, output, 3));
        let options = LabelOptions { own, ..LabelOptions::default() };
        let woven = expand(&e, empty(&e, output), &labels, &options, &Run::seeded(0)).unwrap();
        let told = *woven.stats.energy.last().unwrap();
        assert!(least(&e, output, &labels, &options) <= told, "case {case}: less than the least of all is told");
    }
}

/// The share of 3x3 grids on which three labels end at the least price of all, and the worst ratio to it.
#[test]
fn three_labels_are_mostly_the_best_and_never_far() {
    for (seam, share, factor) in [(SeamMeasure::Difference, 0.90, 1.5), (SeamMeasure::Gradient, 0.90, 2.0)] {
        let (mut equal, mut worst, cases) = (0, 1.0_f64, 100);
        for case in 0..cases {
            let mut rng = Seed(9000 + case).rng();
            let (e, output) = (exemplars([10, 10], case), Domain::open([3, 3]));
            let labels = covering(&mut rng, 3);
            let only = Some(field(&mut rng, output, 3));
            let options = LabelOptions { seam, only, ..LabelOptions::default() };
            let woven = expand(&e, empty(&e, output), &labels, &options, &Run::seeded(0)).unwrap();
            let found = *woven.stats.energy.last().unwrap();
            let best = least(&e, output, &labels, &options);
            assert!(best <= found);
            equal += usize::from(found == best);
            worst = worst.max(found as f64 / (best as f64).max(1.0));
        }
        assert!(share * cases as f64 <= equal as f64 && worst <= factor, "{seam:?}: {equal} of {cases}, {worst}");
    }
}

#[test]
fn prices_never_rise_and_are_those_of_the_map() {
    let mut improved = 0;
    for case in 0..60 {
        let mut rng = Seed(500 + case).rng();
        let e = exemplars([9, 11], case);
        let shape = [4 + rng.below(8), 4 + rng.below(8)];
        let output = Domain { shape, periodic: [rng.below(2) == 0, rng.below(2) == 0] };
        // Anywhere, also where they are not defined; the first two everywhere together.
        let any = |rng: &mut Rng| std::array::from_fn(|a| rng.below(9 + shape[a]) as i32 - 9);
        let mut labels = vec![Label { source: 0, offset: [0, 0] }, Label { source: 0, offset: [3, 2] }];
        labels.extend((0..6).map(|_| Label { source: 0, offset: any(&mut rng) }));
        let fixed = (case % 2 == 0).then(|| {
            let samples = (0..output.len()).map(|_| rng.below(5) == 0).collect();
            Grid::from_vec(output, 1, samples).unwrap()
        });
        let own = (case % 3 == 0).then(|| prices(&mut rng, output, labels.len()));
        let options = LabelOptions { own: own.clone(), leave_holes: true, ..LabelOptions::default() };
        let mut start = empty(&e, output);
        start.fixed.clone_from(&fixed);
        let woven = expand(&e, start, &labels, &options, &Run::seeded(0)).unwrap();
        let stats = &woven.stats;
        assert!(stats.energy.is_sorted_by(|a, b| a >= b), "case {case}: {:?}", stats.energy);
        let mut price = SeamCosts::new(&e, options.seam).unwrap().total(&woven.result);
        if let Some(own) = &own {
            // Labels of one sample are told apart by their prices alone: compare only where none are alike.
            let sum = |map: &SourceMap<2>| -> Option<i64> {
                let mut sum = 0;
                for (place, at) in output.positions().enumerate() {
                    let Some((_, from)) = map.locate(at) else { continue };
                    let shows = |label: &Label<2>| {
                        (0..2).all(|a| {
                            let by = at[a] as i32 - label.offset[a] - from[a] as i32;
                            by == 0 || output.periodic[a] && by.rem_euclid(shape[a] as i32) == 0
                        })
                    };
                    let mut shown = (0..labels.len()).filter(|&label| shows(&labels[label]));
                    let label = shown.next()?;
                    sum += i64::from(own.plane(label)[place]);
                    if shown.next().is_some() {
                        return None;
                    }
                }
                Some(sum)
            };
            let Some(own) = sum(&woven.result) else { continue };
            price += own;
        }
        assert_eq!(*stats.energy.last().unwrap(), price, "case {case}");
        assert_eq!(woven.result.holes(), stats.holes);
        assert_eq!(stats.shown.iter().sum::<u64>() as usize, output.len() - stats.holes);
        improved += stats.improvements;
    }
    assert!(60 < improved, "only {improved} expansions improved anything");
}

#[test]
fn what_is_fixed_stays_and_what_must_show_shows() {
    let (e, output) = (exemplars([20, 20], 3), Domain::open([9, 9]));
    let labels = covering(&mut Seed(3).rng(), 4);
    let mut start = empty(&e, output);
    let mut fixed = Grid::try_filled(output, 1, false).unwrap();
    for at in [[4, 4], [0, 8]] {
        fixed.set(0, at, true);
        start.map.ids.set(0, at, e.table().id(0, [19, 19]));
    }
    start.fixed = Some(fixed);
    let mut only = Grid::try_filled(output, 1, 0b1111).unwrap();
    only.set(0, [2, 2], 0b0100);
    let options = LabelOptions { only: Some(only), ..LabelOptions::default() };
    let woven = expand(&e, start, &labels, &options, &Run::seeded(0)).unwrap();
    assert_eq!(woven.result.locate([4, 4]), Some((0, [19, 19])));
    assert_eq!(woven.result.locate([0, 8]), Some((0, [19, 19])));
    assert_eq!(woven.result.ids.get(0, [2, 2]), sample(&e, &labels[2], [2, 2]));
    assert!(woven.complete);
}

#[test]
fn wrong_labels_are_refused_by_name() {
    let (e, output) = (exemplars([4, 4], 0), Domain::open([4, 6]));
    let here = Label { source: 0, offset: [0, 0] };
    let error = |labels: &[Label<2>], options: &LabelOptions<2>| {
        expand(&e, empty(&e, output), labels, options, &Run::seeded(0)).unwrap_err()
    };
    let usual = LabelOptions::default();
    assert_eq!(error(&[here], &usual), Error::NoLabel { at: vec![0, 4], places: 8 });
    assert_eq!(error(&[], &usual), Error::Labels { found: 0 });
    assert_eq!(error(&[here; 65], &usual), Error::Labels { found: 65 });
    let missing = Label { source: 1, ..here };
    assert_eq!(error(&[missing], &usual), Error::LabelSource { number: 1, sources: 1 });
    let only = Some(Grid::try_filled(Domain::open([4, 4]), 1, 1).unwrap());
    assert!(matches!(error(&[here], &LabelOptions { only, ..usual.clone() }), Error::Core(_)));
    let own = Some(Grid::try_filled(output, 2, 1).unwrap());
    assert!(matches!(error(&[here], &LabelOptions { own, ..usual.clone() }), Error::Core(_)));
    let left = LabelOptions { leave_holes: true, ..usual };
    let woven = expand(&e, empty(&e, output), &[here], &left, &Run::seeded(0)).unwrap();
    assert_eq!((woven.stats.holes, woven.result.holes()), (8, 8));
}

#[test]
fn a_run_that_is_cancelled_keeps_what_it_has() {
    struct Stop;
    impl Observer<2> for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let (e, output) = (exemplars([30, 30], 7), Domain::open([12, 12]));
    let labels = covering(&mut Seed(7).rng(), 5);
    let run = Run { observer: &Stop, ..Run::seeded(0) };
    let woven = expand(&e, empty(&e, output), &labels, &LabelOptions::default(), &run).unwrap();
    assert!(!woven.complete && woven.result.holes() == 0);
}

#[test]
fn three_dimensions_equal_two_on_one_frame() {
    let e = exemplars([20, 24], 11);
    let deep = {
        let plane = &e.sources()[0].features;
        let features = Grid::from_vec(Domain::open([1, 20, 24]), 1, plane.plane(0).to_vec()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
    };
    let labels = covering(&mut Seed(5).rng(), 6);
    let only = field(&mut Seed(6).rng(), Domain::open([10, 12]), 6);
    let only_3 = Grid::from_vec(Domain::open([1, 10, 12]), 1, only.plane(0).to_vec()).unwrap();
    let options = LabelOptions { only: Some(only), ..LabelOptions::default() };
    let woven = expand(&e, empty(&e, Domain::open([10, 12])), &labels, &options, &Run::seeded(0)).unwrap();
    let labels_3: Vec<Label<3>> =
        labels.iter().map(|l| Label { source: 0, offset: [0, l.offset[0], l.offset[1]] }).collect();
    let map = SourceMap::unassigned(&deep, Domain::open([1, 10, 12])).unwrap();
    let start = Start { map, fixed: None, sources: None };
    let options = LabelOptions { only: Some(only_3), ..LabelOptions::default() };
    let woven_3 = expand(&deep, start, &labels_3, &options, &Run::seeded(0)).unwrap();
    assert_eq!(woven.result.ids.plane(0), woven_3.result.ids.plane(0));
    assert_eq!((&woven.stats, woven.stats.improvements > 0), (&woven_3.stats, true));
}
