//! Times of the method's parts on one thread.
//! `cargo bench -p selvedge-graphcut-textures -- [CASE...] [--repeat N] [--list]` prints a line a case. Answers
//! are checked before anything is timed.
//!
//! A cut is timed by what a run with random placement takes for each refinement beyond its beginning: a patch is drawn
//! without a search, the seams around are priced, and the graph is built and cut. With the other placements a
//! refinement is searched for as well.

use std::hint::black_box;

use selvedge_core::{
    Domain, Exemplars, Grid, Plane, Role, Run, Samples, SeamCosts, SeamMeasure, Seed, SourceMap, Woven,
};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, LabelStats, expand};
use selvedge_graphcut_textures::{Options, Placement, Start, Stats, graphcut, graphcut_from};
use selvedge_testkit::timing::{Spent, bench, spent};

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
    /// An output decided between so many places of the exemplar.
    Labels(usize),
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
    ("labels/2", Part::Labels(2), "an output of 160^2 decided between two labels, left and right"),
    ("labels/8", Part::Labels(8), "the same between eight"),
];

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    pool.install(|| bench(CASES, Setup::new, time));
}

fn time(setup: &Setup, part: &Part) -> Spent {
    match part {
        Part::Step(placement, region) => {
            let base = spent(|| setup.refine(*placement, *region, 0));
            let all = spent(|| setup.refine(*placement, *region, STEPS));
            let of_one = |all: f64, base: f64| (all - base) / f64::from(STEPS);
            Spent { processor: of_one(all.processor, base.processor), clock: of_one(all.clock, base.clock) }
        }
        Part::Begin(placement, region) => spent(|| setup.refine(*placement, *region, 0)),
        Part::Costs(measure) => spent(|| drop(black_box(setup.costs(*measure)))),
        Part::Labels(count) => spent(|| drop(black_box(setup.decided(*count)))),
        Part::Total => {
            let costs = setup.costs(SeamMeasure::Gradient);
            spent(|| _ = black_box(costs.total(&setup.map)))
        }
    }
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
        let setup = Self { exemplars, map: woven.result };
        setup.check();
        setup
    }

    /// Wrong answers are not timed.
    fn check(&self) {
        let (map, stats) = self.refined(&options(Placement::Sub, 32, STEPS));
        let costs = self.costs(SeamMeasure::Gradient);
        let energy = stats.energy;
        assert_eq!(energy.first(), Some(&costs.total(&self.map)), "the energy is the price of all seams");
        assert_eq!(energy.last(), Some(&costs.total(&map)));
        assert!(energy.is_sorted_by(|a, b| a >= b) && energy.first() != energy.last());
        let decided = self.decided(8);
        assert_eq!(decided.stats.energy.last(), Some(&costs.total(&decided.result)), "what labels cost");
    }

    /// An output whose left column shows the first label, and its right one the last.
    fn decided(&self, count: usize) -> Woven<SourceMap<2>, LabelStats> {
        let output = Domain::open([EXEMPLAR - 32; 2]);
        let label = |i: usize| Label { source: 0, offset: [-((i * 7 % 32) as i32), -((i * 11 % 32) as i32)] };
        let labels: Vec<_> = (0..count).map(label).collect();
        let all = (1 << count) - 1_u64;
        let only = output.positions().map(|[_, x]| match x {
            0 => 1,
            x if x + 1 == output.shape[1] => 1 << (count - 1),
            _ => all,
        });
        let only = Some(Grid::from_vec(output, 1, only.collect()).expect("right length"));
        let start = Start::empty(&self.exemplars, output).expect("memory suffices");
        let options = LabelOptions { only, ..LabelOptions::default() };
        expand(&self.exemplars, start, &labels, &options, &Run::seeded(1)).expect("a run")
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
