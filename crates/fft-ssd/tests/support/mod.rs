//! Random searches and the slow definition of their answer.
#![allow(dead_code, reason = "each test file uses a part")]

use selvedge_core::{Domain, Exemplars, Grid, Origin, Rng, Source, Transform};
use selvedge_fft_ssd::{Cover, Placement, Positions};

/// A search to be checked.
#[derive(Debug)]
pub(crate) struct Case<const D: usize> {
    pub(crate) exemplars: Exemplars<D>,
    pub(crate) shape: [u32; D],
    pub(crate) features: Vec<u8>,
    pub(crate) mask: Option<Vec<bool>>,
    pub(crate) placement: Placement,
}

fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.below(of.len() as u32) as usize]
}

/// Noise of a random range, so that ties, flat pictures and extremes all occur.
fn noise(rng: &mut Rng, n: usize) -> Vec<u8> {
    let (low, span) = pick(rng, &[(0, 256), (0, 256), (0, 4), (128, 1), (255, 1), (0, 1), (120, 16)]);
    let extremes = rng.below(6) == 0;
    (0..n).map(|_| if extremes { pick(rng, &[0, 255]) } else { (low + rng.below(span)) as u8 }).collect()
}

/// One true region: all, none, random, a blob, an L, a rectangle.
fn mask<const D: usize>(rng: &mut Rng, domain: Domain<D>) -> Option<Vec<bool>> {
    let shape = domain.shape;
    let cut: [u32; D] = shape.map(|s| rng.below(s + 1));
    let kind = rng.below(7);
    let density = 1 + rng.below(9);
    let inside = |at: [u32; D]| at.iter().zip(&cut).all(|(a, c)| a < c);
    let mask = |rng: &mut Rng, at: [u32; D]| match kind {
        0 => true,
        1 => false,
        2 => rng.below(10) < density,
        3 => inside(at),
        4 => at.iter().zip(&cut).any(|(a, c)| a < c),
        _ => {
            let r2: u32 = at.iter().zip(&shape).map(|(&a, &s)| (2 * a + 1).abs_diff(s).pow(2)).sum();
            density * 4 < r2
        }
    };
    (kind != 6).then(|| domain.positions().map(|at| mask(rng, at)).collect())
}

impl<const D: usize> Case<D> {
    /// Sides up to `side`, primes and 1 among them; channels up to 8; one or two sources.
    pub(crate) fn random(rng: &mut Rng, side: u32) -> Self {
        let channels = pick(rng, &[1, 2, 3, 3, 3, 4, 5, 7, 8]);
        let weights: Vec<u8> = match rng.below(3) {
            0 => (0..channels).map(|_| rng.below(256) as u8).collect(),
            1 => [77, 150, 29, 255, 1, 2, 0, 9][..channels].to_vec(),
            _ => vec![1; channels],
        };
        let length = |rng: &mut Rng| {
            let primes = [1, 2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61];
            let any = 1 + rng.below(side);
            let prime = pick(rng, &primes).min(side);
            pick(rng, &[any, any, prime, 1])
        };
        let sources = (0..1 + rng.below(2)).map(|e| Self::source(rng, e as u16, channels, length)).collect();
        let exemplars = Exemplars::from_sources(sources, weights).expect("sources are well formed");
        let shape: [u32; D] = std::array::from_fn(|_| length(rng));
        let domain = Domain::open(shape);
        let positions = pick(rng, &[Positions::Inside, Positions::Inside, Positions::Circular, Positions::Overlapping]);
        let cover = pick(rng, &[Cover::Box, Cover::Box, Cover::Mask, Cover::AtLeast(1)]);
        let cover = if cover == Cover::AtLeast(1) { Cover::AtLeast(u64::from(rng.below(9))) } else { cover };
        let features = noise(rng, domain.len() * channels);
        Self { exemplars, shape, features, mask: mask(rng, domain), placement: Placement { positions, cover } }
    }

    fn source(rng: &mut Rng, exemplar: u16, channels: usize, length: impl Fn(&mut Rng) -> u32) -> Source<D> {
        let shape: [u32; D] = std::array::from_fn(|_| length(rng));
        let domain = Domain { shape, periodic: shape.map(|_| rng.below(8) == 0) };
        let features = Grid::from_vec(domain, channels, noise(rng, domain.len() * channels)).expect("right length");
        let valid = (rng.below(3) == 0).then(|| mask(rng, Domain::open(shape))).flatten();
        // At least one sample must be valid.
        let valid = valid.filter(|v| v.contains(&true)).map(|v| Grid::from_vec(domain, 1, v).expect("right length"));
        Source { features, valid, origin: Origin { exemplar, transform: Transform::IDENTITY } }
    }

    /// True if all samples of a part of the template, by its start and shape, stand on valid samples.
    pub(crate) fn stands(&self, source: usize, position: [i32; D], part: Option<([u32; D], [u32; D])>) -> bool {
        let Some((start, part)) = part else { return true };
        let source = &self.exemplars.sources()[source];
        Domain::open(part).positions().all(|x| {
            let by = std::array::from_fn(|a| position[a] + (start[a] + x[a]) as i32);
            let under = source.domain().step([0; D], by);
            under.is_some_and(|u| source.valid.as_ref().is_none_or(|v| v.get(0, u)))
        })
    }

    /// Error and compared samples at a position, from the definition; `None` if it is no candidate.
    pub(crate) fn definition(&self, source: usize, position: [i32; D]) -> Option<(u64, u64)> {
        let (source, template) = (&self.exemplars.sources()[source], Domain::open(self.shape));
        let mut wrapped = source.domain();
        if self.placement.positions == Positions::Circular {
            wrapped.periodic = [true; D];
        }
        let (mut error, mut count) = (0, 0);
        for x in template.positions() {
            let on = self.mask.as_ref().is_none_or(|m| m[template.index(x)]);
            let by = std::array::from_fn(|axis| position[axis] + x[axis] as i32);
            let under = wrapped.step([0; D], by).filter(|&u| source.valid.as_ref().is_none_or(|v| v.get(0, u)));
            match under {
                Some(under) if on => {
                    count += 1;
                    for (c, &w) in self.exemplars.weights().iter().enumerate() {
                        let t = self.features[c * template.len() + template.index(x)];
                        error += u64::from(w) * u64::from(t.abs_diff(source.features.get(c, under))).pow(2);
                    }
                }
                None if self.placement.cover == Cover::Box => return None,
                None if on && self.placement.cover == Cover::Mask => return None,
                _ => {}
            }
        }
        match self.placement.cover {
            Cover::AtLeast(least) if count < least.max(1) => None,
            _ => Some((error, count)),
        }
    }
}
