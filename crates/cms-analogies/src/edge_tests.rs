//! At the edges of what is allowed: constant pictures, outputs that go around and are smaller than an exemplar.

use crate::agreement::Term;
use crate::labelling::Labelling;
use crate::ranking::Ranking;
use crate::{Constraint, Options, analogy};
use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Run, Seed, Source, SourceMap, Start, Transform};

/// One exemplar of one channel, all of which is valid.
pub(crate) fn of_one(features: Grid<u8, 2>) -> Exemplars<2> {
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
}

/// Exemplars longer than an output that goes around: any part of them may show, not their first corner alone.
#[test]
fn every_sample_can_show_in_a_smaller_output_that_goes_around() {
    let source = Domain::open([40, 48]);
    let right = |at: [u32; 2]| u8::from(24 <= at[1]) * 200;
    let map = |domain: Domain<2>, value: &dyn Fn([u32; 2]) -> u8| {
        Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap()
    };
    let valid = Grid::from_vec(source, 1, source.positions().map(|[y, x]| 20 <= y && 20 <= x).collect()).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let features = map(source, &|[y, x]| (y * 5 + x * 3) as u8);
    for valid in [None, Some(valid)] {
        let sources = vec![Source { features: features.clone(), valid: valid.map(Into::into), origin }];
        let exemplars = Exemplars::from_sources(sources, vec![1]).unwrap();
        let output = Domain::periodic([12, 15]);
        let guide = Guide::new(&exemplars, &[map(source, &right)], map(output, &|_| 200)).unwrap();
        let constraints = vec![Constraint { guide, ratio: 1, weight: 1.0 }];
        for random_labels in [None, Some(5)] {
            let options = Options { constraint_weight: 30.0, neighborhood: 1, random_labels, ..Options::paper() };
            let woven = analogy(&exemplars, &constraints, &options, &Run::seeded(2)).unwrap();
            assert_eq!(woven.result.holes(), 0);
            let shows = |i: usize| exemplars.locate(woven.result.ids.plane(0)[i]).unwrap().1;
            let follows = (0..output.len()).all(|i| 24 <= shows(i)[1]);
            assert!(follows || random_labels.is_some(), "the label is in the right half");
        }
    }
}

#[test]
fn constant_pictures_end() {
    for (value, target) in [(7, 7), (0, 255)] {
        let domain = Domain::open([9, 9]);
        let flat = |value| Grid::try_filled(domain, 1, value).unwrap();
        let exemplars = of_one(flat(value));
        let guide =
            Guide::new(&exemplars, &[flat(value)], Grid::try_filled(Domain::open([30, 20]), 1, target).unwrap());
        let options = Options { tolerance: Some(0.0), ..Options::paper() };
        let woven = analogy(&exemplars, &[Constraint::new(guide.unwrap())], &options, &Run::seeded(0)).unwrap();
        assert_eq!((woven.result.holes(), woven.stats.model.boundary), (0, 0));
    }
}

/// A picture of grey noise under labels of its left and right half, in channels of a weight, and an output that asks
/// for stripes.
fn striped(channels: usize, weight: u8, weight_of_constraint: f64) -> (Exemplars<2>, Vec<Constraint>) {
    let mut rng = Seed(5).rng();
    let source = Domain::open([18, 20]);
    let grey: Vec<u8> = (0..source.len()).map(|_| rng.below(256) as u8).collect();
    let features = Grid::from_vec(source, channels, grey.repeat(channels)).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let exemplars =
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![weight; channels]).unwrap();
    let map = |domain: Domain<2>, is_light: &dyn Fn([u32; 2]) -> bool| {
        let samples = domain.positions().map(|at| if is_light(at) { 90 } else { 20 }).collect();
        Grid::from_vec(domain, 1, samples).unwrap()
    };
    let target = map(Domain::open([16, 24]), &|[y, x]| (y / 4 + x / 7) % 2 == 0);
    let guide = Guide::new(&exemplars, &[map(source, &|[_, x]| 9 < x)], target).unwrap();
    (exemplars, vec![Constraint { guide, ratio: 1, weight: weight_of_constraint }])
}

#[test]
fn constraints_weigh_the_same_whatever_channels_the_exemplars_have() {
    let options = Options { neighborhood: 1, apart: 3, tolerance: Some(0.05), ..Options::paper() };
    let of = |channels, weight, k| {
        let (exemplars, constraints) = striped(channels, weight, 1.0);
        let options = Options { constraint_weight: k, ..options.clone() };
        analogy(&exemplars, &constraints, &options, &Run::seeded(0)).unwrap().result.ids
    };
    for k in [0.1, 1.0] {
        let one = of(1, 1, k);
        assert!(of(1, 4, k) == one, "a heavier channel, {k}");
        assert!(of(3, 1, k) == one, "three channels, {k}");
        assert!(of(1, 1, 4.0 * k) != one, "K decides, {k}");
    }
}

#[test]
fn what_weighs_nothing_is_not_searched() {
    let (exemplars, mut constraints) = striped(1, 1, 0.0);
    constraints.push(striped(1, 1, 2.0).1.remove(0));
    assert_eq!(Term::list(&exemplars, &constraints, &Options::paper()).len(), 1);
    let none = Options { constraint_weight: 0.0, ..Options::paper() };
    assert!(Term::list(&exemplars, &constraints, &none).is_empty());
}

#[test]
fn seams_are_bad_where_neighborhoods_are_single_samples() {
    let (exemplars, constraints) = striped(1, 1, 1.0);
    let options = Options { constraint_weight: 0.0, neighborhood: 0, ..Options::paper() };
    let mut map = SourceMap::unassigned(&exemplars, Domain::open([16, 24])).unwrap();
    // Two patches, beside each other.
    map.domain().positions().for_each(|at| {
        let id = exemplars.table().id(0, [at[0] % 18, if at[1] < 12 { at[1] } else { at[1] - 10 }]);
        map.ids.set(0, at, id);
    });
    let terms = Term::list(&exemplars, &constraints, &options);
    let labelling = Labelling::new(&exemplars, terms, map, None, &options).unwrap();
    let places = labelling.worst.places(1, 1);
    let column = labelling.map.domain().position(places[0])[1];
    assert!([11, 12].contains(&column), "{column}");
}

/// Watches nothing, and wants no more.
struct Enough;

impl selvedge_core::Observer<2> for Enough {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_run_that_is_cancelled_searches_no_more() {
    let (exemplars, constraints) = striped(1, 1, 1.0);
    for random_labels in [None, Some(100)] {
        let options = Options { random_labels, ..Options::paper() };
        let run = Run { observer: &Enough, ..Run::seeded(0) };
        let woven = analogy(&exemplars, &constraints, &options, &run).unwrap();
        assert_eq!((woven.complete, woven.stats.searches), (false, 0));
    }
}

#[test]
fn the_best_of_many_labels_are_the_first_of_equal_ones_on_any_threads() {
    let source = Domain::open([150, 160]);
    let flat = |domain| Grid::try_filled(domain, 1, 7).unwrap();
    let exemplars = of_one(flat(source));
    let output = Domain::open([9, 9]);
    let constraints = [Constraint::new(Guide::new(&exemplars, &[flat(source)], flat(output)).unwrap())];
    let options = Options { candidates: 40, ..Options::paper() };
    let map = SourceMap::unassigned(&exemplars, output).unwrap();
    let terms = Term::list(&exemplars, &constraints, &options);
    let labelling = Labelling::new(&exemplars, terms, map, None, &options).unwrap();
    let mut expected: Vec<[u32; 2]> = Vec::new();
    for at in source.positions() {
        let far = |p: &[u32; 2]| 400 <= (0..2).map(|a| p[a].abs_diff(at[a]).pow(2)).sum::<u32>();
        if expected.len() < 40 && expected.iter().all(far) {
            expected.push(at);
        }
    }
    for threads in 1..4 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let labels = || {
            let mut ranking = Ranking::new(&exemplars, &labelling, &options, Default::default()).unwrap();
            ranking.labels(&labelling, &[true], [4, 4]).unwrap()
        };
        let found: Vec<[u32; 2]> = pool.install(labels).iter().map(|p| p.offset.map(|o| (4 - o) as u32)).collect();
        assert_eq!(found, expected, "{threads}");
    }
}

#[test]
fn a_source_that_may_not_be_used_everywhere_is_not_used() {
    let mut rng = Seed(9).rng();
    let mut source = |exemplar| {
        let domain = Domain::open([14, 14]);
        let features = Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap();
        Source { features, valid: None, origin: Origin { exemplar, transform: Transform::IDENTITY } }
    };
    let exemplars = Exemplars::from_sources(vec![source(0), source(1)], vec![1]).unwrap();
    let maps = [0, 1].map(|s| exemplars.sources()[s].features.clone());
    let output = Domain::open([20, 20]);
    let constraints =
        [Constraint::new(Guide::new(&exemplars, &maps, Grid::try_filled(output, 1, 99).unwrap()).unwrap())];
    let sources = Grid::from_vec(output, 1, output.positions().map(|[y, _]| if y < 5 { 2 } else { 3 }).collect());
    for random_labels in [None, Some(9)] {
        let map = SourceMap::unassigned(&exemplars, output).unwrap();
        let start = Start { map, fixed: None, sources: Some(sources.clone().unwrap()) };
        let options = Options { random_labels, ..Options::paper() };
        let woven = crate::analogy_from(&exemplars, &constraints, &start, &options, &Run::seeded(0)).unwrap();
        assert!(output.positions().all(|at| woven.result.locate(at).unwrap().0 == 1));
    }
}

/// Each of two sources may be used in one half, so that none may be everywhere.
#[test]
fn where_no_source_may_be_used_runs_end_with_a_word() {
    let domain = Domain::open([14, 14]);
    let flat = |domain| Grid::try_filled(domain, 1, 5).unwrap();
    let source = |exemplar| Source {
        features: flat(domain),
        valid: None,
        origin: Origin { exemplar, transform: Transform::IDENTITY },
    };
    let exemplars = Exemplars::from_sources(vec![source(0), source(1)], vec![1]).unwrap();
    let output = Domain::open([20, 20]);
    let guide = Guide::new(&exemplars, &[flat(domain), flat(domain)], flat(output)).unwrap();
    let halves = output.positions().map(|[y, _]| if y < 10 { 1 } else { 2 }).collect();
    let sources = Grid::from_vec(output, 1, halves).unwrap();
    for random_labels in [None, Some(9)] {
        let map = SourceMap::unassigned(&exemplars, output).unwrap();
        let start = Start { map, fixed: None, sources: Some(sources.clone()) };
        let options = Options { random_labels, ..Options::paper() };
        let constraints = [Constraint::new(guide.clone())];
        let error = crate::analogy_from(&exemplars, &constraints, &start, &options, &Run::seeded(0)).unwrap_err();
        assert!(matches!(error, crate::Error::Core(selvedge_core::Error::NoSource { .. })), "{error}");
    }
}

/// A picture whose left part is flat and whose right part is noise, under one label: without spread most is flat.
#[test]
fn outputs_spread_over_what_agrees_alike() {
    let mut rng = Seed(3).rng();
    let source = Domain::open([24, 48]);
    let features = source.positions().map(|[_, x]| if 24 <= x { rng.below(256) as u8 } else { 40 }).collect();
    let exemplars = of_one(Grid::from_vec(source, 1, features).unwrap());
    let flat = |domain| Grid::try_filled(domain, 1, 9).unwrap();
    let output = Domain::open([70, 70]);
    let constraints = [Constraint::new(Guide::new(&exemplars, &[flat(source)], flat(output)).unwrap())];
    let noisy = |spread: f64| {
        let options = Options { neighborhood: 2, spread, tolerance: Some(0.1), ..Options::paper() };
        let woven = analogy(&exemplars, &constraints, &options, &Run::seeded(0)).unwrap();
        let (energy, last) = (&woven.stats.energy, woven.stats.model.sum());
        assert!(energy.windows(2).all(|pair| pair[1] < pair[0]), "{energy:?}");
        assert_eq!(energy.last().copied().unwrap_or(last), last);
        let shows = |at| 24 <= woven.result.locate(at).unwrap().1[1];
        output.positions().filter(|&at| shows(at)).count() as f64 / output.len() as f64
    };
    let (without, with) = (noisy(0.0), noisy(0.4));
    assert!(without < 0.25 && 0.4 < with && with < 0.6, "{without} {with}");
}

#[test]
fn what_is_masked_under_an_exemplar_never_shows() {
    let mut rng = Seed(8).rng();
    let (source, output) = (Domain::open([30, 40]), Domain::open([48, 44]));
    let mut noise = |domain: Domain<2>| {
        Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap()
    };
    let exemplars = of_one(noise(source));
    let known = |[y, x]: [u32; 2]| !(6..24).contains(&y) || !(8..30).contains(&x);
    let mask = Grid::from_vec(source, 1, source.positions().map(known).collect()).unwrap();
    let guide = Guide::new(&exemplars, &[noise(source)], noise(output)).unwrap().knowing(&[Some(mask)]).unwrap();
    let constraints = [Constraint::new(guide)];
    for (neighborhood, levels, random_labels) in [(1, Some(1), None), (2, None, None), (0, Some(1), Some(30))] {
        let options = Options { neighborhood, levels, random_labels, ..Options::paper() };
        let woven = analogy(&exemplars, &constraints, &options, &Run::seeded(0)).unwrap();
        let shown = |at| woven.result.locate(at).is_some_and(|(_, from)| known(from));
        assert!(output.positions().all(shown), "{neighborhood} {levels:?} {random_labels:?}");
    }
}
