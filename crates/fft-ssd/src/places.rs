//! A template at single places: for who looks at a few, and knows from which error on one does not matter.

use crate::memory::reserve;
use crate::stretch::Stretch;
use crate::{Error, SsdSearcher, Template};

/// Samples of a stretch at most: the sum of its squares fits 32 bits.
const LONGEST: usize = 1 << 15;
/// Parts in which a place is compared: after each its sum may be too much. Each asks for a call, whose cost is that of
/// some 100 samples.
const PARTS: usize = 8;

/// A template, made ready to be compared with single places of a searcher's sources.
#[derive(Debug)]
pub struct Pattern<'t> {
    shape: [u32; 2],
    features: &'t [u8],
    /// Far apart in the template where they are near each other here: what is unlike shows in the first ones.
    stretches: Vec<Stretch>,
}

/// A place, and how far it was compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The source, in the order of the searcher's.
    pub source: usize,
    /// Where the template's first sample stands.
    pub at: [u32; 2],
    /// Sum of the weighted squared differences so far: all of it once [`Pattern::is_done`].
    pub error: u64,
    /// Stretches that are part of it.
    done: usize,
}

impl Place {
    /// A place that was not looked at yet.
    pub fn new(source: usize, at: [u32; 2]) -> Self {
        Self { source, at, error: 0, done: 0 }
    }
}

impl<'t> Pattern<'t> {
    /// What is compared of a template of so many channels.
    ///
    /// # Errors
    /// Those of a template that fits no searcher of so many channels, and [`Error::Core`] if memory is short.
    pub fn new(template: &Template<'t, 2>, channels: usize) -> Result<Self, Error> {
        template.check(channels)?;
        let [height, width] = template.shape.map(|n| n as usize);
        let mut rows = Vec::new();
        for y in 0..height {
            let counts = |x: usize| template.mask.is_none_or(|m| m[y * width + x]);
            let mut x = 0;
            while x < width {
                let len = (x..width).take_while(|&x| counts(x)).count().min(LONGEST);
                if len != 0 {
                    reserve(&mut rows, 1)?;
                    rows.push(Stretch { own: y * width + x, at: [y, x], len });
                }
                x += len.max(1);
            }
        }
        let mut order: Vec<usize> = Vec::new();
        reserve(&mut order, rows.len())?;
        order.extend(0..rows.len());
        order.sort_unstable_by_key(|i| i.reverse_bits());
        let mut stretches = Vec::new();
        reserve(&mut stretches, rows.len())?;
        stretches.extend(order.into_iter().map(|i| rows[i]));
        Ok(Self { shape: template.shape, features: template.features, stretches })
    }

    /// True if no sample is compared.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }

    /// True if the place was compared to the end.
    pub fn is_done(&self, place: &Place) -> bool {
        place.done == self.stretches.len()
    }
}

impl SsdSearcher<'_, 2> {
    /// Goes on with the comparison at a place: by an eighth of the template, and then until that is done, or the error
    /// is more than `most`. Validity is not looked at.
    ///
    /// # Panics
    /// If the template does not lie inside of the source there, or has other channels than the searcher.
    pub fn compare(&self, pattern: &Pattern<'_>, place: &mut Place, most: u64) {
        let source = &self.source(place.source);
        let (stride, shape) = (source.shape[2], pattern.shape.map(|n| n as usize));
        let samples = shape[0] * shape[1];
        let is_inside = (0..2).all(|a| place.at[a] as usize + shape[a] <= source.shape[a + 1]);
        assert!(is_inside, "templates lie inside of sources");
        assert!(pattern.features.len() == samples * self.channels(), "a template has the searcher's channels");
        let first = place.at[0] as usize * stride + place.at[1] as usize;
        let step = pattern.stretches.len().div_ceil(PARTS);
        loop {
            let end = (place.done + step).min(pattern.stretches.len());
            let part = &pattern.stretches[place.done..end];
            for (c, &weight) in self.weights().iter().enumerate() {
                let own = &pattern.features[c * samples..(c + 1) * samples];
                let squares = self.kernel().squares(own, &source.plane(c)[first..], stride, shape, part);
                place.error = place.error.saturating_add(u64::from(weight) * squares);
            }
            place.done = end;
            if pattern.is_done(place) || most < place.error {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Costs, Options, Placement, Scratch};
    use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, SimdLevel, Source, Transform};

    /// Two sources of noise, and a template with a mask cut out of nowhere.
    fn case(seed: u64) -> (Exemplars<2>, [u32; 2], Vec<u8>, Vec<bool>) {
        let mut rng = Seed(seed).derive("places", 0).rng();
        let shape = [1 + rng.below(9), 1 + rng.below(90)];
        let sources = (0..2).map(|exemplar| {
            let domain = Domain::open([shape[0] + rng.below(9), shape[1] + rng.below(30)]);
            let samples = (0..3 * domain.len()).map(|_| rng.below(256) as u8).collect();
            let origin = Origin { exemplar, transform: Transform::IDENTITY };
            Source { features: Grid::from_vec(domain, 3, samples).unwrap(), valid: None, origin }
        });
        let exemplars = Exemplars::from_sources(sources.collect(), vec![1, 255, 7]).unwrap();
        let len = shape[0] * shape[1];
        // Of some templates everything is compared.
        let most = 1 + rng.below(8);
        let features = (0..3 * len).map(|_| 255 * rng.below(2) as u8).collect();
        let mask = (0..len).map(|i| i / 40 % 2 == 0 || rng.below(8) < most).collect();
        (exemplars, shape, features, mask)
    }

    #[test]
    fn errors_at_places_are_those_of_the_search() {
        for seed in 0..40 {
            let (exemplars, shape, features, mask) = case(seed);
            let template = Template::new(shape, &features).masked(&mask);
            let pattern = Pattern::new(&template, 3).unwrap();
            for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Auto] {
                let searcher = SsdSearcher::with_options(&exemplars, Options { simd, ..Options::default() }).unwrap();
                let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
                searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs).unwrap();
                for candidate in costs.iter() {
                    let mut place = Place::new(candidate.source, candidate.position.map(|p| p as u32));
                    searcher.compare(&pattern, &mut place, candidate.error / 3);
                    let early = place.error;
                    assert!(pattern.is_done(&place) || candidate.error / 3 < early && early <= candidate.error);
                    if !pattern.is_done(&place) {
                        searcher.compare(&pattern, &mut place, u64::MAX);
                    }
                    assert_eq!((place.error, pattern.is_done(&place)), (candidate.error, true), "{seed} {simd:?}");
                }
            }
        }
    }

    #[test]
    fn sums_of_long_and_unlike_rows_do_not_wrap() {
        let domain = Domain::open([40, 70_000]);
        let source = Source {
            features: Grid::try_filled(domain, 1, 255).unwrap(),
            valid: None,
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        let exemplars = Exemplars::from_sources(vec![source], vec![2]).unwrap();
        let features = vec![0_u8; domain.len()];
        let pattern = Pattern::new(&Template::new(domain.shape, &features), 1).unwrap();
        for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::Auto] {
            let searcher = SsdSearcher::with_options(&exemplars, Options { simd, ..Options::default() }).unwrap();
            let mut place = Place::new(0, [0, 0]);
            searcher.compare(&pattern, &mut place, u64::MAX);
            assert_eq!(place.error, domain.len() as u64 * 2 * 255 * 255, "{simd:?}");
        }
    }
}
