//! Differences between samples that lie beside each other, as heavy as colours or heavier: the gradient energy.
//! `[Kwatra05 3]`

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, Source, par};

use crate::assignment::Place;
use crate::average::{Fields, sums};
use crate::cg::System;
use crate::control::Wishes;
use crate::error::Error;
use crate::search::Measure;

/// Grey levels by which a sample may be wrong in the mean: searches round to whole ones.
const TOLERANCE: f64 = 1e-4;

/// The step from a sample to the next along an axis.
const STEPS: [[i32; 2]; 2] = [[1, 0], [0, 1]];

/// The level of no difference in 8 bits. What differs by more than 127 is an edge of full contrast either way.
const NONE: f64 = 128.0;

/// Channels of samples, and which of them may be seen.
#[derive(Clone, Copy)]
struct Shown<'a, T> {
    samples: &'a Grid<T, 2>,
    valid: Option<&'a Grid<bool, 2>>,
}

impl<T: Copy + Into<f64>> Shown<'_, T> {
    /// What an axis's differences are, each at its first sample; at a far open edge, and before what is masked, that
    /// before it. Neighborhoods hold no masked sample, but the last of them lie beside some.
    fn difference(self, c: usize, axis: usize, at: [u32; 2]) -> f64 {
        let seen = |at: [u32; 2]| self.valid.is_none_or(|valid| valid.get(0, at)).then_some(at);
        let value = |at: [u32; 2]| Some(self.samples.get(c, seen(at)?).into());
        let step = |by: [i32; 2]| self.samples.domain().step(at, by);
        let after = || Some(value(step(STEPS[axis])?)? - value(at)?);
        let before = || Some(value(at)? - value(step(STEPS[axis].map(|by| -by))?)?);
        after().or_else(before).unwrap_or(0.0)
    }
}

/// A picture of which all is seen.
fn whole<T>(samples: &Grid<T, 2>) -> Shown<'_, T> {
    Shown { samples, valid: None }
}

/// What exemplars show.
fn of_source(source: &Source<2>) -> Shown<'_, u8> {
    Shown { samples: &source.features, valid: source.valid.as_deref() }
}

/// Exemplars as searches compare them: their channels, then the differences down and across of the first `texture`
/// ones, each of which counts `mu` times what its channel does.
pub(crate) fn searched(exemplars: &Exemplars<2>, texture: usize, mu: f64) -> Result<Exemplars<2>, CoreError> {
    let own = &exemplars.weights()[..texture];
    let heavy = |weights: &[u8]| weights.iter().map(|&w| f64::from(w)).sum::<f64>();
    let weight = 2.0 * mu * heavy(own) / heavy(exemplars.weights());
    let maps = exemplars.sources().iter().map(|source| differences(of_source(source), texture));
    exemplars.extended(maps.collect::<Result<_, _>>()?, &own.repeat(2), weight)
}

/// Differences in 8 bits, down and across.
fn differences<T: Copy + Into<f64> + Sync>(x: Shown<'_, T>, texture: usize) -> Result<Grid<u8, 2>, CoreError> {
    let domain = x.samples.domain();
    let mut out = Grid::try_filled(domain, 2 * texture, 0)?;
    for (axis, c) in (0..2).flat_map(|axis| (0..texture).map(move |c| (axis, c))) {
        let width = domain.shape[1] as usize;
        par::for_rows(out.plane_mut(axis * texture + c), width, |y, row| {
            for (column, v) in (0..).zip(row) {
                *v = (NONE + x.difference(c, axis, [y as u32, column]) + 0.5).clamp(0.0, 255.0) as u8;
            }
        });
    }
    Ok(out)
}

/// A picture as searches see it: rounded to 8 bits, with its differences where they are compared.
pub(crate) fn seen(x: &Grid<f64, 2>, texture: Option<usize>) -> Result<Grid<u8, 2>, CoreError> {
    let rounded = x.map(|v| (v + 0.5).clamp(0.0, 255.0) as u8)?;
    let Some(texture) = texture else { return Ok(rounded) };
    let differences = differences(whole(x), texture)?;
    let mut all = Grid::try_filled(x.domain(), x.channels() + differences.channels(), 0)?;
    let (own, more) = all.samples_mut().split_at_mut(rounded.samples().len());
    own.copy_from_slice(rounded.samples());
    more.copy_from_slice(differences.samples());
    Ok(all)
}

impl Measure<'_> {
    /// The E-step with gradients: the texture that minimises
    /// `sum of omega_p (G (x - z_p)^2 + mu G_e (Dx - Dz_p)^2)`, and `lambda (x - x_c)^2` of wishes, from one that is
    /// there. `G_e` of two samples is the mean of theirs.
    ///
    /// Its normal equations have a diagonal and the four neighbours; they are solved by conjugate gradients that never
    /// leave the energy higher than it was.
    ///
    /// Solves for `x`, in place. `whole` is what neighborhoods of weight 1 weigh together over each sample.
    pub(crate) fn solve(
        &self,
        x: &mut Grid<f64, 2>,
        (found, weights): (&[Place], &[f64]),
        (wishes, whole): (Option<&Wishes>, &[f64]),
    ) -> Result<(), Error> {
        self.solve_to(x, (found, weights), (wishes, whole), TOLERANCE)
    }

    fn solve_to(
        &self,
        x: &mut Grid<f64, 2>,
        (found, weights): (&[Place], &[f64]),
        (wishes, whole): (Option<&Wishes>, &[f64]),
        tolerance: f64,
    ) -> Result<(), Error> {
        let (domain, channels) = (self.all.domain, self.exemplars.channels());
        let fields = Fields::of(self.exemplars);
        let colors = sums(&fields, self.all, found, weights, [self.falloff.along(); 2])?;
        let between = self.falloff.between();
        let mut edges = Vec::new();
        for axis in 0..2 {
            let own = |source: &Source<2>| signed(of_source(source), axis, self.texture);
            let own = self.exemplars.sources().iter().map(|source| own(source)).collect::<Result<Vec<_>, _>>()?;
            let along = if axis == 0 { [&between[..], self.falloff.along()] } else { [self.falloff.along(), &between] };
            edges.push(sums(&Fields(own.iter().collect()), self.all, found, weights, along)?);
        }
        for c in 0..channels {
            // A guide is not differentiated.
            let mu = if c < self.texture { self.mu } else { 0.0 };
            let mut system = System::new(domain, colors.plane(channels), colors.plane(c))?;
            if mu != 0.0 {
                for (axis, edges) in edges.iter().enumerate() {
                    system.tie(axis, edges.plane(self.texture), edges.plane(c), mu);
                }
            }
            if let Some(wishes) = wishes {
                let each = wishes.weights.plane(c).iter().zip(wishes.colors.plane(c)).zip(whole).enumerate();
                each.for_each(|(i, ((&lambda, &color), &whole))| system.wish(i, lambda * whole, color));
            }
            system.solve(x.plane_mut(c), tolerance)?;
        }
        Ok(())
    }
}

/// Differences of the first channels, as they are.
fn signed(features: Shown<'_, u8>, axis: usize, texture: usize) -> Result<Grid<i16, 2>, CoreError> {
    let domain: Domain<2> = features.samples.domain();
    let mut out = Grid::try_filled(domain, texture, 0)?;
    for c in 0..texture {
        let of = |at: [u32; 2]| features.difference(c, axis, at) as i16;
        out.plane_mut(c).iter_mut().zip(domain.positions()).for_each(|(v, at)| *v = of(at));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::falloff::Falloff;
    use crate::neighborhoods::Neighborhoods;
    use crate::search::{Exact, How};
    use crate::testing::{exemplars, output};
    use selvedge_core::{Rng, Seed, SimdLevel};

    const MU: f64 = 10.0;

    fn noise(rng: &mut Rng, domain: Domain<2>, channels: usize) -> Grid<f64, 2> {
        let samples = (0..domain.len() * channels).map(|_| f64::from(rng.below(256))).collect();
        Grid::from_vec(domain, channels, samples).unwrap()
    }

    /// The energy by its definition: of all neighborhoods, of weights and wishes.
    fn energy(
        measure: &Measure<'_>,
        x: &Grid<f64, 2>,
        (found, weights): (&[Place], &[f64]),
        (wishes, whole): (&Wishes, &[f64]),
    ) -> f64 {
        let exemplars = measure.exemplars.clone().weighing(vec![1; 2]).unwrap();
        let (falloff, mu) = (measure.falloff, measure.mu);
        let measure = Measure { exemplars: &exemplars, ..*measure };
        // Means over samples, colours and differences of both channels.
        let compared = falloff.sum() * 2.0 * (1.0 + 2.0 * mu);
        let of =
            |(i, (&place, weight)): (usize, (&Place, &f64))| weight * measure.distance(x, (i, place), f64::INFINITY);
        let texture: f64 = found.iter().zip(weights).enumerate().map(of).sum::<f64>() * compared;
        let wish = |i: usize, c: usize| {
            let by = x.plane(c)[i] - wishes.colors.plane(c)[i];
            whole[i] * wishes.weights.plane(c)[i] * by * by
        };
        texture + (0..2).flat_map(|c| (0..whole.len()).map(move |i| wish(i, c))).sum::<f64>()
    }

    #[test]
    fn the_texture_found_is_where_the_energy_is_least() {
        for case in 0..8 {
            let mut rng = Seed(case).derive("gradient", 0).rng();
            let exemplars = exemplars(&mut rng, [12, 15], false);
            let all = Neighborhoods::new(output(&mut rng, 8), 8);
            let found = crate::assignment::random(&exemplars, &all, Seed(case)).unwrap();
            let weights: Vec<f64> = (0..all.len()).map(|_| 0.25 + f64::from(rng.below(8)) / 4.0).collect();
            let falloff = Falloff::new(8);
            let measure = Measure { exemplars: &exemplars, all: &all, falloff: &falloff, mu: MU, texture: 2 };
            let colors = noise(&mut rng, all.domain, 2);
            let lambda = noise(&mut rng, all.domain, 2).map(|v| if v < 200.0 { 0.0 } else { v / 100.0 }).unwrap();
            let wishes = Wishes { colors, weights: lambda, texture: 2 };
            let whole: Vec<f64> = (0..all.domain.len()).map(|_| 0.5 + f64::from(rng.below(8))).collect();
            let mut x = noise(&mut rng, all.domain, 2);
            let by = ((&found[..], &weights[..]), (&wishes, &whole[..]));
            let before = energy(&measure, &x, by.0, by.1);
            measure.solve_to(&mut x, by.0, (Some(&wishes), &whole), 1e-10).unwrap();
            let least = energy(&measure, &x, by.0, by.1);
            assert!(least < before);
            // It is quadratic: from its minimum on it rises by the same either way.
            for _ in 0..30 {
                let (c, at) = (rng.below(2) as usize, all.domain.position(rng.below(all.domain.len() as u32) as usize));
                let moved = |by: f64| {
                    let mut x = x.clone();
                    x.set(c, at, x.get(c, at) + by);
                    energy(&measure, &x, (&found, &weights), (&wishes, &whole)) - least
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                assert!(0.0 < up && (up - down).abs() < 1e-6 * up, "{case} {c} {at:?}: {up}, {down}");
            }
        }
    }

    #[test]
    fn found_neighborhoods_are_near_in_their_differences() {
        let (mut others, mut apart) = (0, 0.0_f64);
        for case in 0..12 {
            let mut rng = Seed(case).derive("differences", 0).rng();
            let exemplars = exemplars(&mut rng, [14, 17], true);
            let all = Neighborhoods::new(output(&mut rng, 8), 8);
            // Differences within 127 levels, which 8 bits hold as they are.
            let x = noise(&mut rng, all.domain, 2).map(|v| (v / 2.0).floor()).unwrap();
            let searched = searched(&exemplars, 2, MU).unwrap();
            let how = How { differences: Some(2), ..How::default() };
            let mut exact = Exact::new(&searched, &all, how, SimdLevel::Auto);
            let found = exact.search(&x).unwrap().unwrap();
            // By the definition, each difference at its first sample, with those that leave a neighborhood.
            let distance = |number: usize, place: Place| {
                let source = &exemplars.sources()[place.source as usize];
                let shape = all.domain.shape;
                let mut sum = 0.0;
                for (by, c) in Domain::open([8, 8]).positions().flat_map(|by| [(by, 0), (by, 1)]) {
                    let here = [0, 1].map(|a| (all.first(number)[a] + by[a]) % shape[a]);
                    let there = place.sample(&exemplars, by);
                    let color = x.get(c, here) - f64::from(source.features.get(c, there));
                    let of = |axis| {
                        let differs = whole(&x).difference(c, axis, here);
                        let there = of_source(source).difference(c, axis, there).clamp(-128.0, 127.0);
                        (differs - there) * (differs - there)
                    };
                    sum += f64::from(exemplars.weights()[c]) * (color * color + MU * (of(0) + of(1)));
                }
                sum
            };
            let measure = Measure { exemplars: &exemplars, all: &all, falloff: &Falloff::flat(8), mu: MU, texture: 2 };
            let plain = measure.search(&x, None).unwrap();
            for number in 0..all.len() {
                let places = exemplars.sources().iter().enumerate().flat_map(|(source, s)| {
                    crate::neighborhoods::places(s, 8).map(move |at| Place { source: source as u32, at })
                });
                let least = places.map(|place| distance(number, place)).fold(f64::INFINITY, f64::min);
                let own = distance(number, found.places[number]);
                assert!((own - least).abs() < 1e-6, "{case} {number}: {own}, least {least}");
                others += usize::from(found.places[number] != plain.places[number]);
                apart = apart
                    .max(measure.distance(&x, (number, found.places[number]), f64::INFINITY) / plain.distances[number]);
            }
        }
        // Differences that leave a neighborhood are one in eight: what is found by them is hardly worse.
        assert!(0 < others && apart < 1.25, "{others} others, up to {apart} times as far");
    }

    #[test]
    fn what_is_masked_is_never_searched() {
        for case in 0..8 {
            let mut rng = Seed(case).derive("masked", 0).rng();
            let drawn = exemplars(&mut rng, [9, 11], true);
            let with = |hidden: u8| {
                let mut sources: Vec<Source<2>> = drawn.sources().iter().map(|source| (**source).clone()).collect();
                let Source { features, valid, .. } = &mut sources[1];
                for at in valid.as_ref().unwrap().domain().positions() {
                    if !valid.as_ref().unwrap().get(0, at) {
                        (0..2).for_each(|c| features.set(c, at, hidden));
                    }
                }
                searched(&Exemplars::from_sources(sources, drawn.weights().to_vec()).unwrap(), 2, MU).unwrap()
            };
            let [dark, light] = [with(0), with(255)];
            let [dark, light] = [&dark.sources()[1], &light.sources()[1]];
            let seen = dark.features.domain().positions().filter(|&at| dark.valid.as_deref().unwrap().get(0, at));
            for (at, c) in seen.flat_map(|at| (0..dark.features.channels()).map(move |c| (at, c))) {
                assert_eq!(dark.features.get(c, at), light.features.get(c, at), "{case}: channel {c} at {at:?}");
            }
        }
    }
}
