//! Nearest and similar windows against plain loops, with all instructions and on several threads.

use selvedge_core::{Domain, Grid, Rng, Seed, SimdLevel};
use selvedge_fft_ssd::{Coverage, Field, Neighbor, Windows, alike, nearest};

const LEVELS: [SimdLevel; 4] = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512];

/// A picture and which of its samples count.
struct Picture {
    features: Grid<u8, 2>,
    valid: Option<Grid<bool, 2>>,
}

impl Picture {
    /// Few values, so that ties abound, or any.
    fn random(rng: &mut Rng, channels: usize, side: u32) -> Self {
        let shape = [1 + rng.below(side), 1 + rng.below(side)];
        let domain = Domain { shape, periodic: [rng.below(3) == 0, rng.below(3) == 0] };
        let span = [2, 4, 256][rng.below(3) as usize];
        let samples = (0..domain.len() * channels).map(|_| (rng.below(span) * 255 / (span - 1)) as u8).collect();
        let valid = (rng.below(3) == 0).then(|| {
            let holes = (0..domain.len()).map(|_| rng.below(40) != 0).collect();
            Grid::from_vec(domain, 1, holes).unwrap()
        });
        Self { features: Grid::from_vec(domain, channels, samples).unwrap(), valid }
    }

    fn field(&self) -> Field<'_> {
        Field { features: &self.features, valid: self.valid.as_ref() }
    }

    fn counts(&self, at: [u32; 2]) -> bool {
        self.valid.as_ref().is_none_or(|v| v.get(0, at))
    }

    /// The error between a window here and one there; `None` where not all of the one there counts.
    fn error(&self, at: [u32; 2], there: &Self, to: [u32; 2], side: u32, weights: &[u8]) -> Option<u64> {
        let mut error = 0;
        for by in Domain::open([side; 2]).positions() {
            let by = by.map(|b| b as i32);
            let (a, b) = (self.features.domain().step(at, by)?, there.features.domain().step(to, by)?);
            if !there.counts(b) {
                return None;
            }
            for (c, &w) in weights.iter().enumerate().filter(|_| self.counts(a)) {
                let difference = self.features.get(c, a).abs_diff(there.features.get(c, b));
                error += u64::from(w) * u64::from(difference).pow(2);
            }
        }
        Some(error)
    }

    /// Windows at every position.
    fn positions(&self, side: u32) -> Vec<[u32; 2]> {
        Windows { side, step: 1 }.over(self.features.domain()).positions().collect()
    }
}

struct Case {
    picture: Picture,
    sources: Vec<Picture>,
    weights: Vec<u8>,
    windows: Windows,
}

impl Case {
    fn random(rng: &mut Rng) -> Self {
        let channels = 1 + rng.below(5) as usize;
        let weights = match rng.below(3) {
            0 => (0..channels).map(|_| rng.below(256) as u8).collect(),
            1 => vec![3; channels],
            _ => vec![1; channels],
        };
        let step = 1 + rng.below(4);
        let side = if rng.below(5) == 0 { 1 + rng.below(9) } else { step * (1 + rng.below(4)) };
        let sources = (0..1 + rng.below(2)).map(|_| Picture::random(rng, channels, 44)).collect();
        Self { picture: Picture::random(rng, channels, 60), sources, weights, windows: Windows { side, step } }
    }

    /// Where the windows of the picture stand.
    fn asked(&self) -> Vec<[u32; 2]> {
        let over = self.windows.over(self.picture.features.domain());
        over.positions().map(|p| p.map(|p| p * self.windows.step)).collect()
    }

    fn definition(&self, at: [u32; 2]) -> Option<Neighbor> {
        let Windows { side, .. } = self.windows;
        let all = self.sources.iter().enumerate().flat_map(|(source, there)| {
            let one = move |position| {
                let error = self.picture.error(at, there, position, side, &self.weights)?;
                Some(Neighbor { source: source as u32, position, error })
            };
            there.positions(side).into_iter().filter_map(one)
        });
        all.min_by_key(|n| (n.error, n.source, n.position))
    }

    fn nearest(&self, simd: SimdLevel) -> Vec<Option<Neighbor>> {
        let sources: Vec<Field<'_>> = self.sources.iter().map(Picture::field).collect();
        let found = nearest(self.picture.field(), &sources, &self.weights, self.windows, simd);
        found.expect("the case is well formed").into_vec()
    }

    /// The definition of the score: every window against every other.
    fn most_complete(&self, alpha: f64) -> Vec<Option<Neighbor>> {
        let (side, asked) = (self.windows.side, self.asked());
        let error = |at: [u32; 2], source: usize, to: [u32; 2]| {
            self.picture.error(at, &self.sources[source], to, side, &self.weights)
        };
        let places = |source: usize| self.sources[source].positions(side).into_iter().map(move |at| (source, at));
        let places: Vec<(usize, [u32; 2])> = (0..self.sources.len()).flat_map(places).collect();
        let least = |&(source, to): &(usize, [u32; 2])| asked.iter().filter_map(|&at| error(at, source, to)).min();
        let leasts: Vec<Option<u64>> = places.iter().map(least).collect();
        let known: Vec<u64> = leasts.iter().flatten().copied().collect();
        let added = (alpha * (known.iter().sum::<u64>() as f64 / known.len() as f64)).max(1.0);
        let of = |&at: &[u32; 2]| {
            let scored = places.iter().zip(&leasts).filter_map(|(&(source, position), least)| {
                let error = error(at, source, position)?;
                let score = error as f32 * (1.0 / ((*least)? as f64 + added)) as f32;
                Some((score, Neighbor { source: source as u32, position, error }))
            });
            let first = |n: &Neighbor| (n.source, n.position);
            scored.min_by(|a, b| a.0.total_cmp(&b.0).then(first(&a.1).cmp(&first(&b.1)))).map(|(_, n)| n)
        };
        asked.iter().map(of).collect()
    }

    fn complete(&self, alpha: f64, simd: SimdLevel) -> Vec<Option<Neighbor>> {
        let sources: Vec<Field<'_>> = self.sources.iter().map(Picture::field).collect();
        let (picture, weights, windows) = (self.picture.field(), &self.weights, self.windows);
        let coverage = Coverage::of(picture, &sources, weights, windows, simd).expect("the case is well formed");
        let coverage = coverage.clone().and(&coverage);
        let found = coverage.nearest(picture, &sources, weights, windows, alpha, simd);
        found.expect("the case is well formed").into_vec()
    }

    fn counts(&self, error: u64, apart: u32, simd: SimdLevel) -> Vec<u32> {
        let found = alike(self.picture.field(), &self.weights, self.windows, error, apart, simd);
        found.expect("the case is well formed").into_vec()
    }

    fn alike(&self, at: [u32; 2], most: u64, apart: u32) -> u32 {
        let domain = self.picture.features.domain();
        let away = |a: usize, to: [u32; 2]| {
            let by = at[a].abs_diff(to[a]);
            if domain.periodic[a] { by.min(domain.shape[a] - by) } else { by }
        };
        let is_like = |&to: &[u32; 2]| {
            let error = self.picture.error(at, &self.picture, to, self.windows.side, &self.weights);
            error.is_some_and(|e| e <= most) && apart <= away(0, to).max(away(1, to))
        };
        self.picture.positions(self.windows.side).into_iter().filter(is_like).count() as u32
    }
}

#[test]
fn nearest_windows_are_those_of_plain_loops() {
    let mut rng = Seed(11).rng();
    let (mut found, mut none, mut tied) = (0, 0, 0);
    for _ in 0..60 {
        let case = Case::random(&mut rng);
        let expected: Vec<_> = case.asked().into_iter().map(|at| case.definition(at)).collect();
        for simd in LEVELS {
            assert_eq!(case.nearest(simd), expected, "{simd:?} {:?} {:?}", case.windows, case.weights);
        }
        found += expected.iter().flatten().count();
        none += expected.len() - expected.iter().flatten().count();
        tied += expected.iter().flatten().filter(|n| n.error == 0).count();
    }
    assert!(1000 < found && 0 < none && 100 < tied, "{found} {none} {tied}");
}

#[test]
fn complete_windows_are_those_of_the_definition() {
    let mut rng = Seed(17).rng();
    let (mut answered, mut other) = (0, 0);
    for number in 0..40 {
        let case = Case::random(&mut rng);
        if case.asked().len() * case.sources[0].features.domain().len() > 150_000 {
            continue;
        }
        let alpha = f64::from(rng.below(3)) / 10.0;
        let expected = case.most_complete(alpha);
        answered += expected.iter().flatten().count();
        other += case.nearest(SimdLevel::Auto).iter().zip(&expected).filter(|(a, b)| a != b).count();
        for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::Auto] {
            assert!(case.complete(alpha, simd) == expected, "{number} {simd:?}");
        }
    }
    assert!(500 < answered && 100 < other, "{answered} windows, {other} of them not the nearest");
}

#[test]
fn similar_windows_are_counted_as_by_plain_loops() {
    let mut rng = Seed(12).rng();
    let mut sum = 0;
    for _ in 0..40 {
        let case = Case::random(&mut rng);
        let mean = u64::from(case.windows.side).pow(2) * case.weights.iter().map(|&w| u64::from(w)).sum::<u64>();
        let (most, apart) = (mean * [0, 3000, 12_000][rng.below(3) as usize], rng.below(9));
        let expected: Vec<_> = case.asked().into_iter().map(|at| case.alike(at, most, apart)).collect();
        for simd in LEVELS {
            assert_eq!(case.counts(most, apart, simd), expected, "{simd:?} {:?} {most} {apart}", case.windows);
        }
        sum += expected.iter().sum::<u32>();
    }
    assert!(1000 < sum, "{sum}");
}

/// Errors beyond 32 bits: the largest window and weights, black against white.
#[test]
fn large_errors_are_exact() {
    let of = |side: u32, value: u8| Picture {
        features: Grid::try_filled(Domain::open([side; 2]), 4, value).unwrap(),
        valid: None,
    };
    let windows = Windows { side: 16, step: 4 };
    let case = Case { picture: of(24, 0), sources: vec![of(17, 255)], weights: vec![255; 4], windows };
    let expected = Neighbor { source: 0, position: [0, 0], error: 16 * 16 * 4 * 255 * 255 * 255 };
    assert_eq!(case.nearest(SimdLevel::Auto), [Some(expected); 9]);
}

#[cfg(feature = "rayon")]
#[test]
fn threads_change_nothing() {
    let mut rng = Seed(13).rng();
    let random = |rng: &mut Rng, n: u32| {
        let domain = Domain::open([n; 2]);
        let samples = (0..domain.len() * 3).map(|_| rng.below(4) as u8).collect();
        Picture { features: Grid::from_vec(domain, 3, samples).unwrap(), valid: None }
    };
    let (picture, source) = (random(&mut rng, 90), random(&mut rng, 40));
    let windows = Windows { side: 4, step: 2 };
    let case = Case { picture, sources: vec![source], weights: vec![1; 3], windows };
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let [one, three] = [1, 3].map(|n| pool(n).install(|| case.nearest(SimdLevel::Auto)));
    assert_eq!(one, three);
}

#[test]
fn what_does_not_fit_is_an_error_and_small_pictures_have_no_windows() {
    let grid = Grid::try_filled(Domain::open([5, 9]), 2, 0_u8).unwrap();
    let mask = Grid::try_filled(Domain::open([9, 5]), 1, true).unwrap();
    let field = Field::new(&grid);
    let ask = |field, weights: &[u8], side, step| {
        nearest(field, &[Field::new(&grid)], weights, Windows { side, step }, SimdLevel::Auto)
    };
    for (weights, side, step) in [(&[1][..], 4, 2), (&[1, 1], 0, 1), (&[1, 1], 4, 0)] {
        assert!(ask(field, weights, side, step).is_err(), "{weights:?} {side} {step}");
    }
    assert!(ask(Field { valid: Some(&mask), ..field }, &[1, 1], 4, 2).is_err());
    assert!(ask(field, &[1, 1], 6, 2).unwrap().samples().is_empty());
    assert_eq!(ask(field, &[1, 1], 5, 5).unwrap().samples().len(), 1);
}
