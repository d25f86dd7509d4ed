//! Times of cuts. `cargo bench -p selvedge-maxflow -- [CASE...] [--repeat N] [--engine auto|trees|pseudoflow]
//! [--graph] [--pictures FOLDER] [--dump FILE] [--list]` prints a line a case: name, nodes, milliseconds to build and
//! to solve (of the processor where the system tells it), flow, size of the sink's side.
//!
//! Cases of strokes, `S/1000/gravel` or `S/75x50x20/gravel`, print instead: name, nodes, milliseconds of the first
//! solve (a strip), of solving again after a stroke of a brush (median, 95th of 100), and of solving from nothing
//! (median).
//!
//! `--graph` builds a `Graph` of any form instead of a grid.
//!
//! A case is a name as in `--list`, told in `benches/instances/classes.rs`, or a file that `--dump` wrote. Textures
//! are made up; with `--pictures` those of a name are `FOLDER/NAME.pnm` (8-bit binary PGM or PPM of at least 512 x
//! 512 pixels). Answers are checked before anything is timed: the flow against the capacity of the cut and, of the
//! listed cases, against the answers that stand here, which another solver gave too (`benches/peers.py`; two where its
//! options allow).

mod instances;

use std::path::PathBuf;
use std::time::Instant;

use instances::{Brush, Instance};
use selvedge_maxflow::{BinaryEnergy, Engine, Graph, GraphEnergy, GridGraph, MinCut, Minimum};

/// Name, least energy, size of the sink's side.
const CASES: &[(&str, i64, usize)] = &[
    ("A/8x32/brick", 146_170, 126),
    ("A/64x512/brick", 758_345, 14_152),
    ("A/64x512/grass", 397_811, 26_834),
    ("A/64x512/tissue", 586_690, 17_874),
    ("B/256/brick", 929_398, 48_556),
    ("B/256/brick/3", 874_926, 49_785),
    ("B/256/gravel", 919_286, 49_075),
    ("B/256/tissue", 1_309_790, 51_799),
    ("B1/256/grass", 660_992, 47_978),
    ("B/512/brick", 1_464_935, 179_483),
    ("B/512/gravel", 1_332_829, 160_529),
    ("B/512/tissue", 1_871_029, 193_446),
    ("B1/512/grass", 1_120_048, 144_797),
    ("C/75x50x20/box", 2_739_308, 3_009),
    ("C/75x50x20/time", 4_086_517, 56_897),
    ("D/256/tissue/1", 271_622_366, 30_908),
    ("D/256/tissue/10", 35_061_951, 6_729),
    ("D/256/tissue/30", 19_814_389, 1_693),
    ("D/256/tissue/59", 16_368_855, 1_244),
    ("D/512/tissue/10", 139_395_751, 24_632),
];

struct Args {
    cases: Vec<String>,
    repeat: Option<usize>,
    engine: Engine,
    graph: bool,
    pictures: Option<PathBuf>,
    dump: Option<PathBuf>,
}

fn main() {
    let args = parse();
    for case in &args.cases {
        let instance = Instance::named(case, args.pictures.as_deref());
        if let Some(path) = &args.dump {
            std::fs::write(path, instance.bytes()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            continue;
        }
        let engine = args.engine;
        if case.starts_with("S/") {
            match instance.shape.len() {
                2 => strokes::<2>(case, &instance, &args),
                _ => strokes::<3>(case, &instance, &args),
            }
            continue;
        }
        match instance.shape.len() {
            _ if args.graph => time(case, &instance, &args, || graph_energy(&instance, engine)),
            2 => time(case, &instance, &args, || energy::<2>(&instance, engine)),
            _ => time(case, &instance, &args, || energy::<3>(&instance, engine)),
        }
    }
}

/// What is timed.
trait Energy {
    fn least(&mut self) -> Minimum;
    fn of(&self, cut: &MinCut) -> i64;
}

impl<const D: usize> Energy for BinaryEnergy<D> {
    fn least(&mut self) -> Minimum {
        self.minimize().expect("memory suffices")
    }

    fn of(&self, cut: &MinCut) -> i64 {
        self.value(cut.source_side()).expect("a side a node")
    }
}

impl Energy for GraphEnergy {
    fn least(&mut self) -> Minimum {
        self.minimize().expect("memory suffices")
    }

    fn of(&self, cut: &MinCut) -> i64 {
        self.value(cut.source_side()).expect("a side a node")
    }
}

fn parse() -> Args {
    let mut args =
        Args { cases: Vec::new(), repeat: None, engine: Engine::Auto, graph: false, pictures: None, dump: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().unwrap_or_default();
        match word.as_str() {
            "--bench" => {}
            "--list" => {
                CASES.iter().for_each(|(case, ..)| println!("{case}"));
                std::process::exit(0);
            }
            "--graph" => args.graph = true,
            "--repeat" => args.repeat = Some(value().parse().expect("a number")),
            "--pictures" => args.pictures = Some(value().into()),
            "--dump" => args.dump = Some(value().into()),
            "--engine" => {
                args.engine = match value().as_str() {
                    "trees" => Engine::Trees,
                    "pseudoflow" => Engine::Pseudoflow,
                    _ => Engine::Auto,
                }
            }
            case => args.cases.push(case.to_owned()),
        }
    }
    if args.cases.is_empty() {
        args.cases = CASES.iter().map(|(case, ..)| (*case).to_owned()).collect();
    }
    args
}

/// The energy as the crate's users build it.
fn energy<const D: usize>(instance: &Instance, engine: Engine) -> BinaryEnergy<D> {
    let shape = std::array::from_fn(|a| instance.shape[a]);
    let mut energy = BinaryEnergy::from(GridGraph::new(shape, [false; D]).expect("a grid"));
    energy.graph_mut().set_engine(engine);
    for &(v, side) in &instance.pins {
        energy.graph_mut().pin(v, side).expect("a node");
    }
    if !instance.unaries.is_empty() {
        energy.unaries(&instance.unaries).expect("energies within the headroom");
    }
    for (axis, terms) in instance.terms.iter().enumerate() {
        energy.pairwises(axis, terms).expect("terms within the headroom");
    }
    energy
}

/// The energy over a graph in lists.
fn graph_energy(instance: &Instance, engine: Engine) -> GraphEnergy {
    let mut energy = GraphEnergy::from(Graph::new(instance.len()).expect("a graph"));
    energy.graph_mut().set_engine(engine);
    for &(v, side) in &instance.pins {
        energy.graph_mut().pin(v, side).expect("a node");
    }
    for (v, &[e0, e1]) in instance.unaries.iter().enumerate() {
        energy.unary(v, e0.into(), e1.into()).expect("an energy within the headroom");
    }
    for (v, w, term) in instance.neighbours() {
        energy.pairwise(v, w, term).expect("a term within the headroom");
    }
    energy
}

fn time<E: Energy>(case: &str, instance: &Instance, args: &Args, build: impl Fn() -> E) {
    let found = check(case, instance, args, build());
    let start = Instant::now();
    std::hint::black_box(build().least());
    // A second or so, if nothing was said.
    let repeat = args.repeat.unwrap_or((0.5 / start.elapsed().as_secs_f64()).clamp(3.0, 2000.0) as usize);
    let built = busy(repeat, || std::mem::drop(std::hint::black_box(build())));
    let both = busy(repeat, || {
        std::hint::black_box(build().least());
    });
    let (nodes, sink) = (instance.len(), instance.len() - found.cut.source_len());
    println!("{case:20} {nodes:9} {built:10.4} {:10.4} {:14} {sink:8}", both - built, found.after);
}

/// Times strokes: solved again, and from nothing. Both have the same answer.
fn strokes<const D: usize>(case: &str, instance: &Instance, args: &Args) {
    let mut again = energy::<D>(instance, args.engine);
    let mut found = Minimum::default();
    let first = busy(1, || found = again.least());
    let mut brush = Brush::over(instance);
    let mut held = vec![None; instance.len()];
    let (mut mended, mut anew) = (Vec::new(), Vec::new());
    for number in 0..args.repeat.unwrap_or(24).max(1) {
        let (nodes, side) = brush.next(instance, |v| found.cut.side(v));
        for &v in &nodes {
            held[v] = side;
            match side {
                Some(side) => again.graph_mut().pin(v, side).expect("a node"),
                None => again.graph_mut().unpin(v).expect("a node"),
            }
        }
        mended.push(busy(1, || found = again.least()));
        if number % 3 > 0 {
            continue; // what is made anew takes several times as long
        }
        let mut fresh = energy::<D>(instance, args.engine);
        for (v, side) in (0..).zip(&held) {
            side.iter().for_each(|&side| fresh.graph_mut().pin(v, side).expect("a node"));
        }
        let mut least = Minimum::default();
        anew.push(busy(1, || least = fresh.least()));
        assert_eq!((found.after, &found.cut), (least.after, &least.cut), "{case}: stroke {number}");
    }
    for times in [&mut mended, &mut anew] {
        times.sort_by(f64::total_cmp);
    }
    let [median, most] = [50, 95].map(|part| mended[(mended.len() - 1) * part / 100]);
    let fresh = anew[anew.len() / 2];
    println!("{case:20} {:9} {first:10.2} {median:10.2} {most:10.2} {fresh:10.2}", instance.len());
}

/// The least energy, checked. A wrong answer is not timed.
fn check(case: &str, instance: &Instance, args: &Args, mut built: impl Energy) -> Minimum {
    let found = built.least();
    assert_eq!(found.after, built.of(&found.cut), "{case}");
    let sink = instance.len() - found.cut.source_len();
    if let Some(&(_, least, side)) = CASES.iter().find(|c| c.0 == case && args.pictures.is_none()) {
        assert_eq!((found.after, sink), (least, side), "{case}: least energy and the sink's side");
    }
    found
}

/// Milliseconds of the processor, else of the clock: the median of up to 9 means, since others use the machine as well.
fn busy(repeat: usize, mut call: impl FnMut()) -> f64 {
    let batches = repeat.clamp(1, 9);
    let mut means: Vec<f64> = (0..batches)
        .map(|k| {
            let calls = repeat * (k + 1) / batches - repeat * k / batches;
            let (before, start) = (processed(), Instant::now());
            (0..calls).for_each(|_| call());
            let clock = start.elapsed().as_secs_f64() * 1e3;
            before.and_then(|b| Some(processed()? - b)).unwrap_or(clock) / calls as f64
        })
        .collect();
    means.sort_by(f64::total_cmp);
    means[batches / 2]
}

/// Milliseconds that this thread has run (Linux).
fn processed() -> Option<f64> {
    // What is told is only as new as the last look at who runs next.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split(' ').next()?.parse::<f64>().ok()? / 1e6)
}
