//! Light that differs from place to place: what means over far more than a feature show.
//!
//! A patch from the lit side beside one from the dark side is a seam that no cut hides. Decisions that look past the
//! light ([`Exemplars::ignoring_light`]) let texture meet texture, and joins blended over bands as wide carry the
//! shade; samples without it ([`Plane::flattened`]) need no blending, but are no copies any more.

use half::f16;

use crate::{Bytes, Domain, Error, Exemplars, Grid, Plane, Samples, par, try_vec};

/// Of the lesser side: what means over a third of it show is light, as the analysis of textures has it.
const REACH: u32 = 6;

/// Means over boxes, taken twice along each of the last two axes, of what is known; the axes wrap where the domain's
/// do.
struct Shade<const D: usize> {
    /// Sums of the weights of what lies around each sample.
    weights: Vec<f64>,
    radius: u32,
    domain: Domain<D>,
}

impl<const D: usize> Shade<D> {
    /// Of samples that have these weights, 0 where nothing is known.
    fn new(domain: Domain<D>, radius: u32, weight: impl Fn(usize) -> f64) -> Result<Self, Error> {
        let mut weights = try_vec(domain.len(), 0.0)?;
        weights.iter_mut().enumerate().for_each(|(i, w)| *w = weight(i));
        let mut shade = Self { weights: Vec::new(), radius, domain };
        shade.spread(&mut weights)?;
        shade.weights = weights;
        Ok(shade)
    }

    /// The shade of values that their weights were multiplied to, and its mean over all that is known.
    fn of(&self, value: impl Fn(usize) -> f64, weight: impl Fn(usize) -> f64) -> Result<(Vec<f64>, f64), Error> {
        let mut sums = try_vec(self.domain.len(), 0.0)?;
        sums.iter_mut().enumerate().for_each(|(i, sum)| *sum = value(i));
        self.spread(&mut sums)?;
        sums.iter_mut().zip(&self.weights).for_each(|(sum, w)| *sum = if 0.0 < *w { *sum / w } else { 0.0 });
        let (all, known) = sums.iter().enumerate().fold((0.0, 0.0), |(all, known), (i, shade)| {
            let w = weight(i);
            (all + shade * w, known + w)
        });
        Ok((sums, if 0.0 < known { all / known } else { 0.0 }))
    }

    /// Sums over boxes, taken twice along each axis.
    fn spread(&self, values: &mut [f64]) -> Result<(), Error> {
        for axis in D.saturating_sub(2)..D {
            for _ in 0..2 {
                self.boxed(axis, values)?;
            }
        }
        Ok(())
    }

    fn boxed(&self, axis: usize, values: &mut [f64]) -> Result<(), Error> {
        let (side, stride) = (self.domain.shape[axis] as usize, self.domain.strides()[axis]);
        let mut before = try_vec(side + 1, 0.0)?;
        let radius = (self.radius as usize).min(side);
        for line in 0..values.len() / side.max(1) {
            let first = line / stride * stride * side + line % stride;
            for i in 0..side {
                before[i + 1] = before[i] + values[first + i * stride];
            }
            for i in 0..side {
                let (begin, end) = (i as isize - radius as isize, i + radius + 1);
                let inside = before[end.min(side)] - before[begin.max(0) as usize];
                let around = match self.domain.periodic[axis] {
                    true if side <= 2 * radius => before[side] - inside,
                    true if begin < 0 => before[side] - before[(side as isize + begin) as usize],
                    true if side < end => before[end - side],
                    _ => 0.0,
                };
                values[first + i * stride] = inside + around;
            }
        }
        Ok(())
    }
}

/// What the work on one source or plane of this domain takes at most, beside its result.
fn working(samples: u64) -> Bytes {
    Bytes(samples.saturating_mul(2 * size_of::<f64>() as u64))
}

impl<const D: usize> Exemplars<D> {
    /// The same with a share (0 to 1) of the light taken out of the features: methods decide as if it were more even.
    /// The samples that are rendered stay what they are. Light is what means over a third of a source's lesser side
    /// show, without its mean; time is linear in the samples.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If the share is not within 0 to 1.
    pub fn ignoring_light(&self, share: f64) -> Result<Self, Error> {
        assert!((0.0..=1.0).contains(&share), "a share of {share}");
        let without = |source: &crate::Source<D>| {
            let domain = source.domain();
            let known = |i: usize| source.valid.as_deref().is_none_or(|valid| valid.samples()[i]);
            let weight = |i: usize| f64::from(u8::from(known(i)));
            let lesser = domain.shape[D.saturating_sub(2)..].iter().min().copied().unwrap_or(0);
            let shade = Shade::new(domain, lesser / REACH, weight)?;
            let mut features = source.features.map(|v| v)?;
            for c in 0..features.channels() {
                let plane = source.features.plane(c);
                let (low, mean) = shade.of(|i| weight(i) * f64::from(plane[i]), weight)?;
                let even = |v: u8, low: f64| (f64::from(v) - share * (low - mean) + 0.5).clamp(0.0, 255.0) as u8;
                features.plane_mut(c).iter_mut().zip(&low).for_each(|(v, &low)| *v = even(*v, low));
            }
            Ok(features)
        };
        let features = par::map_indexed(self.sources().len(), |s| without(&self.sources()[s]));
        self.with_features(features.into_iter().collect::<Result<_, _>>()?, self.weights().to_vec())
    }

    /// What [`ignoring_light`](Self::ignoring_light) takes at most beside the exemplars, from the domains of all
    /// sources.
    pub fn light_bytes(domains: &[Domain<D>], channels: usize) -> Bytes {
        let samples: u64 = domains.iter().map(|d| d.len() as u64).sum();
        Bytes(working(samples).0.saturating_add(samples.saturating_mul(channels as u64)))
    }
}

impl<const D: usize> Plane<D> {
    /// The plane without the light that means with a standard deviation of `sigma` samples show: its own mean stays.
    /// Integers, whose steps are about those of the eye, have it taken away; floats, which are amounts of light, are
    /// divided by it. What is transparent is not looked at. Normals stay as they are; along axes that wrap, so do the
    /// means.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If `sigma` is not above 0.
    pub fn flattened(&self, sigma: f64) -> Result<Self, Error> {
        assert!(0.0 < sigma, "a deviation of {sigma}");
        if self.role.is_normal() {
            return Ok(self.clone());
        }
        // Two boxes of width w have the variance (w^2 - 1) / 6.
        let radius = ((((6.0 * sigma * sigma + 1.0).sqrt() - 1.0) / 2.0).round() as u32).max(1);
        let known = self.validity()?;
        let (alpha, full) = (self.color_channels(), self.samples.depth().full());
        let weight = |i: usize| match &known {
            Some(known) if !known.samples()[i] => 0.0,
            Some(_) if self.is_premultiplied() => self.samples.value(alpha, i) / full,
            _ => 1.0,
        };
        let shade = Shade::new(self.domain(), radius, weight)?;
        let mut flat = self.clone();
        for c in 0..alpha {
            let shown = |i: usize| if 0.0 < weight(i) { self.samples.value(c, i) } else { 0.0 };
            let (low, mean) = shade.of(shown, weight)?;
            // What an amount of light is divided by; darkness and what lies below it tell nothing.
            let gain = |i: usize| if 0.0 < low[i].min(mean).min(weight(i)) { mean / low[i] } else { 1.0 };
            let less = |i: usize| (low[i] - mean) * weight(i);
            let even = |i: usize, v: f64| (v - less(i) + 0.5).clamp(0.0, full);
            match &mut flat.samples {
                Samples::U8(g) => each(g, c, |i, v| even(i, f64::from(v)) as u8),
                Samples::U16(g) => each(g, c, |i, v| even(i, f64::from(v)) as u16),
                Samples::F16(g) => each(g, c, |i, v| half(f16::from_bits(v).to_f64() * gain(i))),
                Samples::F32(g) => each(g, c, |i, v| (f64::from(v) * gain(i)) as f32),
            }
        }
        Ok(flat)
    }

    /// What [`flattened`](Self::flattened) takes at most beside its result, for a plane of so many samples.
    pub fn flattened_bytes(samples: u64) -> Bytes {
        working(samples)
    }
}

impl<const D: usize> Plane<D> {
    /// Colours as they are stored, multiplied by a gain and raised by an offset in parts of full scale, a pair a colour
    /// channel; integers end at their range. Alpha stays, and normals come back as they are.
    ///
    /// # Panics
    /// Unless there is a pair a colour channel.
    #[must_use]
    pub fn toned(&self, tones: &[[f64; 2]]) -> Self {
        let (alpha, full) = (self.color_channels(), self.samples.depth().full());
        assert_eq!(tones.len(), alpha, "a gain and an offset a channel");
        let mut toned = self.clone();
        if self.role.is_normal() {
            return toned;
        }
        // Less of the offset shows where less of the picture does.
        let weight = |i: usize| if self.is_premultiplied() { self.samples.value(alpha, i) / full } else { 1.0 };
        for (c, &[gain, offset]) in tones.iter().enumerate() {
            let of = |i: usize, v: f64| v * gain + offset * full * weight(i);
            let whole = |i: usize, v: f64| (of(i, v) + 0.5).clamp(0.0, full);
            match &mut toned.samples {
                Samples::U8(g) => each(g, c, |i, v| whole(i, f64::from(v)) as u8),
                Samples::U16(g) => each(g, c, |i, v| whole(i, f64::from(v)) as u16),
                Samples::F16(g) => each(g, c, |i, v| half(of(i, f16::from_bits(v).to_f64()))),
                Samples::F32(g) => each(g, c, |i, v| of(i, f64::from(v)) as f32),
            }
        }
        toned
    }
}

/// The nearest half float that is a number.
fn half(v: f64) -> u16 {
    let most = f16::MAX.to_f64();
    f16::from_f32(v.clamp(-most, most) as f32).to_bits()
}

fn each<T: Copy, const D: usize>(grid: &mut Grid<T, D>, channel: usize, f: impl Fn(usize, T) -> T) {
    grid.plane_mut(channel).iter_mut().enumerate().for_each(|(i, v)| *v = f(i, *v));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoder, Exemplar, Role, Seed};

    /// From the definition: every pair of steps along each axis has the weight of its ways there.
    fn naive(domain: Domain<2>, radius: i64, value: &[f64], weight: &[f64]) -> Vec<f64> {
        let [h, w] = domain.shape.map(i64::from);
        let steps = |at: i64, side: i64, periodic: bool| {
            let inside =
                move |p: i64| if periodic { Some(p.rem_euclid(side)) } else { (0..side).contains(&p).then_some(p) };
            let mut ways = vec![0.0; side as usize];
            let reach = if periodic && side <= 2 * radius { 0..side } else { -radius..radius + 1 };
            for middle in reach.clone().filter_map(|d| inside(at + d)) {
                reach.clone().filter_map(|d| inside(middle + d)).for_each(|p| ways[p as usize] += 1.0);
            }
            ways
        };
        let mut means = Vec::new();
        for at in domain.positions().map(|at| at.map(i64::from)) {
            let (rows, columns) = (steps(at[0], h, domain.periodic[0]), steps(at[1], w, domain.periodic[1]));
            let each = || domain.positions().map(|[y, x]| rows[y as usize] * columns[x as usize]);
            let sum = |of: &[f64]| each().zip(of).map(|(ways, v)| ways * v).sum::<f64>();
            means.push(if sum(weight) == 0.0 { 0.0 } else { sum(value) / sum(weight) });
        }
        means
    }

    #[test]
    fn shade_is_a_mean_over_boxes_taken_twice() {
        let mut rng = Seed(7).rng();
        for (shape, radius) in [([5, 7], 1), ([6, 4], 3), ([1, 9], 2), ([8, 8], 9)] {
            for periodic in [[false; 2], [true, false], [true; 2]] {
                let domain = Domain { shape, periodic };
                let weights: Vec<f64> = (0..domain.len()).map(|_| f64::from(rng.below(4).min(1) as u8)).collect();
                let values: Vec<f64> = weights.iter().map(|w| w * f64::from(rng.below(256) as u8)).collect();
                let shade = Shade::new(domain, radius, |i| weights[i]).unwrap();
                let (means, _) = shade.of(|i| values[i], |i| weights[i]).unwrap();
                for (a, b) in means.iter().zip(naive(domain, radius.into(), &values, &weights)) {
                    assert!((a - b).abs() < 1e-9, "{shape:?} {periodic:?} {radius}: {a} {b}");
                }
            }
        }
    }

    fn ramp(alpha: Option<u8>) -> Plane<2> {
        let of = |[y, x]: [u32; 2]| (if (x + y) % 2 == 0 { 40 } else { 60 }) + 3 * x as u8;
        let domain = Domain::open([40, 40]);
        let mut samples: Vec<u8> = domain.positions().map(of).collect();
        let Some(alpha) = alpha else {
            return Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()));
        };
        samples.extend(domain.positions().map(|[y, _]| if y < 20 { alpha } else { 255 }));
        Plane::with_alpha(Role::Color, Samples::U8(Grid::from_vec(domain, 2, samples).unwrap()))
    }

    /// Mean of the columns' differences from left to right, far from the border.
    fn slope(v: impl Fn([u32; 2]) -> f64) -> f64 {
        (24..40).map(|y| v([y, 30]) - v([y, 10])).sum::<f64>() / 16.0 / 20.0
    }

    #[test]
    fn a_ramp_is_ignored_and_the_samples_are_not() {
        let plane = [ramp(None)];
        let all = Exemplars::of(&[&plane]).unwrap();
        let slope = |e: &Exemplars<2>| slope(|at| f64::from(e.sources()[0].features.get(0, at)));
        let (half, none) = (all.ignoring_light(0.5).unwrap(), all.ignoring_light(1.0).unwrap());
        assert_eq!(all.ignoring_light(0.0).unwrap(), all);
        assert!(slope(&all) == 3.0 && (slope(&half) - 1.5).abs() < 0.3 && slope(&none).abs() < 0.3, "{}", slope(&none));
        let detail = |e: &Exemplars<2>| [0, 1].map(|x| i32::from(e.sources()[0].features.get(0, [20, 20 + x])));
        assert!((16..=24).contains(&(detail(&none)[1] - detail(&none)[0])), "{:?}", detail(&none));
    }

    #[test]
    fn what_a_mask_hides_is_no_light() {
        let plane = [ramp(None)];
        let mut mask = Grid::try_filled(Domain::open([40, 40]), 1, true).unwrap();
        let mut other = plane.clone();
        let Samples::U8(samples) = &mut other[0].samples else { unreachable!() };
        for at in Domain::open([20, 40]).positions() {
            mask.set(0, at, false);
            samples.set(0, at, 255);
        }
        let of = |plane: &[Plane<2>]| {
            let encoder = Encoder::fit(&[plane]).unwrap();
            let all = Exemplars::new(&encoder, &[Exemplar::new(plane).masked(Some(&mask))]).unwrap();
            all.ignoring_light(1.0).unwrap().sources()[0].features.samples()[800..].to_vec()
        };
        assert_eq!(of(&plane), of(&other));
    }

    #[test]
    fn planes_become_flat_in_every_depth() {
        let plane = ramp(None);
        let number = |p: &Plane<2>, at| p.samples.value(0, p.domain().index(at));
        let flat = plane.flattened(5.0).unwrap();
        assert!(slope(|at| number(&flat, at)).abs() < 0.2, "{}", slope(|at| number(&flat, at)));
        let floats = |f: &dyn Fn(f64) -> Samples<2>| Plane::new(Role::Color, f(1.0 / 255.0));
        let Samples::U8(bytes) = &plane.samples else { unreachable!() };
        let single = floats(&|by| Samples::F32(bytes.map(|v| (f64::from(v) * by) as f32).unwrap()));
        let short = floats(&|by| Samples::F16(bytes.map(|v| half(f64::from(v) * by)).unwrap()));
        let words = floats(&|_| Samples::U16(bytes.map(|v| u16::from(v) * 257).unwrap()));
        for (plane, unit) in [(single, 1.0 / 255.0), (short, 1.0 / 255.0), (words, 257.0)] {
            let flat = plane.flattened(5.0).unwrap();
            assert!(slope(|at| number(&flat, at) / unit).abs() < 0.2, "{:?}", plane.samples.depth());
        }
        let normals = Plane::new(Role::Normal, Samples::U8(bytes.map(|v| v).unwrap()));
        assert_eq!(normals.flattened(5.0).unwrap(), normals);
    }

    #[test]
    fn what_is_transparent_stays_and_gives_no_light() {
        let hidden = ramp(Some(0));
        let flat = hidden.flattened(5.0).unwrap();
        let (Samples::U8(before), Samples::U8(after)) = (&hidden.samples, &flat.samples) else { unreachable!() };
        assert_eq!(before.plane(0)[..800], after.plane(0)[..800]);
        assert_eq!(before.plane(1), after.plane(1));
        assert_ne!(before.plane(0)[800..], after.plane(0)[800..]);
        let veiled = Plane { association: crate::Association::Premultiplied, ..ramp(Some(128)) };
        assert!(veiled.flattened(5.0).is_ok());
    }

    #[test]
    fn tones_are_applied_to_colours_in_every_depth() {
        let domain = Domain::open([1, 3]);
        let grid = Grid::from_vec(domain, 2, vec![10_u8, 100, 250, 255, 128, 0]).unwrap();
        let straight = Plane::with_alpha(Role::Color, Samples::U8(grid));
        let Samples::U8(toned) = straight.toned(&[[2.0, -0.1]]).samples else { unreachable!() };
        // 25.5 levels less; 250 ends at white. Alpha stays.
        assert_eq!((toned.plane(0), toned.plane(1)), (&[0, 175, 255][..], &[255, 128, 0][..]));
        let grid = Grid::from_vec(domain, 1, vec![0.5_f32, -1.0, 9.0]).unwrap();
        let Samples::F32(toned) = Plane::new(Role::Color, Samples::F32(grid)).toned(&[[2.0, 0.5]]).samples else {
            unreachable!()
        };
        assert_eq!(toned.plane(0), [1.5, -1.5, 18.5]);
        let normals = Plane::new(Role::Normal, Samples::U8(Grid::try_filled(domain, 3, 9).unwrap()));
        assert_eq!(normals.toned(&[[2.0, 0.0]; 3]), normals);
    }
}
