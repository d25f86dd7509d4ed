//! Runs stay within the estimate, and the estimate is not absurdly above. Each case in a process of its own: what a
//! case held would count in the next.

use selvedge_cms_analogies::{Constraint, Options, Sizes, analogy, estimate};
use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Run, Seed, Source, Transform};
use selvedge_testkit::memory;

const TEST: &str = "memory::runs_stay_within_their_estimates";

struct Case {
    exemplar: Domain<2>,
    output: Domain<2>,
    /// By constraint, how far apart its taps are.
    ratios: Vec<u32>,
    options: Options,
    /// Whether a box of the exemplar is not valid.
    holes: bool,
}

fn cases() -> Vec<Case> {
    // Few labels: it is the sizes that count.
    let options = Options { tolerance: Some(1e6), ..Options::paper() };
    let drawn = Options { random_labels: Some(20), ..Options::paper() };
    let case = |exemplar, output, ratios: &[u32], options: &Options| Case {
        exemplar: Domain::open(exemplar),
        output,
        ratios: ratios.to_vec(),
        options: options.clone(),
        holes: false,
    };
    let searched = case([320, 300], Domain::open([240, 300]), &[1, 1], &options);
    vec![
        case([300, 400], Domain::open([1100, 1200]), &[1], &drawn),
        case([300, 300], Domain::periodic([700, 800]), &[1, 2, 1], &drawn),
        case([220, 240], Domain::open([240, 300]), &[8], &Options { neighborhood: 7, ..options.clone() }),
        Case { holes: true, ..case([320, 300], Domain::open([240, 300]), &[1, 1], &options) },
        searched,
    ]
}

/// Runs a case and prints the bytes that it held at its peak.
fn measure(case: &Case) {
    let mut rng = Seed(1).rng();
    let mut noise = |domain: Domain<2>, channels: usize| {
        let samples = (0..channels * domain.len()).map(|_| rng.below(256) as u8).collect();
        Grid::from_vec(domain, channels, samples).unwrap()
    };
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let shown = case.exemplar.positions().map(|[y, x]| !(20..90).contains(&y) || !(30..70).contains(&x)).collect();
    let valid = case.holes.then(|| Grid::from_vec(case.exemplar, 1, shown).unwrap().into());
    let source = Source { features: noise(case.exemplar, 3), valid, origin };
    let exemplars = Exemplars::from_sources(vec![source], vec![1; 3]).unwrap();
    let constraint = |&ratio: &u32| {
        let guide = Guide::new(&exemplars, &[noise(case.exemplar, 1)], noise(case.output, 1)).unwrap();
        Constraint { guide, ratio, weight: 1.0 }
    };
    let constraints: Vec<Constraint> = case.ratios.iter().map(constraint).collect();
    let before = memory::held();
    let woven = analogy(&exemplars, &constraints, &case.options, &Run::seeded(1)).unwrap();
    assert_eq!(woven.result.holes(), 0);
    memory::tell(before);
}

#[test]
fn runs_stay_within_their_estimates() {
    let cases = cases();
    let check = |number: usize, held: u64| {
        let case = &cases[number];
        let constraints: Vec<_> = case.ratios.iter().map(|&ratio| (1, ratio)).collect();
        let (sources, output) = (&[case.exemplar], case.output);
        let sizes = Sizes { sources, channels: 3, constraints: &constraints, output, holes: case.holes };
        let estimate = estimate(&sizes, &case.options).0;
        println!("case {number}: held {held}, estimated {estimate}");
        assert!(held <= estimate, "case {number}: held {held} bytes, estimated {estimate}");
        assert!(estimate <= 3 * held + (16 << 20), "case {number}: held {held} bytes, estimated {estimate}");
    };
    memory::of_each(TEST, cases.len(), |number| measure(&cases[number]), check);
}
