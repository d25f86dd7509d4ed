//! Runs stay within the estimate, and the estimate is not absurdly above. Each case in a process of its own: what a
//! case held would count in the next.

use std::borrow::Cow;

use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Run, Seed, Source, Transform};
use selvedge_quilting::{Options, Plan, Stage, TransferOptions, TransferPlan, quilt, transfer};
use selvedge_testkit::memory;

const TEST: &str = "memory::runs_stay_within_their_estimates";

/// What is woven from an exemplar.
#[derive(Clone, Copy)]
enum Method {
    Quilt(Options),
    Transfer(TransferOptions),
}

struct Case {
    /// Grey levels: of one, every place is a candidate.
    levels: u32,
    masked: bool,
    exemplar: [u32; 2],
    output: Domain<2>,
    method: Method,
}

fn cases() -> Vec<Case> {
    let quilt = |block: Option<u32>| Method::Quilt(Options { block, ..Options::default() });
    let case = |exemplar, output, method| Case { levels: 256, masked: false, exemplar, output, method };
    let random = Method::Quilt(Options { block: Some(40), stage: Stage::Random, ..Options::default() });
    let transfer = Method::Transfer(TransferOptions { block: Some(20), passes: 3, ..TransferOptions::default() });
    vec![
        case([192, 192], Domain::open([512, 512]), quilt(Some(36))),
        case([600, 500], Domain::open([700, 900]), quilt(None)),
        case([192, 192], Domain::open([512, 512]), quilt(None)),
        case([192, 192], Domain::periodic([256, 200]), quilt(Some(48))),
        case([300, 200], Domain::open([400, 300]), quilt(Some(6))),
        case([256, 256], Domain::open([300, 300]), quilt(None)),
        case([64, 64], Domain::open([1500, 1500]), random),
        case([128, 96], Domain::open([128, 128]), transfer),
        // Looked for at half and at a fourth of the size.
        case([600, 500], Domain::open([700, 900]), quilt(Some(60))),
        case([800, 900], Domain::open([900, 1000]), quilt(Some(200))),
        case([800, 900], Domain::open([900, 1000]), quilt(None)),
        Case { levels: 1, ..case([192, 192], Domain::open([300, 300]), quilt(Some(24))) },
        Case { masked: true, ..case([192, 192], Domain::open([300, 300]), quilt(Some(24))) },
        Case { masked: true, levels: 1, ..case([96, 96], Domain::open([100, 90]), transfer) },
    ]
}

fn exemplars(case: &Case) -> Exemplars<2> {
    let (domain, mut rng) = (Domain::open(case.exemplar), Seed(1).rng());
    let samples = (0..3 * domain.len()).map(|_| rng.below(case.levels) as u8).collect();
    let valid = domain.positions().map(|[y, x]| y % 70 != 1 && x % 80 != 1).collect();
    let valid = case.masked.then(|| Grid::from_vec(domain, 1, valid).unwrap());
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: Grid::from_vec(domain, 3, samples).unwrap(), valid: valid.map(Into::into), origin };
    Exemplars::from_sources(vec![source], vec![1; 3]).unwrap()
}

fn guide(case: &Case, exemplars: &Exemplars<2>) -> Guide<2> {
    let target = Grid::from_vec(case.output, 1, (0..case.output.len()).map(|i| (i * 7) as u8).collect()).unwrap();
    let map = Grid::from_vec(exemplars.sources()[0].domain(), 1, exemplars.sources()[0].features.plane(0).to_vec());
    Guide::new(exemplars, &[map.unwrap()], target).unwrap()
}

/// Runs a case and prints the bytes that it held at its peak.
fn measure(case: &Case) {
    let exemplars = exemplars(case);
    let guide = guide(case, &exemplars);
    let before = memory::held();
    let holes = match case.method {
        Method::Quilt(options) => quilt(&exemplars, case.output, &options, &Run::seeded(1)).unwrap().result.holes(),
        Method::Transfer(options) => transfer(&exemplars, &guide, &options, &Run::seeded(1)).unwrap().result.holes(),
    };
    assert_eq!(holes, 0);
    memory::tell(before);
}

#[test]
fn runs_stay_within_their_estimates() {
    let cases = cases();
    let check = |number: usize, held: u64| {
        let (case, run) = (&cases[number], Run::seeded(1));
        let exemplars = exemplars(case);
        let planned = match case.method {
            Method::Quilt(options) => Plan::new(&exemplars, case.output, &options, &run).unwrap().bytes(),
            Method::Transfer(options) => {
                TransferPlan::new(&exemplars, Cow::Owned(guide(case, &exemplars)), &options, &run).unwrap().bytes()
            }
        }
        .0;
        println!("{:.2} case {number}: held {held}, planned {planned}", planned as f64 / held as f64);
        assert!(held <= planned, "case {number}: held {held} bytes, planned {planned}");
        // It counts on flat exemplars, of which every place is a candidate: most, where small blocks are searched.
        let chosen = matches!(case.method, Method::Quilt(Options { block: None, .. }));
        // On a busy machine fewer threads hold something at once than there are.
        let most = if chosen { held * 2 + (2 << 20) } else { held * 3 + (3 << 20) };
        assert!(planned <= most, "case {number}: held {held} bytes, planned {planned}");
    };
    memory::of_each(TEST, cases.len(), |number| measure(&cases[number]), check);
}
