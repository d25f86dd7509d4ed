//! Does an exemplar repeat itself? Autocorrelation, on a coarse copy of it.

use selvedge_core::{Domain, Exemplars, Source};

/// Samples of the coarse copy at most: its autocorrelation takes the square of their number.
const COARSE_SAMPLES: usize = 3000;

/// How regularly the exemplars repeat themselves, from 0 to 2: the height of the best peak of the autocorrelation
/// (-1 to 1) above the lowest value between it and the centre, of the most regular exemplar.
///
/// Of the textures it was tried on, text, keyboards and baskets reach 1.1 and more, fruit, peas, crowds and brick walls with
/// uneven courses stay between 0.2 and 0.8. Of an exemplar in several orientations the first counts.
///
/// Time: about 10^7 operations a channel of each exemplar, whatever the size.
pub fn periodicity<const D: usize>(exemplars: &Exemplars<D>) -> f64 {
    let mut last = None;
    let first = |s: &&Source<D>| last.replace(s.origin.exemplar) != Some(s.origin.exemplar);
    let sources = exemplars.sources().iter().filter(first);
    sources.map(|source| periodicity_of(&Coarse::new(source, exemplars.weights()))).fold(0.0, f64::max)
}

fn periodicity_of<const D: usize>(coarse: &Coarse<D>) -> f64 {
    let shape = coarse.domain.shape;
    // Shifts up to half of each side, one of each pair of opposites.
    let reach = shape.map(|n| n / 2);
    let shifts = Domain::open(reach.map(|r| 2 * r + 1));
    let centre = shifts.len() / 2;
    let vector = |i: usize| -> [i32; D] {
        let at = shifts.position(i);
        std::array::from_fn(|a| at[a] as i32 - reach[a] as i32)
    };
    let half = selvedge_core::par::map_indexed(centre + 1, |i| coarse.correlation(vector(i)));
    let at = |v: [i32; D]| {
        let i = shifts.index(std::array::from_fn(|a| (v[a] + reach[a] as i32) as u32));
        half[i.min(shifts.len() - 1 - i)]
    };
    (0..centre).map(|i| at(vector(i)) - lowest_between(vector(i), at)).fold(0.0, f64::max)
}

/// The least correlation on the way from no shift to this one.
fn lowest_between<const D: usize>(to: [i32; D], at: impl Fn([i32; D]) -> f64) -> f64 {
    let steps = to.iter().map(|c| c.abs()).max().unwrap_or(0);
    (0..=steps).map(|s| at(to.map(|c| (c * s + (steps / 2) * c.signum()) / steps.max(1)))).fold(1.0, f64::min)
}

/// An exemplar at a resolution low enough to compare it with itself everywhere; centred, channel by channel.
struct Coarse<const D: usize> {
    domain: Domain<D>,
    channels: Vec<Vec<f64>>,
    known: Vec<bool>,
}

impl<const D: usize> Coarse<D> {
    fn new(source: &Source<D>, weights: &[u8]) -> Self {
        let fine = source.domain();
        let mut factor = 1;
        let shape = |factor: u32| fine.shape.map(|n| n.div_ceil(factor));
        while COARSE_SAMPLES < shape(factor).iter().map(|&n| n as usize).product() {
            factor += 1;
        }
        let domain = Domain::open(shape(factor));
        let mut counts = vec![0_u32; domain.len()];
        let mut sums = vec![vec![0.0; domain.len()]; weights.len()];
        for (i, at) in fine.positions().enumerate() {
            if source.valid.as_ref().is_none_or(|v| v.samples()[i]) {
                let cell = domain.index(at.map(|p| p / factor));
                counts[cell] += 1;
                sums.iter_mut().enumerate().for_each(|(c, s)| s[cell] += f64::from(source.features.plane(c)[i]));
            }
        }
        let known: Vec<bool> = counts.iter().map(|&n| 0 < n).collect();
        for (sum, &weight) in sums.iter_mut().zip(weights) {
            sum.iter_mut().zip(&counts).for_each(|(s, &n)| *s /= f64::from(n.max(1)));
            let total: f64 = sum.iter().zip(&known).filter(|(_, k)| **k).map(|(s, _)| s).sum();
            let mean = total / known.iter().filter(|k| **k).count().max(1) as f64;
            sum.iter_mut().for_each(|s| *s = (*s - mean) * f64::from(weight).sqrt());
        }
        Self { domain, channels: sums, known }
    }

    /// Correlation of the exemplar with itself, shifted; from -1 to 1.
    fn correlation(&self, shift: [i32; D]) -> f64 {
        let (mut product, mut here, mut there) = (0.0, 0.0, 0.0);
        for (i, at) in self.domain.positions().enumerate() {
            let Some(to) = self.domain.step(at, shift).map(|to| self.domain.index(to)) else { continue };
            if !self.known[i] || !self.known[to] {
                continue;
            }
            for channel in &self.channels {
                let (a, b) = (channel[i], channel[to]);
                (product, here, there) = (product + a * b, here + a * a, there + b * b);
            }
        }
        let scale = (here * there).sqrt();
        if 0.0 < scale { product / scale } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Seed, Transform};

    fn of(value: impl Fn(u32, u32) -> u8) -> f64 {
        let domain = Domain::open([60, 70]);
        let samples = domain.positions().map(|[y, x]| value(y, x)).collect();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let source = Source { features: Grid::from_vec(domain, 1, samples).unwrap(), valid: None, origin };
        periodicity(&Exemplars::from_sources(vec![source], vec![1]).unwrap())
    }

    #[test]
    fn regular_textures_are_told_from_noise() {
        assert!(of(|y, x| if (y / 8 + x / 8) % 2 == 0 { 200 } else { 40 }) > 0.9);
        let noise = of(|y, x| Seed(1).derive("noise", u64::from(y * 70 + x)).0 as u8);
        assert!(noise < 0.3, "{noise}");
        assert_eq!(of(|_, _| 7), 0.0);
    }
}
