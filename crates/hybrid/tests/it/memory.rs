//! Runs stay within the estimate, and the estimate is not absurdly above. Each case in a process of its own: what a
//! case held would count in the next.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Run, SampleId, Seed, Source, SourceMap, Start, Transform};
use selvedge_hybrid::{Options, Plan, RepairOptions, Threshold, estimate_repair, hybrid, repair};
use selvedge_testkit::memory;

const TEST: &str = "memory::runs_stay_within_their_estimates";

struct Case {
    /// Grey levels: of one, every place is a candidate.
    levels: u32,
    masked: bool,
    exemplar: [u32; 2],
    output: Domain<2>,
    options: Options,
}

fn cases() -> Vec<Case> {
    let block =
        |block: u32| Options { block: Some([block; 2]), max_error: Threshold::OfRandom(0.8), ..Options::default() };
    let case = |exemplar, output, options| Case { levels: 256, masked: false, exemplar, output, options };
    vec![
        case([192, 192], Domain::open([256, 256]), block(32)),
        case([192, 192], Domain::periodic([200, 150]), block(64)),
        case([256, 256], Domain::open([128, 128]), Options { block: None, ..block(1) }),
        case([64, 64], Domain::open([700, 700]), Options { max_error: Threshold::Absolute(1.0), ..block(32) }),
        Case { levels: 1, ..case([192, 192], Domain::open([200, 200]), block(32)) },
        Case { masked: true, ..case([192, 192], Domain::open([130, 130]), Options { circular: true, ..block(32) }) },
    ]
}

fn exemplars(case: &Case) -> Exemplars<2> {
    let (domain, mut rng) = (Domain::open(case.exemplar), Seed(1).rng());
    let samples = (0..3 * domain.len()).map(|_| rng.below(case.levels) as u8).collect();
    let valid = domain.positions().map(|[y, x]| y % 70 != 1 && x % 80 != 1).collect();
    let valid = case.masked.then(|| Grid::from_vec(domain, 1, valid).unwrap());
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: Grid::from_vec(domain, 3, samples).unwrap(), valid: valid.map(Into::into), origin };
    Exemplars::from_sources(vec![source], vec![77, 150, 29]).unwrap()
}

/// Runs a case and prints the bytes that it held at its peak.
fn measure(case: &Case) {
    let exemplars = exemplars(case);
    let before = memory::held();
    let holes = hybrid(&exemplars, case.output, &case.options, &Run::seeded(1)).unwrap().result.holes();
    assert_eq!(holes, 0);
    memory::tell(before);
}

#[test]
fn runs_stay_within_their_estimates() {
    let cases = cases();
    let check = |number: usize, held: u64| {
        let case = &cases[number];
        let plan = Plan::new(&exemplars(case), case.output, &case.options, &Run::seeded(1)).unwrap();
        let planned = plan.bytes().0;
        println!("{:.2} case {number}: held {held}, planned {planned}", planned as f64 / held as f64);
        assert!(held <= planned, "case {number}: held {held} bytes, planned {planned}");
        // It counts on flat exemplars, of which every place is a candidate.
        assert!(planned <= 3 * held + (16 << 20), "case {number}: held {held} bytes, planned {planned}");
    };
    memory::of_each(TEST, cases.len(), |number| measure(&cases[number]), check);
}

/// A map all of whose samples lie beside bad seams: one region, as large as the output, that grows in vain.
#[test]
fn repairs_stay_within_their_estimate() {
    let case = Case { output: Domain::open([400, 360]), exemplar: [48, 48], ..cases().remove(0) };
    let options = RepairOptions { passes: 1, pixel_error: Threshold::Absolute(0.0), ..RepairOptions::default() };
    let measure = |_| {
        let (exemplars, mut rng) = (exemplars(&case), Seed(2).rng());
        let mut map = SourceMap::unassigned(&exemplars, case.output).unwrap();
        map.ids.plane_mut(0).iter_mut().for_each(|id| *id = SampleId::new(rng.below(48 * 48)));
        let before = memory::held();
        let start = Start { map, fixed: None, sources: None };
        assert!(repair(&exemplars, start, &options, &Run::seeded(0)).unwrap().complete);
        memory::tell(before);
    };
    let check = |_, held: u64| {
        let estimate = estimate_repair(&[Domain::open(case.exemplar)], 3, case.output, false).0;
        println!("held {held}, estimated {estimate}");
        // Pages that were there before.
        assert!(held <= estimate, "held {held} bytes, estimated {estimate}");
        assert!(estimate <= 6 * held + (4 << 20), "held {held} bytes, estimated {estimate}");
    };
    memory::of_each("memory::repairs_stay_within_their_estimate", 1, measure, check);
}
