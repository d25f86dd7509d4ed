//! Each fast part against its definition, and what holds of every run.

use selvedge_core::{
    Domain, Error as CoreError, Exemplars, Grid, Guide, Origin, Patch, Rng, Run, SampleId, Seed, SimdLevel, Source,
    SourceMap, Start, Transform, Window,
};

use crate::agreement::{Term, of_label, of_sample};
use crate::boxes::Boxes;
use crate::constraint::{MOST_AGREEMENT, Scale, unit};
use crate::labelling::Labelling;
use crate::plan::Plan;
use crate::ranking::Ranking;
use crate::stats::{Energy, Stats};
use crate::uses::Uses;
use crate::{Constraint, Error, Options, analogy};

/// A small case: exemplars of which one is masked and one is turned, a constraint or two, options.
pub(crate) struct Case {
    pub(crate) exemplars: Exemplars<2>,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) options: Options,
}

fn grid(rng: &mut Rng, domain: Domain<2>, channels: usize, values: u32) -> Grid<u8, 2> {
    // Few values that lie far apart, in patches: a texture that has seams, and ties.
    let step = 255 / values.max(2);
    let coarse: Vec<u8> = (0..64 * channels).map(|_| (rng.below(values) * step) as u8).collect();
    let at = |c: usize, [y, x]: [u32; 2]| coarse[c * 64 + (y / 3 % 8 * 8 + x / 2 % 8) as usize];
    let samples = (0..channels).flat_map(|c| domain.positions().map(move |p| at(c, p)).collect::<Vec<_>>()).collect();
    Grid::from_vec(domain, channels, samples).unwrap()
}

pub(crate) fn case(seed: u64) -> Case {
    let mut rng = Seed(seed).rng();
    let half = rng.below(3);
    let ratios: Vec<u32> = (0..1 + rng.below(2)).map(|_| 1 + rng.below(3)).collect();
    let least = 2 * half * ratios.iter().max().unwrap() + 1;
    let mut side = |more: u32| least.max(4) + rng.below(more);
    let shapes = [[side(8), side(8)], [side(5), side(5)]];
    let output = Domain { shape: [side(14), side(14)], periodic: [seed.is_multiple_of(3), seed.is_multiple_of(5)] };
    let channels = 1 + rng.below(3) as usize;
    let mut source = |exemplar: u16, periodic: [bool; 2], masked: bool| {
        let domain = Domain { shape: shapes[usize::from(exemplar)], periodic };
        let valid = masked.then(|| {
            let valid = (0..domain.len()).map(|_| rng.below(6) != 0).collect();
            Grid::from_vec(domain, 1, valid).unwrap()
        });
        let origin = Origin { exemplar, transform: Transform::IDENTITY };
        Source { features: grid(&mut rng, domain, channels, 6), valid: valid.map(Into::into), origin }
    };
    let sources = vec![source(0, [false; 2], false), source(1, [false, seed.is_multiple_of(4)], true)];
    let exemplars = Exemplars::from_sources(sources, vec![1; channels]).unwrap();
    let constraint = |&ratio: &u32| {
        let channels = 1 + rng.below(3) as usize;
        let maps: Vec<_> = shapes.iter().map(|&s| grid(&mut rng, Domain::open(s), channels, 4)).collect();
        let mut guide = Guide::new(&exemplars, &maps, grid(&mut rng, output, channels, 4)).unwrap();
        if rng.below(2) == 0 {
            let asked = (0..output.len()).map(|_| rng.below(5) != 0).collect();
            guide = guide.asking(Grid::from_vec(output, 1, asked).unwrap()).unwrap();
        }
        Constraint { guide, ratio, weight: 0.5 + f64::from(rng.below(4)) }
    };
    let constraints = ratios.iter().map(constraint).collect();
    let options = Options {
        constraint_weight: [0.05, 0.4, 3.0, 30.0][seed as usize % 4],
        neighborhood: half,
        apart: 1 + (seed % 3) as u32,
        tolerance: Some([0.0, 0.3, 2.0][seed as usize % 3]),
        spread: [0.0, 0.2, 0.0, 0.02][seed as usize / 3 % 4],
        ..Options::paper()
    };
    Case { exemplars, constraints, options }
}

impl Case {
    pub(crate) fn output(&self) -> Domain<2> {
        self.constraints[0].guide.target().domain()
    }

    pub(crate) fn weave(&self, pruning: bool) -> (SourceMap<2>, Stats) {
        let run = Run::seeded(1);
        let plan = Plan::new(&self.exemplars, &self.constraints, &self.options, &run).unwrap();
        let map = SourceMap::unassigned(&self.exemplars, self.output()).unwrap();
        let woven = plan.weave_by(&Start { map, fixed: None, sources: None }, &run, pruning).unwrap();
        assert!(woven.complete);
        (woven.result, woven.stats)
    }

    /// `K SSD` over a neighborhood, tap by tap; `sample` is what `Q` shows at a place, how far that is from `at`.
    fn naive(&self, at: [u32; 2], sample: impl Fn([u32; 2], [i32; 2]) -> Option<SampleId>) -> f64 {
        let half = self.options.neighborhood as i32;
        let of = |c: &Constraint| {
            let (guide, r) = (&c.guide, c.ratio as i32);
            let (mut sum, mut taps) = (0_u64, 0_u64);
            for by in (-half..=half).flat_map(|y| (-half..=half).map(move |x| [y * r, x * r])) {
                let Some(p) = self.output().step(at, by) else { continue };
                if guide.asked().is_some_and(|a| !a.get(0, p)) {
                    taps += 1;
                    continue;
                }
                let Some((s, q)) = sample(p, by).and_then(|id| self.exemplars.locate(id)) else { continue };
                let source = &guide.exemplars().sources()[s];
                taps += 1;
                for (ch, &w) in guide.weights().iter().enumerate() {
                    let d = u64::from(source.features.get(ch, q).abs_diff(guide.target().get(ch, p)));
                    sum += d * d * u64::from(w);
                }
            }
            let weights: f64 = guide.weights().iter().map(|&w| f64::from(w)).sum();
            let all = f64::from((2 * half + 1).pow(2));
            let mean = if taps == 0 { 0.0 } else { sum as f64 / taps as f64 };
            unit(&self.exemplars) * self.options.constraint_weight * c.weight * 3.0 / weights * 16.0 / 255.0
                * mean
                * all
        };
        self.constraints.iter().map(of).sum::<f64>()
    }
}

/// What a map shows.
fn uses_of(case: &Case, map: &SourceMap<2>) -> Uses {
    let mut uses = Uses::new(&case.exemplars, map.domain().len(), case.options.spread).unwrap();
    map.ids.samples().iter().for_each(|&id| uses.replace(SampleId::UNASSIGNED, id));
    uses
}

/// Up to the rounding of factors.
fn close(found: i64, expected: f64) -> bool {
    let expected = expected.min(f64::from(MOST_AGREEMENT));
    (found as f64 - expected).abs() <= 2.0 + expected * 1e-3
}

/// The sample of a patch that shows at a position `by` away from `at`, not around the output's border.
pub(crate) fn shown(case: &Case, patch: &Patch<2>, at: [i32; 2]) -> Option<SampleId> {
    let window = Window { start: at, shape: [1, 1] };
    patch.samples(&case.exemplars, &window).next().filter(|id| id.is_assigned())
}

#[test]
fn agreement_is_that_of_the_definition() {
    let mut boxes = Boxes::default();
    for seed in 0..80 {
        let case = case(seed);
        let output = case.output();
        let mut rng = Seed(seed).derive("label", 0).rng();
        let source = rng.below(2) as usize;
        let offset = [0, 1].map(|a| rng.below(output.shape[a]) as i32 - 4);
        let patch = Patch { source, offset };
        let window = patch.footprint(&case.exemplars, &Window::all(output)).inside(output);
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let mut costs = Vec::new();
        of_label(&terms, &patch, &window, &mut boxes, &mut Vec::new(), &mut costs).unwrap();
        for (local, &cost) in window.local().positions().zip(&costs) {
            let at = window.position(output, local).unwrap();
            // Not by place: around a periodic output a label may show at one place twice.
            let here = [0, 1].map(|a| window.start[a] + local[a] as i32);
            let Some(id) = shown(&case, &patch, here) else { continue };
            let expected = case.naive(at, |_, by| shown(&case, &patch, [0, 1].map(|a| here[a] + by[a])));
            assert!(close(cost.into(), expected), "{seed}: {cost} for {expected}");
            assert_eq!(of_sample(&terms, &case.exemplars, at, id), cost);
        }
    }
}

#[test]
fn labels_are_the_best_of_all() {
    for seed in 0..40 {
        let case = case(seed);
        let (output, half) = (case.output(), case.options.neighborhood as i32);
        let (map, _) = case.weave(true);
        let mut rng = Seed(seed).derive("place", 0).rng();
        let at = output.position(rng.below(output.len() as u32) as usize);
        let standing = map.ids.get(0, at);
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let mut holed = map.clone();
        for id in holed.ids.plane_mut(0) {
            if rng.below(4) == 0 {
                *id = SampleId::UNASSIGNED;
            }
        }
        let at_id = output.index(at);
        holed.ids.plane_mut(0)[at_id] = standing;
        let (o, features) = (holed.clone(), |id: SampleId| {
            let (s, p) = case.exemplars.locate(id).unwrap();
            let grid = &case.exemplars.sources()[s].features;
            (0..grid.channels()).map(move |c| grid.get(c, p)).collect::<Vec<u8>>()
        });
        let labelling = Labelling::new(&case.exemplars, terms.clone(), holed, None, &case.options).unwrap();
        let mut ranking = Ranking::new(&case.exemplars, &labelling, &case.options, SimdLevel::Auto).unwrap();
        let found = ranking.labels(&labelling, &[true; 2], at).unwrap();
        let (taps, uses) = (u64::from(2 * half as u32 + 1).pow(2), uses_of(&case, &o));
        let scale = Scale::new(unit(&case.exemplars), case.exemplars.weights(), taps);
        // eq. 8 by its definition.
        let value = |id: SampleId| -> Option<u64> {
            let (source, from) = case.exemplars.locate(id)?;
            let patch = Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) };
            shown(&case, &patch, at.map(|p| p as i32)).filter(|_| id != standing)?;
            let (mut sum, mut compared, mut known) = (0, 0, 0);
            for by in (-half..=half).flat_map(|y| (-half..=half).map(move |x| [y, x])) {
                let Some(p) = output.step(at, by).filter(|&p| o.ids.get(0, p).is_assigned()) else { continue };
                known += 1;
                let Some(other) = shown(&case, &patch, [0, 1].map(|a| at[a] as i32 + by[a])) else { continue };
                compared += 1;
                let pair = features(other).into_iter().zip(features(o.ids.get(0, p)));
                sum += pair.map(|(a, b)| u64::from(a.abs_diff(b)).pow(2)).sum::<u64>();
            }
            let window = Window { start: at.map(|p| p as i32), shape: [1, 1] };
            let of =
                |term: &Term<'_>| term.scale.of_packed(term.sums(&patch, &window, &mut Boxes::default()).unwrap()[0]);
            let used = taps * uses.scaled_of(id.get() as usize);
            Some(scale.over(known).of(sum, compared) + terms.iter().map(of).sum::<u64>() + used)
        };
        let all = (0..case.exemplars.table().len()).map(SampleId::new);
        let mut ranked: Vec<(u64, SampleId)> = all.filter_map(|id| Some((value(id)?, id))).collect();
        ranked.sort();
        let mut expected: Vec<(usize, [u32; 2])> = Vec::new();
        for (_, id) in ranked {
            let (source, p) = case.exemplars.locate(id).unwrap();
            let domain = case.exemplars.sources()[source].domain();
            let near = |&(s, q): &(usize, [u32; 2])| {
                if s != source {
                    return false;
                }
                let d = [0, 1].map(|a| {
                    let d = p[a].abs_diff(q[a]);
                    if domain.periodic[a] { d.min(domain.shape[a] - d) } else { d }
                });
                d[0].pow(2) + d[1].pow(2) < case.options.apart.pow(2)
            };
            if expected.len() < case.options.candidates as usize && !expected.iter().any(near) {
                expected.push((source, p));
            }
        }
        let patch =
            |&(source, p): &(usize, [u32; 2])| Patch { source, offset: [0, 1].map(|a| at[a] as i32 - p[a] as i32) };
        assert_eq!(found, expected.iter().map(patch).collect::<Vec<_>>(), "{seed}");
    }
}

#[test]
fn energies_never_rise_and_are_those_of_the_map() {
    let mut truncated = 0;
    for seed in 0..60 {
        let case = case(seed);
        let (map, stats) = case.weave(true);
        assert_eq!(map.holes(), 0, "{seed}: nothing of the dummy label is left");
        assert!(stats.energy.windows(2).all(|pair| pair[1] < pair[0]), "{seed}: {:?}", stats.energy);
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let seams = selvedge_core::SeamCosts::new(&case.exemplars, selvedge_core::SeamMeasure::Difference).unwrap();
        let places = map.domain().positions();
        let own = places.map(|p| i64::from(of_sample(&terms, &case.exemplars, p, map.ids.get(0, p)))).sum();
        let recounted = Energy { agreement: own, boundary: seams.total(&map), usage: uses_of(&case, &map).energy() };
        assert_eq!(stats.model, recounted, "{seed}");
        assert!(stats.energy.last().is_none_or(|&last| last == recounted.sum()));
        let truth: f64 = map.domain().positions().map(|p| case.naive(p, |q, _| Some(map.ids.get(0, q)))).sum();
        let rounded = map.domain().len() as f64;
        assert!((stats.truth.agreement as f64 - truth).abs() <= rounded + truth * 1e-3, "{seed}: {truth}");
        truncated += stats.truncated;
    }
    assert!(0 < truncated, "where a patch ends at a seam, prices are no metric");
}

#[test]
fn pruning_changes_nothing_but_the_time() {
    let mut pruned = 0;
    for seed in 0..40 {
        let case = case(seed);
        let ((with, stats), (without, all)) = (case.weave(true), case.weave(false));
        // A term that is lowered for samples not decided yet makes another model.
        if all.truncated == 0 {
            assert!(with == without, "{seed}");
            pruned += stats.pruned;
        }
    }
    assert!(500 < pruned, "{pruned}");
}

#[test]
fn without_weight_constraints_say_nothing_and_with_much_they_say_all() {
    for seed in 0..20 {
        let mut case = case(seed);
        case.options.constraint_weight = 0.0;
        let (free, stats) = case.weave(true);
        let output = case.output();
        assert_eq!(stats.model.agreement, 0);
        for constraint in &mut case.constraints {
            let channels = constraint.guide.weights().len();
            let other = Grid::try_filled(output, channels, 200).unwrap();
            constraint.guide = constraint.guide.clone().with_target(other).unwrap();
        }
        let (other, _) = case.weave(true);
        assert_eq!(free, other, "{seed}");
    }
}

/// Each label in a half of the exemplar, and the target asks for them in other places: all samples are of the right
/// label.
#[test]
fn a_heavy_constraint_is_followed_everywhere() {
    let mut rng = Seed(3).rng();
    let source = Domain::open([24, 24]);
    let features = Grid::from_vec(source, 1, (0..source.len()).map(|_| rng.below(256) as u8).collect()).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
    let labels = |domain: Domain<2>, f: &dyn Fn([u32; 2]) -> bool| {
        Grid::from_vec(domain, 1, domain.positions().map(|p| if f(p) { 255 } else { 0 }).collect()).unwrap()
    };
    let map = labels(source, &|[_, x]| 12 <= x);
    let target = labels(Domain::open([30, 40]), &|[y, x]| (y / 8 + x / 10) % 2 == 0);
    let guide = Guide::new(&exemplars, &[map], target.clone()).unwrap();
    let options =
        Options { constraint_weight: 500.0, neighborhood: 0, apart: 3, tolerance: Some(0.0), ..Options::paper() };
    let woven = analogy(&exemplars, &[Constraint::new(guide.clone())], &options, &Run::seeded(0)).unwrap();
    for p in target.domain().positions() {
        let (_, from) = woven.result.locate(p).unwrap();
        assert_eq!(12 <= from[1], target.get(0, p) == 255, "{p:?}");
    }
    // Two equal constraints of half the weight are one.
    let half = Constraint { guide, ratio: 1, weight: 0.5 };
    let twice = analogy(&exemplars, &[half.clone(), half], &options, &Run::seeded(0)).unwrap();
    assert_eq!(twice.result, woven.result);
}

#[test]
fn threads_and_instructions_change_nothing() {
    for seed in 0..12 {
        let case = case(seed);
        let (expected, _) = case.weave(true);
        for (threads, simd) in [(1, SimdLevel::Scalar), (2, SimdLevel::Avx2), (3, SimdLevel::Auto)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let run = Run { simd, ..Run::seeded(1) };
            let woven = pool.install(|| analogy(&case.exemplars, &case.constraints, &case.options, &run)).unwrap();
            assert_eq!(woven.result, expected, "{seed} {threads}");
        }
    }
}

#[test]
fn random_labels_cover_everything_and_search_does_better() {
    let mut better = 0;
    for seed in 0..20 {
        let case = case(seed);
        let (_, searched) = case.weave(true);
        let options = Options { random_labels: Some(searched.searches.max(1) as u32), ..case.options.clone() };
        let random = analogy(&case.exemplars, &case.constraints, &options, &Run::seeded(seed)).unwrap();
        assert_eq!(random.result.holes(), 0);
        better += u32::from(searched.model.sum() <= random.stats.model.sum());
    }
    assert!(15 <= better, "{better} of 20");
}

#[test]
fn a_run_goes_on_from_a_map_and_keeps_what_is_fixed() {
    for seed in 0..20 {
        let case = case(seed);
        let (map, stats) = case.weave(true);
        let fixed = Grid::try_filled(map.domain(), 1, true).unwrap();
        let other = Options { constraint_weight: 9.0, ..case.options.clone() };
        let run = Run::seeded(0);
        let start = Start { map: map.clone(), fixed: Some(fixed), sources: None };
        let kept = crate::analogy_from(&case.exemplars, &case.constraints, &start, &other, &run).unwrap();
        assert_eq!(kept.result, map, "{seed}");
        let mut rng = Seed(seed).rng();
        let half: Vec<bool> = (0..map.domain().len()).map(|_| rng.below(2) == 0).collect();
        let mut begun = map.clone();
        let hole = |i: usize| i.is_multiple_of(7);
        (0..half.len()).filter(|&i| hole(i)).for_each(|i| begun.ids.plane_mut(0)[i] = SampleId::UNASSIGNED);
        let fixed = Grid::from_vec(map.domain(), 1, half.clone()).unwrap();
        let start = Start { map: begun, fixed: Some(fixed), sources: None };
        let went = crate::analogy_from(&case.exemplars, &case.constraints, &start, &other, &run).unwrap().result;
        assert_eq!(went.holes(), 0, "{seed}: fixed holes are filled as well");
        let ids = |map: &SourceMap<2>, i: usize| map.ids.plane(0)[i];
        assert!((0..half.len()).all(|i| hole(i) || !half[i] || ids(&went, i) == ids(&map, i)), "{seed}");
        let start = Start { map, fixed: None, sources: None };
        let again = crate::analogy_from(&case.exemplars, &case.constraints, &start, &case.options, &run).unwrap();
        assert!(again.stats.model.sum() <= stats.model.sum(), "{seed}");
    }
}

#[test]
fn what_does_not_fit_is_refused_with_its_numbers() {
    let case = case(1);
    let refused = |constraints: &[Constraint], options: &Options| {
        analogy(&case.exemplars, constraints, options, &Run::seeded(0)).unwrap_err()
    };
    assert_eq!(refused(&[], &case.options), Error::NoConstraint);
    let large = Options { neighborhood: 30, ..case.options.clone() };
    assert!(matches!(refused(&case.constraints, &large), Error::Neighborhood { what: "an output", .. }));
    for weight in [-1.0, f64::NAN, 1e6] {
        let heavy = Constraint { weight, ..case.constraints[0].clone() };
        assert!(matches!(refused(&[heavy], &case.options), Error::Core(CoreError::Range { option: "weight", .. })));
    }
    let none = Constraint { ratio: 0, ..case.constraints[0].clone() };
    assert!(matches!(refused(&[none], &case.options), Error::Core(CoreError::Range { option: "ratio", .. })));
    let target = Grid::try_filled(Domain::open([50, 50]), case.constraints[0].guide.weights().len(), 0).unwrap();
    let other = Constraint::new(case.constraints[0].guide.clone().with_target(target).unwrap());
    let found = refused(&[case.constraints[0].clone(), other], &case.options);
    assert!(matches!(found, Error::Target { found, .. } if found == [50, 50]));
}
