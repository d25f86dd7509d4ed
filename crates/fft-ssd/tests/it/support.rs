//! Random searches and the slow definition of their answer.

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

/// Which samples of a box count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Region {
    Unmasked,
    Full,
    Empty,
    Holes,
    Rectangle,
    L,
    Ring,
}

impl Region {
    const ALL: [Self; 7] = [Self::Unmasked, Self::Full, Self::Empty, Self::Holes, Self::Rectangle, Self::L, Self::Ring];

    /// `None` if unmasked.
    fn mask<const D: usize>(self, rng: &mut Rng, domain: Domain<D>) -> Option<Vec<bool>> {
        let shape = domain.shape;
        let cut: [u32; D] = shape.map(|s| rng.below(s + 1));
        let density = 1 + rng.below(9);
        let mut counts = |at: [u32; D]| match self {
            Self::Unmasked | Self::Full => true,
            Self::Empty => false,
            Self::Holes => rng.below(10) < density,
            Self::Rectangle => at.iter().zip(&cut).all(|(a, c)| a < c),
            Self::L => at.iter().zip(&cut).any(|(a, c)| a < c),
            Self::Ring => {
                let r2: u32 = at.iter().zip(&shape).map(|(&a, &s)| (2 * a + 1).abs_diff(s).pow(2)).sum();
                density * 4 < r2
            }
        };
        (self != Self::Unmasked).then(|| domain.positions().map(&mut counts).collect())
    }
}

/// How long the sides of sources and templates are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sides {
    /// Any length, or 1, or a prime, axis by axis.
    Mixed,
    Prime,
    /// One row of up to 64: all axes but the last have length 1.
    Row,
    /// One column of up to 64: all axes but the last but one (the only one of a line) have length 1.
    Column,
    /// The template is as large as the first source.
    Same,
}

impl Sides {
    const ALL: [Self; 5] = [Self::Mixed, Self::Prime, Self::Row, Self::Column, Self::Same];

    fn shape<const D: usize>(self, rng: &mut Rng, side: u32) -> [u32; D] {
        let primes = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61];
        let long = match self {
            Self::Row => D - 1,
            _ => D.saturating_sub(2),
        };
        let fitting = primes.iter().take_while(|&&p| p <= side).count();
        let length = |axis: usize| {
            let (any, prime) = (1 + rng.below(side), primes[rng.below(fitting as u32) as usize]);
            match self {
                Self::Prime => prime,
                Self::Row | Self::Column if axis != long => 1,
                Self::Row | Self::Column => 1 + rng.below(64),
                Self::Mixed | Self::Same => pick(rng, &[any, any, prime, 1]),
            }
        };
        std::array::from_fn(length)
    }
}

/// What a case is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) channels: usize,
    pub(crate) region: Region,
    pub(crate) sides: Sides,
    pub(crate) positions: Positions,
}

impl Kind {
    /// Different kinds: 1 to 8 channels, every region and sides, inside, circular and overlapping.
    pub(crate) const COUNT: u64 = 8 * 7 * 5 * 3;

    /// Any [`COUNT`](Self::COUNT) numbers in a row are all kinds.
    pub(crate) fn nth(number: u64) -> Self {
        let mut left = number;
        let mut digit = |base: usize| {
            let digit = left % base as u64;
            left /= base as u64;
            digit as usize
        };
        let positions = [Positions::Inside, Positions::Circular, Positions::Overlapping];
        Self {
            positions: positions[digit(3)],
            sides: Sides::ALL[digit(5)],
            region: Region::ALL[digit(7)],
            channels: 1 + digit(8),
        }
    }
}

impl<const D: usize> Case<D> {
    /// Any kind.
    pub(crate) fn random(rng: &mut Rng, side: u32) -> Self {
        let kind = Kind::nth(u64::from(rng.below(Kind::COUNT as u32)));
        Self::of(kind, rng, side)
    }

    /// Sides up to `side`, but for rows and columns; one or two sources, some with holes, some periodic; weights and
    /// covers of all sorts.
    pub(crate) fn of(kind: Kind, rng: &mut Rng, side: u32) -> Self {
        let channels = kind.channels;
        let weights: Vec<u8> = match rng.below(3) {
            0 => (0..channels).map(|_| rng.below(256) as u8).collect(),
            1 => [77, 150, 29, 255, 1, 2, 0, 9][..channels].to_vec(),
            _ => vec![1; channels],
        };
        let n = 1 + rng.below(2);
        let sources: Vec<_> = (0..n)
            .map(|e| {
                let shape = kind.sides.shape(rng, side);
                Self::source(rng, e as u16, channels, shape)
            })
            .collect();
        let same = sources[0].domain().shape;
        let shape: [u32; D] = if kind.sides == Sides::Same { same } else { kind.sides.shape(rng, side) };
        let exemplars = Exemplars::from_sources(sources, weights).expect("sources are well formed");
        let domain = Domain::open(shape);
        let cover = pick(rng, &[Cover::Box, Cover::Box, Cover::Mask, Cover::AtLeast(1)]);
        let cover = if cover == Cover::AtLeast(1) { Cover::AtLeast(u64::from(rng.below(9))) } else { cover };
        let features = noise(rng, domain.len() * channels);
        let mask = kind.region.mask(rng, domain);
        Self { exemplars, shape, features, mask, placement: Placement { positions: kind.positions, cover } }
    }

    fn source(rng: &mut Rng, exemplar: u16, channels: usize, shape: [u32; D]) -> Source<D> {
        let domain = Domain { shape, periodic: shape.map(|_| rng.below(8) == 0) };
        let features = Grid::from_vec(domain, channels, noise(rng, domain.len() * channels)).expect("right length");
        let region = pick(rng, &Region::ALL);
        let valid = (rng.below(3) == 0).then(|| region.mask(rng, Domain::open(shape))).flatten();
        // At least one sample must be valid.
        let valid = valid.filter(|v| v.contains(&true)).map(|v| Grid::from_vec(domain, 1, v).expect("right length"));
        Source { features, valid: valid.map(Into::into), origin: Origin { exemplar, transform: Transform::IDENTITY } }
    }

    /// True if all samples of a part of the template, by its start and shape, stand on valid samples.
    pub(crate) fn stands(&self, source: usize, position: [i32; D], part: Option<([u32; D], [u32; D])>) -> bool {
        let Some((start, part)) = part else { return true };
        let source = &self.exemplars.sources()[source];
        Domain::open(part).positions().all(|x| {
            let by = std::array::from_fn(|a| position[a] + (start[a] + x[a]) as i32);
            let under = source.domain().step([0; D], by);
            under.is_some_and(|u| source.valid.as_deref().is_none_or(|v| v.get(0, u)))
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
            let under = wrapped.step([0; D], by).filter(|&u| source.valid.as_deref().is_none_or(|v| v.get(0, u)));
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
