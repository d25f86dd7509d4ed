//! Runs stay within what they are told to take, and that is not absurdly above. Each case in a process of its own: what
//! a case held would count in the next.

use selvedge_core::{
    Domain, Exemplars, Grid, Guidance, Guide, Limits, Origin, Run, Seed, Source, SourceMap, Transform,
};
use selvedge_testkit::memory;
use selvedge_texture_optimization::{Control, Error, Finish, Level, Options, Search, Wanted, estimate, optimize_from};

const TEST: &str = "memory::runs_stay_within_their_estimates";

#[derive(Clone)]
struct Case {
    exemplar: u32,
    output: u32,
    options: Options,
    steered: bool,
}

fn cases() -> Vec<Case> {
    let level = |scale, size| Level { scale, size };
    let quick = Options { schedule: vec![level(2, 8), level(1, 8)], iterations: 2, ..Options::default() };
    let gradient = Options { gradient: 10.0, ..quick.clone() };
    let case =
        |exemplar, output, options: &Options| Case { exemplar, output, options: options.clone(), steered: false };
    vec![
        case(64, 128, &quick),
        case(96, 200, &Options { finish: Finish::Average, ..quick.clone() }),
        case(64, 160, &gradient),
        case(64, 128, &Options { spread: 1.0, ..quick.clone() }),
        case(64, 128, &Options { search: Search::Tree, complete: None, ..quick.clone() }),
        Case { steered: true, ..case(64, 160, &quick) },
        Case { steered: true, ..case(64, 128, &gradient) },
    ]
}

fn noise(domain: Domain<2>, seed: u64) -> Grid<u8, 2> {
    let mut rng = Seed(seed).rng();
    Grid::from_vec(domain, 3, (0..3 * domain.len()).map(|_| rng.below(256) as u8).collect()).unwrap()
}

fn inputs(case: &Case) -> (Exemplars<2>, SourceMap<2>, Control) {
    let [exemplar, output] = [case.exemplar, case.output].map(|side| Domain::open([side; 2]));
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: noise(exemplar, 1), valid: None, origin };
    let exemplars = Exemplars::from_sources(vec![source], vec![1; 3]).unwrap();
    let mut start = SourceMap::unassigned(&exemplars, output).unwrap();
    let places = output.positions().map(|at| exemplars.table().id(0, at.map(|p| p % case.exemplar)));
    start.ids.samples_mut().iter_mut().zip(places).for_each(|(id, place)| *id = place);
    let control = if case.steered {
        let guide = Guide::new(&exemplars, &[noise(exemplar, 2)], noise(output, 3)).unwrap();
        let weight = Grid::try_filled(output, 1, 0.1).unwrap();
        Control {
            wanted: Some(Wanted { features: noise(output, 4), weight }),
            fixed: Some(Grid::try_filled(output, 1, false).unwrap()),
            guidance: Some(Guidance { guide, weight: 1.0 }),
        }
    } else {
        Control::default()
    };
    (exemplars, start, control)
}

fn measure(case: &Case) {
    let (exemplars, start, control) = inputs(case);
    let before = memory::held();
    optimize_from(&exemplars, &start, &control, &case.options, &Run::seeded(1)).unwrap();
    memory::tell(before);
}

fn told(case: &Case) -> u64 {
    let (exemplars, start, control) = inputs(case);
    let channels = if case.steered { 6 } else { 3 };
    let [exemplar, output] = [exemplars.sources()[0].domain(), start.domain()];
    (estimate(&[exemplar], channels, output, &case.options) + control.bytes(&exemplars, output)).0
}

/// Control is held against the budget as well.
#[test]
fn control_is_within_the_budget_or_refused() {
    let case = Case { steered: true, ..cases()[0].clone() };
    let (exemplars, start, control) = inputs(&case);
    let run = |memory| Run { limits: Limits { memory, ..Limits::default() }, ..Run::seeded(0) };
    let woven = |memory| optimize_from(&exemplars, &start, &control, &case.options, &run(memory));
    assert!(woven(told(&case)).is_ok());
    assert!(matches!(woven(told(&case) - 1), Err(Error::Core(selvedge_core::Error::OverBudget { .. }))));
}

#[test]
fn runs_stay_within_their_estimates() {
    let cases = cases();
    let check = |number: usize, held: u64| {
        let told = told(&cases[number]);
        assert!(held <= told && told <= 4 * held + (2 << 20), "case {number}: held {held} bytes, told {told}");
    };
    memory::of_each(TEST, cases.len(), |number| measure(&cases[number]), check);
}
