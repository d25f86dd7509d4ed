//! Searches of large pictures stay within the estimate, and are right. Each in a process of its own, so that nothing
//! else counts.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, Source, Transform};
use selvedge_fft_ssd::{
    Costs, Cover, Engine, Options, Placement, Positions, Scratch, Sizes, SsdSearcher, Template, estimate,
};
use selvedge_testkit::memory;

/// Black and white: the largest differences, and the largest norms.
fn extremes(seed: u64, n: usize) -> Vec<u8> {
    let mut rng = Seed(seed).rng();
    (0..n.div_ceil(64))
        .flat_map(|_| rng.next_u64().to_le_bytes().map(|b| b & 1).repeat(8))
        .map(|b| b * 255)
        .take(n)
        .collect()
}

/// A search of a square picture with three channels.
struct Large {
    side: u32,
    template: u32,
    /// Which of the template's samples count.
    counts: fn(u32, u32) -> bool,
    noisy: bool,
    /// Every so many'th sample of the picture is not valid; 0 for none.
    holes: usize,
    weights: [u8; 3],
    placement: Placement,
    engine: Engine,
}

const PLAIN: Large = Large {
    side: 2048,
    template: 64,
    counts: |_, _| true,
    noisy: false,
    holes: 0,
    weights: [1; 3],
    placement: Placement::INSIDE,
    engine: Engine::Auto,
};

/// Searches, in a process of its own.
fn alone(name: &str, large: &Large) {
    let test = format!("memory::{name}");
    match memory::case(&test) {
        Some(_) => large.check(),
        None => eprintln!("{}", memory::alone(&test, "")),
    }
}

impl Large {
    fn check(&self) {
        let (domain, box_) = (Domain::open([self.side; 2]), Domain::open([self.template; 2]));
        let mut samples = extremes(1, 3 * domain.len());
        samples.shrink_to_fit();
        let features = Grid::from_vec(domain, 3, samples).unwrap();
        let hole = |i: usize| self.holes != 0 && i.is_multiple_of(self.holes);
        let valid = (self.holes != 0)
            .then(|| Grid::from_vec(domain, 1, (0..domain.len()).map(|i| !hole(i)).collect()).unwrap());
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let source = Source { features, valid: valid.map(Into::into), origin };
        let exemplars = Exemplars::from_sources(vec![source], self.weights.to_vec()).unwrap();
        let template = extremes(2, 3 * box_.len());
        let mask: Vec<bool> = box_.positions().map(|[y, x]| (self.counts)(y, x)).collect();
        let options = Options { engine: self.engine, ..Options::default() };

        let before = memory::held();
        let searcher = SsdSearcher::with_options(&exemplars, options).unwrap();
        let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
        let query = Template::new(box_.shape, &template).masked(&mask);
        searcher.search(&query, self.placement, &mut scratch, &mut costs).unwrap();
        let peak = memory::peak();
        assert_eq!(scratch.repeated(), 0);

        self.compare(&exemplars, &template, &mask, &costs);
        let sizes = Sizes {
            sources: &[domain],
            weights: &self.weights,
            holes: self.holes != 0,
            template: box_.shape,
            samples: mask.iter().filter(|&&on| on).count() as u64,
            noisy_masks: self.noisy,
        };
        let estimate = estimate(&sizes, self.placement, &options).unwrap().0;
        let (Some(before), Some(peak)) = (before, peak) else {
            eprintln!("skipped: this system does not tell how much memory a process had at its peak");
            return;
        };
        let held = peak - before;
        eprintln!("held {held} bytes, estimated {estimate}, {:.2}", estimate as f64 / held as f64);
        assert!(held <= estimate && estimate <= held + held / 2, "held {held} bytes, estimated {estimate}");
    }

    /// Some positions against the definition.
    fn compare(&self, exemplars: &Exemplars<2>, template: &[u8], mask: &[bool], costs: &Costs<2>) {
        let (source, box_) = (&exemplars.sources()[0], Domain::open([self.template; 2]));
        for i in 0..40 {
            let mut rng = Seed(3).derive("position", i).rng();
            let at: [i32; 2] =
                std::array::from_fn(|a| costs.sources()[0].first[a] + rng.below(costs.sources()[0].shape[a]) as i32);
            let (mut error, mut samples, mut missing) = (0, 0, false);
            for x in box_.positions() {
                let under = source.domain().step([0; 2], [0, 1].map(|a: usize| at[a] + x[a] as i32));
                let under = under.filter(|&u| source.valid.as_deref().is_none_or(|v| v.get(0, u)));
                missing |= under.is_none();
                let Some(under) = under.filter(|_| mask[box_.index(x)]) else { continue };
                samples += 1;
                for (c, &weight) in self.weights.iter().enumerate() {
                    let difference = template[c * box_.len() + box_.index(x)].abs_diff(source.features.get(c, under));
                    error += u64::from(weight) * u64::from(difference).pow(2);
                }
            }
            let none = samples == 0 || missing && self.placement.cover == Cover::Box;
            let found = costs.get(0, at).map(|c| (c.error, c.samples));
            assert_eq!(found, (!none).then_some((error, samples)), "{at:?}");
        }
    }
}

#[test]
fn fourier() {
    alone("fourier", &Large { side: 4096, ..PLAIN });
}

#[test]
fn fourier_masked() {
    let counts = |y: u32, x: u32| !(y * 31 + x * 17).is_multiple_of(5);
    alone("fourier_masked", &Large { counts, noisy: true, weights: [77, 150, 29], ..PLAIN });
}

#[test]
fn fourier_with_holes() {
    alone("fourier_with_holes", &Large { holes: 9973, engine: Engine::Fft, ..PLAIN });
}

#[test]
fn fourier_overlapping() {
    let placement = Placement::overlapping(1);
    alone("fourier_overlapping", &Large { holes: 97, placement, engine: Engine::Fft, ..PLAIN });
}

#[test]
fn direct() {
    let counts = |y: u32, x: u32| y < 6 || x < 6;
    alone("direct", &Large { side: 4096, template: 36, counts, engine: Engine::Direct, ..PLAIN });
}

#[test]
fn direct_with_holes() {
    alone("direct_with_holes", &Large { template: 8, holes: 97, engine: Engine::Direct, ..PLAIN });
}

#[test]
fn direct_overlapping() {
    let placement = Placement::overlapping(1);
    alone("direct_overlapping", &Large { template: 6, placement, engine: Engine::Direct, ..PLAIN });
}

#[test]
fn direct_overlapping_holes() {
    let placement = Placement { positions: Positions::Overlapping, cover: Cover::AtLeast(1) };
    alone("direct_overlapping_holes", &Large { template: 5, holes: 97, placement, engine: Engine::Direct, ..PLAIN });
}
