//! What is turned comes out turned, and no number of threads changes what is told before a run.

use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Run, SampleId, Seed, Source, SourceMap, Start, Transform};

use crate::{Constraint, Options, analogy_from, fitness};

/// A grid turned by a quarter turn.
fn turned(of: &Grid<u8, 2>) -> Grid<u8, 2> {
    let [height, width] = of.domain().shape;
    let domain = Domain::open([width, height]);
    let samples = (0..of.channels()).flat_map(|c| domain.positions().map(move |[y, x]| of.get(c, [height - 1 - x, y])));
    Grid::from_vec(domain, of.channels(), samples.collect()).unwrap()
}

/// Where a position is after a quarter turn of a grid of this height.
fn turned_at([y, x]: [u32; 2], height: u32) -> [u32; 2] {
    [x, height - 1 - y]
}

fn noise(seed: u64, shape: [u32; 2], channels: usize) -> Grid<u8, 2> {
    let (mut rng, domain) = (Seed(seed).rng(), Domain::open(shape));
    Grid::from_vec(domain, channels, (0..channels * domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap()
}

fn exemplars(features: Grid<u8, 2>) -> Exemplars<2> {
    let (origin, weights) = (Origin { exemplar: 0, transform: Transform::IDENTITY }, vec![1; features.channels()]);
    Exemplars::from_sources(vec![Source { features, valid: None, origin }], weights).unwrap()
}

/// Noise has no ties, and begins with an output: of holes, which are all as bad, the first is filled first.
#[test]
fn turning_everything_turns_the_result() {
    let mut changed = 0;
    for seed in 0..12 {
        let (s, q, c) = (noise(seed, [9, 13], 3), noise(100 + seed, [9, 13], 2), noise(200 + seed, [14, 11], 2));
        let begun: Vec<u32> = c.domain().positions().map(|[y, x]| (y * 31 + x * 7 + seed as u32) % (9 * 13)).collect();
        let options = Options {
            neighborhood: (seed % 3) as u32,
            constraint_weight: [0.02, 0.3, 4.0][seed as usize % 3],
            apart: 3,
            tolerance: Some(0.1),
            ..Options::paper()
        };
        let run = |[s, q, c]: [Grid<u8, 2>; 3], begin: &dyn Fn([u32; 2]) -> SampleId| {
            let exemplars = exemplars(s);
            let mut map = SourceMap::unassigned(&exemplars, c.domain()).unwrap();
            let (ids, places) = (map.ids.plane_mut(0), c.domain());
            ids.iter_mut().zip(places.positions()).for_each(|(id, at)| *id = begin(at));
            let constraints = [Constraint::new(Guide::new(&exemplars, &[q], c).unwrap())];
            let start = Start { map, fixed: None, sources: None };
            analogy_from(&exemplars, &constraints, &start, &options, &Run::seeded(0)).unwrap()
        };
        let (output, source, heights) = (c.domain(), s.domain(), [c.domain().shape[0], s.domain().shape[0]]);
        let upright = |at: [u32; 2]| SampleId::new(begun[output.index(at)]);
        let wide = source.shape[0];
        let number = |[y, x]: [u32; 2]| y * wide + x;
        let sideways = |[y, x]: [u32; 2]| {
            let from = source.position(begun[output.index([heights[0] - 1 - x, y])] as usize);
            SampleId::new(number(turned_at(from, heights[1])))
        };
        let one = run([s.clone(), q.clone(), c.clone()], &upright);
        let other = run([&s, &q, &c].map(turned), &sideways);
        for at in output.positions() {
            let expected = one.result.locate(at).map(|(_, from)| turned_at(from, heights[1]));
            let found = other.result.locate(turned_at(at, heights[0])).map(|(_, from)| from);
            assert_eq!(found, expected, "{seed}: {at:?}");
        }
        assert_eq!((one.stats.energy, one.stats.model), (other.stats.energy, other.stats.model), "{seed}");
        changed += one.stats.improvements;
    }
    assert!(100 < changed, "{changed}");
}

#[test]
fn what_is_told_before_a_run_does_not_depend_on_threads() {
    let (s, c) = (exemplars(noise(1, [70, 90], 1)), noise(2, [80, 64], 3));
    let guide = Guide::new(&s, &[noise(3, [70, 90], 3)], c).unwrap();
    let constraints = [Constraint { guide, ratio: 2, weight: 1.0 }];
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fitness(&s, &constraints, &Options::paper())).unwrap()
    };
    let one = of(1);
    assert!(one[0].uncovered.is_some());
    assert_eq!([of(2), of(3)], [one.clone(), one]);
}
