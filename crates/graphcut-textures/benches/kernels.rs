//! Times of the method's parts on one thread.
//! `cargo bench -p selvedge-graphcut-textures -- [CASE...] [--repeat N] [--list]` prints a line a case: name, then
//! milliseconds of the processor (mean over all repeats, where the system tells it) and of the clock (median, least),
//! and what they are for. Answers are checked before anything is timed.
//!
//! A cut is timed by what a run with random placement takes for each refinement beyond its beginning: a patch is drawn
//! without a search, the seams around are priced, and the graph is built and cut. With the other placements a
//! refinement is searched for as well.

use std::hint::black_box;
use std::time::Instant;

use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Run, Samples, SeamCosts, SeamMeasure, Seed, SourceMap};
use selvedge_graphcut_textures::{Options, Placement, Start, Stats, graphcut, graphcut_from};

/// Sides of the exemplar and of the output.
const EXEMPLAR: u32 = 192;
const OUTPUT: u32 = 512;
/// Refinements that are timed at once.
const STEPS: u32 = 40;

/// What is timed.
enum Part {
    /// Preparing the prices of the exemplar's seams.
    Costs(SeamMeasure),
    /// Pricing all seams of the output.
    Total,
    /// A run over the output without a refinement, a region of so many samples a side.
    Begin(Placement, u32),
    /// A refinement.
    Step(Placement, u32),
}

const CASES: &[(&str, Part, &str)] = &[
    ("costs/difference", Part::Costs(SeamMeasure::Difference), "prices of an exemplar of 192^2, eq. 1"),
    ("costs/gradient", Part::Costs(SeamMeasure::Gradient), "the same, eq. 5"),
    ("costs/total", Part::Total, "price of all seams of an output of 512^2"),
    ("begin", Part::Begin(Placement::Sub, 32), "begin a run over it"),
    ("cut/32", Part::Step(Placement::Random, 32), "a cut, region of 32^2 and reach of 16"),
    ("cut/96", Part::Step(Placement::Random, 96), "a cut, region of 96^2 and reach of 48"),
    ("refine/sub", Part::Step(Placement::Sub, 32), "a refinement, region of 32^2 and reach of 16"),
    ("refine/entire", Part::Step(Placement::Entire, 32), "the same"),
];

fn main() {
    let (mut names, mut repeat) = (Vec::new(), 9);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--bench" => {}
            "--list" => return CASES.iter().for_each(|(name, _, what)| println!("{name:18} {what}")),
            "--repeat" => repeat = words.next().and_then(|n| n.parse().ok()).expect("a number of repeats"),
            _ => names.push(word),
        }
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    pool.install(|| {
        let setup = Setup::new();
        setup.check();
        for (name, part, what) in CASES.iter().filter(|c| names.is_empty() || names.iter().any(|n| c.0.contains(n))) {
            let [processor, median, least] = time(&setup, part, repeat);
            println!("{name:18} {processor:9.4} {median:9.4} {least:9.4}   {what}");
        }
    });
}

/// Milliseconds of the processor, and of the clock.
fn time(setup: &Setup, part: &Part, repeat: u32) -> [f64; 3] {
    let (mut processor, mut clock) = (0.0, Vec::new());
    for _ in 0..repeat {
        let [processed, passed] = match part {
            Part::Step(placement, region) => {
                let base = measure(|| setup.refine(*placement, *region, 0));
                let all = measure(|| setup.refine(*placement, *region, STEPS));
                [0, 1].map(|i| (all[i] - base[i]) / f64::from(STEPS))
            }
            Part::Begin(placement, region) => measure(|| setup.refine(*placement, *region, 0)),
            Part::Costs(measured) => measure(|| drop(black_box(setup.costs(*measured)))),
            Part::Total => {
                let costs = setup.costs(SeamMeasure::Gradient);
                measure(|| _ = black_box(costs.total(&setup.map)))
            }
        };
        processor += processed;
        clock.push(passed);
    }
    clock.sort_by(f64::total_cmp);
    [processor / f64::from(repeat), clock[clock.len() / 2], clock[0]]
}

fn measure(run: impl FnOnce()) -> [f64; 2] {
    let (before, start) = (processed(), Instant::now());
    run();
    let passed = start.elapsed().as_secs_f64() * 1e3;
    [before.and_then(|b| Some(processed()? - b)).unwrap_or(passed), passed]
}

/// An exemplar, and an output that is covered with it.
struct Setup {
    exemplars: Exemplars<2>,
    map: SourceMap<2>,
}

impl Setup {
    fn new() -> Self {
        let domain = Domain::open([EXEMPLAR; 2]);
        // Pebbles of about twelve samples, with grain.
        let pebble = |y: u32, x: u32| (Seed(1).derive("pebble", u64::from(y / 12 * EXEMPLAR + x / 12)).0 % 160) as u8;
        let grain = |y: u32, x: u32| (Seed(2).derive("grain", u64::from(y * EXEMPLAR + x)).0 % 32) as u8;
        let samples = (0..3).flat_map(|c| domain.positions().map(move |[y, x]| pebble(y, x) / (c + 1) + grain(y, x)));
        let grid = Grid::from_vec(domain, 3, samples.collect()).expect("right length");
        let plane = Plane::new(Role::Color, Samples::U8(grid));
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).expect("an exemplar");
        let options = options(Placement::Sub, 32, 0);
        let woven = graphcut(&exemplars, Domain::open([OUTPUT; 2]), &options, &Run::seeded(1)).expect("a run");
        Self { exemplars, map: woven.result }
    }

    /// Wrong answers are not timed.
    fn check(&self) {
        let (map, stats) = self.refined(&options(Placement::Sub, 32, STEPS));
        let costs = self.costs(SeamMeasure::Gradient);
        let energy = stats.energy;
        assert_eq!(energy.first(), Some(&costs.total(&self.map)), "the energy is the price of all seams");
        assert_eq!(energy.last(), Some(&costs.total(&map)));
        assert!(energy.is_sorted_by(|a, b| a >= b) && energy.first() != energy.last());
    }

    fn costs(&self, measure: SeamMeasure) -> SeamCosts<2> {
        SeamCosts::new(&self.exemplars, measure).expect("memory suffices")
    }

    fn refined(&self, options: &Options<2>) -> (SourceMap<2>, Stats<2>) {
        let start = Start { map: self.map.clone(), fixed: None, sources: None };
        let woven = graphcut_from(&self.exemplars, start, options, &Run::seeded(1)).expect("a run");
        (woven.result, woven.stats)
    }

    fn refine(&self, placement: Placement, region: u32, steps: u32) {
        let (_, stats) = self.refined(&options(placement, region, steps));
        assert_eq!(stats.refinements, u64::from(steps), "there are regions left to refine");
    }
}

/// One patch a refinement, whether or not it makes seams cheaper.
fn options(placement: Placement, region: u32, steps: u32) -> Options<2> {
    let (region, reach) = (Some([region; 2]), Some([region / 2; 2]));
    Options { placement, region, reach, refine: Some(steps), tries: 1, patience: 1000, ..Options::default() }
}

/// Milliseconds that all threads together have run (Linux). The count may move in steps of some milliseconds.
fn processed() -> Option<f64> {
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split(' ').next()?.parse::<f64>().ok()? / 1e6;
    }
    Some(sum)
}
