//! Times of single searches.
//! `cargo bench -p selvedge-fft-ssd -- [CASE...] [--simd L] [--engine E | loop | choose] [--threads N] [--repeat N]
//! [--cache BYTES] [--list]` prints a line a case: name, then milliseconds of a warm search: of the processor (all
//! threads, mean over all repeats, where the system tells it), and of the clock (median, least).
//! Some answers are checked first.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, SimdLevel, Source, Transform};
use selvedge_fft_ssd::{Costs, Engine, Errors, Options, Placement, Scratch, SsdSearcher, Template};
use selvedge_testkit::timing::processed;
use std::time::Instant;

/// A case by name: `IMAGE/TEMPLATE`, as in `192/L36-6`, `1024/64`, `1024/disc64`, `512/noise64`, `192/36x6`; `clip` is
/// a 15 x 50 x 75 template in a clip of 30 x 100 x 150.
const CASES: &[&str] = &[
    "192/36x6",
    "192/6x36",
    "192/L36-6",
    "192/L48-8",
    "192/16",
    "192/32",
    "192/64",
    "192/disc64",
    "512/L36-6",
    "512/64",
    "512/disc64",
    "512/noise64",
    "1024/32",
    "1024/64",
    "1024/disc64",
    "1024/128",
    "clip",
];

/// What is timed.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// A search.
    Search,
    /// The plain loop over positions, samples and channels.
    Loop,
    /// Listing the candidates within 10 % of the best norm.
    Choose,
}

struct Args {
    way: Way,
    cases: Vec<String>,
    options: Options,
    threads: usize,
    repeat: usize,
}

fn main() {
    let args = parse();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build().expect("threads can be started");
    for case in &args.cases {
        let (processor, median, least) = pool.install(|| measure(case, &args));
        println!("{case:14} {processor:10.4} {median:10.4} {least:10.4}");
    }
}

fn parse() -> Args {
    let mut args = Args { way: Way::Search, cases: Vec::new(), options: Options::default(), threads: 1, repeat: 15 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().unwrap_or_default();
        match word.as_str() {
            "--bench" => {}
            "--list" => CASES.iter().for_each(|case| println!("{case}")),
            "--threads" => args.threads = value().parse().expect("a number"),
            "--cache" => args.options.cache = value().parse().expect("bytes"),
            "--repeat" => args.repeat = value().parse().expect("a number"),
            "--simd" => args.options.simd = simd(&value()),
            "--engine" => {
                let value = value();
                args.options.engine = engine(&value);
                args.way = match value.as_str() {
                    "loop" => Way::Loop,
                    "choose" => Way::Choose,
                    _ => Way::Search,
                };
            }
            case => args.cases.push(case.to_owned()),
        }
    }
    if args.cases.is_empty() {
        args.cases = CASES.iter().map(|&case| case.to_owned()).collect();
    }
    args
}

fn simd(name: &str) -> SimdLevel {
    match name {
        "scalar" => SimdLevel::Scalar,
        "avx2" => SimdLevel::Avx2,
        "avxvnni" => SimdLevel::AvxVnni,
        "avx512" => SimdLevel::Avx512,
        _ => SimdLevel::Auto,
    }
}

fn engine(name: &str) -> Engine {
    match name {
        "direct" => Engine::Direct,
        "fft" => Engine::Fft,
        _ => Engine::Auto,
    }
}

fn measure(case: &str, args: &Args) -> (f64, f64, f64) {
    match case.split_once('/') {
        Some((side, template)) => {
            let side = side.parse().expect("a side");
            let (shape, mask) = picture_template(template);
            time([side, side], shape, mask, args)
        }
        None => time([30, 100, 150], [15, 50, 75], None, args),
    }
}

/// Shape and mask of a template by name.
fn picture_template(name: &str) -> ([u32; 2], Option<Vec<bool>>) {
    let number = |s: &str| -> u32 { s.parse().expect("a number") };
    let masked = |n: u32, on: &dyn Fn(u32, u32) -> bool| {
        ([n, n], Some((0..n * n).map(|i| on(i / n, i % n)).collect::<Vec<bool>>()))
    };
    if let Some(l) = name.strip_prefix('L') {
        let (block, overlap) = l.split_once('-').map(|(b, o)| (number(b), number(o))).expect("L36-6");
        masked(block, &|y, x| y < overlap || x < overlap)
    } else if let Some(n) = name.strip_prefix("disc").map(number) {
        masked(n, &|y, x| n * n < 8 * ((2 * y + 1).abs_diff(n).pow(2) + (2 * x + 1).abs_diff(n).pow(2)) / 2)
    } else if let Some(n) = name.strip_prefix("noise").map(number) {
        let bits: Vec<bool> = bytes(3, (n * n) as usize).iter().map(|&b| b < 128).collect();
        ([n, n], Some(bits))
    } else if let Some((w, h)) = name.split_once('x') {
        ([number(h), number(w)], None)
    } else {
        ([number(name); 2], None)
    }
}

fn bytes(seed: u64, n: usize) -> Vec<u8> {
    let mut rng = Seed(seed).rng();
    (0..n).map(|_| rng.below(256) as u8).collect()
}

fn time<const D: usize>(shape: [u32; D], template: [u32; D], mask: Option<Vec<bool>>, args: &Args) -> (f64, f64, f64) {
    let domain = Domain::open(shape);
    let features = Grid::from_vec(domain, 3, bytes(1, 3 * domain.len())).expect("right length");
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let exemplars =
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1; 3]).expect("one source");
    let features = bytes(2, 3 * Domain::open(template).len());
    let searcher = SsdSearcher::with_options(&exemplars, args.options).expect("memory suffices");
    let query = Template::new(template, &features);
    let query = mask.as_ref().map_or(query, |m| query.masked(m));
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search(&query, Placement::INSIDE, &mut scratch, &mut costs).expect("a good search");
    check(&exemplars, template, &features, mask.as_deref(), &costs);
    let before = processed();
    let mut times: Vec<f64> = (0..args.repeat)
        .map(|_| {
            let start = Instant::now();
            match args.way {
                Way::Search => {
                    searcher.search(&query, Placement::INSIDE, &mut scratch, &mut costs).expect("a good search")
                }
                Way::Choose => assert!(!costs.within(210).expect("memory suffices").is_empty()),
                Way::Loop => plain(&exemplars, template, &features, mask.as_deref(), &costs),
            }
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let mean = before.and_then(|b| Some((processed()? - b) / args.repeat as f64));
    (mean.unwrap_or(times[times.len() / 2]), times[times.len() / 2], times[0])
}

/// Some positions against the definition.
fn check<const D: usize>(
    exemplars: &Exemplars<D>,
    shape: [u32; D],
    features: &[u8],
    mask: Option<&[bool]>,
    costs: &Costs<D>,
) {
    let (source, template) = (&exemplars.sources()[0], Domain::open(shape));
    let all: Vec<_> = costs.iter().collect();
    for candidate in all.iter().step_by(all.len() / 20 + 1) {
        let mut error = 0;
        for x in template.positions().filter(|&x| mask.is_none_or(|m| m[template.index(x)])) {
            let under = std::array::from_fn(|axis| x[axis] + candidate.position[axis] as u32);
            for c in 0..3 {
                let value = features[c * template.len() + template.index(x)];
                error += u64::from(value.abs_diff(source.features.get(c, under))).pow(2);
            }
        }
        assert_eq!(candidate.error, error, "a wrong answer is not timed");
    }
}

/// The plain loop, in pictures, against the costs that a search found.
fn plain<const D: usize>(
    exemplars: &Exemplars<D>,
    shape: [u32; D],
    features: &[u8],
    mask: Option<&[bool]>,
    costs: &Costs<D>,
) {
    let Errors::Narrow(found) = costs.errors(0) else { return };
    let source = &exemplars.sources()[0].features;
    let (width, columns) = (source.domain().shape[D - 1] as usize, costs.sources()[0].shape[D - 1] as usize);
    let (h, w) = (shape[D - 2] as usize, shape[D - 1] as usize);
    for (i, &found) in found.iter().enumerate() {
        let (y, x) = (i / columns, i % columns);
        let mut error = 0_i32;
        for dy in 0..h {
            for dx in 0..w {
                if mask.is_none_or(|m| m[dy * w + dx]) {
                    for c in 0..3 {
                        let t = i32::from(features[(c * h + dy) * w + dx]);
                        let difference = t - i32::from(source.plane(c)[(y + dy) * width + x + dx]);
                        error += difference * difference;
                    }
                }
            }
        }
        assert_eq!(found, error as u32);
    }
}
