//! Large searches: exact where rounding is hardest, the same on any number of threads. The largest picture is in
//! `memory.rs`.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, Source, Transform};
use selvedge_fft_ssd::{Costs, Engine, Options, Placement, Scratch, SsdSearcher, Template};

/// Black and white: the largest differences, and the largest norms.
fn extremes(seed: u64, n: usize) -> Vec<u8> {
    let mut rng = Seed(seed).rng();
    let mut bits = 0;
    (0..n)
        .map(|i| {
            bits = if i % 64 == 0 { rng.next_u64() } else { bits >> 1 };
            if bits & 1 == 0 { 0 } else { 255 }
        })
        .collect()
}

fn exemplars<const D: usize>(shape: [u32; D]) -> Exemplars<D> {
    let domain = Domain::open(shape);
    let features = Grid::from_vec(domain, 3, extremes(1, 3 * domain.len())).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1; 3]).unwrap()
}

/// Costs by transforms, of which some are compared with the definition.
fn checked<const D: usize>(exemplars: &Exemplars<D>, shape: [u32; D]) -> Costs<D> {
    let template = Domain::open(shape);
    let features = extremes(2, 3 * template.len());
    let searcher = SsdSearcher::with_options(exemplars, Options { engine: Engine::Fft, ..Options::default() }).unwrap();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search(&Template::new(shape, &features), Placement::INSIDE, &mut scratch, &mut costs).unwrap();
    assert_eq!(scratch.repeated(), 0);
    let source = &exemplars.sources()[0];
    for i in 0..40 {
        let mut rng = Seed(3).derive("position", i).rng();
        let position: [i32; D] = costs.sources()[0].shape.map(|n| rng.below(n) as i32);
        let mut error = 0;
        for x in template.positions() {
            let under = std::array::from_fn(|a| x[a] + position[a] as u32);
            for c in 0..3 {
                let value = features[c * template.len() + template.index(x)];
                error += u64::from(value.abs_diff(source.features.get(c, under))).pow(2);
            }
        }
        assert_eq!(costs.get(0, position).unwrap().error, error, "{position:?}");
    }
    costs
}

#[test]
fn a_clip_of_a_million_voxels() {
    let (exemplars, shape) = (exemplars([64, 128, 128]), [24, 60, 70]);
    let fourier = checked(&exemplars, shape);
    // And all of them against the other engine.
    let options = Options { engine: Engine::Direct, ..Options::default() };
    let features = extremes(2, 3 * Domain::open(shape).len());
    let (template, mut direct) = (Template::new(shape, &features), Costs::new());
    let searcher = SsdSearcher::with_options(&exemplars, options).unwrap();
    searcher.search(&template, Placement::INSIDE, &mut Scratch::new(), &mut direct).unwrap();
    assert!(fourier.iter().eq(direct.iter()));
}

#[test]
fn templates_of_many_samples() {
    checked(&exemplars([700, 800]), [500, 600]);
}

#[test]
fn any_number_of_threads() {
    let (clip, picture) = (exemplars([12, 60, 70]), exemplars([500, 500]));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let expected = one.install(|| (checked(&clip, [5, 20, 30]), checked(&picture, [33, 40])));
    for threads in [2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| (checked(&clip, [5, 20, 30]), checked(&picture, [33, 40])));
        assert!(found.0.iter().eq(expected.0.iter()) && found.1.iter().eq(expected.1.iter()), "{threads} threads");
    }
}
