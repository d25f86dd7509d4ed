//! Times of renderers on one thread. `cargo bench -p selvedge-blending -- [CASE...] [--repeat N] [--list]` prints a
//! line a case. Answers are checked before anything is timed.

use std::hint::black_box;

use selvedge_blending::{Feathered, Fused, Splined};
use selvedge_core::{Domain, Grid, Origin, Plane, Render, Role, Samples, Seed, SourceMap, SourceTable, Transform};
use selvedge_testkit::timing::{bench, spent};

/// Side of the output.
const OUTPUT: u32 = 512;

/// How the output is rendered.
enum How {
    Copied,
    Feathered(f64),
    Splined(u32),
    /// Wholly, or as near to seams.
    Fused(Option<u32>),
}

const CASES: &[(&str, How, &str)] = &[
    ("copy", How::Copied, "an output of 512^2 from patches of 48^2, three channels"),
    ("feather/2", How::Feathered(2.0), "feather it, sigma of 2"),
    ("feather/8", How::Feathered(8.0), "sigma of 8"),
    ("spline/3", How::Splined(3), "spline it, 3 bands"),
    ("spline/5", How::Splined(5), "5 bands"),
    ("fuse", How::Fused(None), "fuse it"),
    ("fuse/8", How::Fused(Some(8)), "no farther than 8 samples from seams"),
];

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    pool.install(|| bench(CASES, Setup::new, |setup, how| spent(|| drop(black_box(setup.rendered(how))))));
}

/// An exemplar, and an output that is covered with patches of it.
struct Setup {
    plane: Plane<2>,
    map: SourceMap<2>,
}

impl Setup {
    fn new() -> Self {
        let domain = Domain::open([192; 2]);
        let mut rng = Seed(1).rng();
        let samples = (0..3 * domain.len()).map(|_| rng.below(256) as u8).collect();
        let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples).expect("right length")));
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let table = SourceTable::new(vec![(origin, domain)]).expect("few samples");
        let output = Domain::open([OUTPUT; 2]);
        let ids = output.positions().map(|[y, x]| {
            let mut rng = Seed(2).derive("patch", (y / 48 * OUTPUT + x / 48).into()).rng();
            table.id(0, [rng.below(144) + y % 48, rng.below(144) + x % 48])
        });
        let ids = Grid::from_vec(output, 1, ids.collect()).expect("right length");
        let setup = Self { plane, map: SourceMap::new(ids, table).expect("known samples") };
        setup.check();
        setup
    }

    /// Wrong answers are not timed.
    fn check(&self) {
        let plain = self.rendered(&How::Copied);
        let differing = |out: &Plane<2>| {
            let n = out.domain().len();
            (0..n).filter(|&i| (0..3).any(|c| out.samples.value(c, i) != plain.samples.value(c, i))).count()
        };
        assert_eq!(differing(&self.rendered(&How::Feathered(0.0))), 0, "no blending changes nothing");
        assert_eq!(differing(&self.rendered(&How::Splined(0))), 0);
        // Three samples on each side of the seams, 10 along each axis, less those that happen to be equal.
        let feathered = differing(&self.rendered(&How::Feathered(1.5)));
        assert!((54_000..=58_000).contains(&feathered), "{feathered}");
    }

    fn rendered(&self, how: &How) -> Plane<2> {
        let planes = [&self.plane];
        let out = match how {
            How::Copied => self.map.render(&planes),
            How::Feathered(sigma) => Feathered::new(&self.map, Vec::new(), *sigma).expect("in range").render(&planes),
            How::Fused(reach) => {
                let fused = Fused::new(&self.map, Vec::new()).expect("a map");
                reach.map_or(fused.clone(), |reach| fused.within(reach)).render(&planes)
            }
            How::Splined(bands) => Splined::new(&self.map, Vec::new(), *bands).expect("in range").render(&planes),
        };
        out.expect("a picture")
    }
}
