//! Samples as numbers that may be averaged, and back.

use crate::encoder::Curve;
use crate::{NormalCoding, Plane, Samples};

/// The least part of the greatest alpha at which a colour is told from its product with it. Below, an average comes of
/// samples that hardly show, and dividing by it would turn what is left of rounding into colour.
const LEAST_ALPHA: f64 = 1e-3;

/// How samples of a plane are averaged, in any depth: as they are stored, but colours weighed by their alpha, and
/// normals with three components made as long as one again.
#[derive(Clone, Debug)]
pub struct Averaging {
    /// The channel that is alpha, unless colours were multiplied by it before.
    alpha: Option<usize>,
    normals: Option<NormalCoding>,
    /// Least and greatest value of each channel: what averages may not leave, or bands of detail would ring.
    ranges: Vec<[f64; 2]>,
    /// What light is put on, and in how many channels.
    light: Option<(Curve, usize)>,
}

impl Averaging {
    /// That of registered planes of one layout.
    ///
    /// Time `O(samples)`.
    pub fn of<const D: usize>(planes: &[&Plane<D>]) -> Self {
        let Some(first) = planes.first() else {
            return Self { alpha: None, normals: None, ranges: Vec::new(), light: None };
        };
        let is_normal = first.role.is_normal();
        let range = |c: usize| if is_normal { [f64::NEG_INFINITY, f64::INFINITY] } else { range(planes, c) };
        Self {
            alpha: (first.alpha && !first.is_premultiplied()).then(|| first.color_channels()),
            normals: (is_normal && 3 <= first.color_channels()).then(|| NormalCoding::of(planes)),
            ranges: (0..first.samples.channels()).map(range).collect(),
            light: None,
        }
    }

    /// The same, but colours that are floats are averaged as the [`Encoder`](crate::Encoder) compares them:
    /// sRGB-encoded up to 1, logarithms where there is more. So a step in the dark counts as much as one that is as
    /// visible in the light, and twice the light is a step of one height.
    ///
    /// Time `O(samples)`.
    #[must_use]
    pub fn as_compared<const D: usize>(mut self, planes: &[&Plane<D>]) -> Self {
        if let Some(curve) = Curve::of_light(planes) {
            let colors = planes[0].color_channels();
            self.ranges[..colors].iter_mut().flatten().for_each(|v| *v = curve.on(*v));
            self.light = Some((curve, colors));
        }
        self
    }

    /// Least and greatest of what is averaged, by channel, before alpha weighs it; unbounded for normals.
    pub fn ranges(&self) -> &[[f64; 2]] {
        &self.ranges
    }

    /// Makes stored values, a list a channel, what may be averaged.
    pub fn weigh(&self, channels: &mut [Vec<f64>]) {
        if let Some((curve, colors)) = self.light {
            channels[..colors].iter_mut().flatten().for_each(|v| *v = curve.on(*v));
        }
        let Some(alpha) = self.alpha else { return };
        let (colors, alphas) = channels.split_at_mut(alpha);
        for color in colors {
            color.iter_mut().zip(&alphas[0]).for_each(|(v, a)| *v *= a);
        }
    }

    /// Sets a sample to an average of what was [weighed](Self::weigh); one that comes out transparent stays what it is.
    pub fn set<const D: usize>(&self, samples: &mut Samples<D>, index: usize, values: &mut [f64]) {
        if let Some(alpha) = self.alpha {
            let weight = values[alpha];
            if weight < self.ranges[alpha][1] * LEAST_ALPHA || weight <= 0.0 {
                return;
            }
            values[..alpha].iter_mut().for_each(|v| *v /= weight);
        }
        if let (Some(normals), [x, y, z, ..]) = (self.normals, &mut *values) {
            [*x, *y, *z] = normals.unit_length([*x, *y, *z]);
        }
        for (c, (value, [low, high])) in values.iter().zip(&self.ranges).enumerate() {
            let value = value.clamp(*low, *high);
            let light = self.light.filter(|(_, colors)| c < *colors).map(|(curve, _)| curve.off(value));
            samples.set_value(c, index, light.unwrap_or(value));
        }
    }
}

fn range<const D: usize>(planes: &[&Plane<D>], channel: usize) -> [f64; 2] {
    let all = planes.iter().flat_map(|p| (0..p.domain().len()).map(move |i| p.samples.value(channel, i)));
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Grid, Role};

    fn line(channels: usize, values: &[f32]) -> Samples<1> {
        let domain = Domain::open([(values.len() / channels) as u32]);
        Samples::F32(Grid::from_vec(domain, channels, values.to_vec()).unwrap())
    }

    /// The average of the first two samples, where the last one stands.
    fn average(plane: &Plane<1>) -> Vec<f64> {
        let averaging = Averaging::of(&[plane]);
        let of = |c: usize| [0, 1].map(|i| plane.samples.value(c, i)).to_vec();
        let mut channels: Vec<Vec<f64>> = (0..plane.samples.channels()).map(of).collect();
        averaging.weigh(&mut channels);
        let mut values: Vec<f64> = channels.iter().map(|c| (c[0] + c[1]) / 2.0).collect();
        let mut out = plane.samples.clone();
        averaging.set(&mut out, 2, &mut values);
        (0..plane.samples.channels()).map(|c| out.value(c, 2)).collect()
    }

    #[test]
    fn colours_are_weighed_by_their_alpha() {
        // 8 at three parts of alpha and 4 at one make 7 at two.
        let plane = Plane::with_alpha(Role::Color, line(2, &[8.0, 4.0, 0.0, 0.75, 0.25, 1.0]));
        assert_eq!(average(&plane), [7.0, 0.5]);
        let hidden = Plane::with_alpha(Role::Color, line(2, &[8.0, 4.0, 5.0, 0.0, 0.0, 1.0]));
        assert_eq!(average(&hidden), [5.0, 1.0], "what is transparent has no colour to give");
    }

    #[test]
    fn normals_are_as_long_as_one_and_others_stay_in_range() {
        let across = Plane::new(Role::Normal, line(3, &[-0.6, 0.6, 0.0, 0.0, 0.0, 1.0, 0.8, 0.8, 0.0]));
        assert_eq!(average(&across), [0.0, 0.0, 1.0]);
        let averaging = Averaging::of(&[&Plane::new(Role::Height, line(1, &[2.0, 6.0]))]);
        let mut out = line(1, &[0.0, 0.0]);
        averaging.set(&mut out, 0, &mut [9.0]);
        averaging.set(&mut out, 1, &mut [-9.0]);
        assert_eq!(out, line(1, &[6.0, 2.0]));
    }

    #[test]
    fn light_is_averaged_as_it_is_compared() {
        let averaged = |values: &[f32]| {
            let plane = Plane::new(Role::Color, line(1, values));
            let averaging = Averaging::of(&[&plane]).as_compared(&[&plane]);
            let mut channels = vec![(0..2).map(|i| plane.samples.value(0, i)).collect::<Vec<f64>>()];
            averaging.weigh(&mut channels);
            let mut out = plane.samples.clone();
            averaging.set(&mut out, 2, &mut [(channels[0][0] + channels[0][1]) / 2.0]);
            out.value(0, 2)
        };
        let encoded = averaged(&[0.0, 1.0, 0.0]);
        assert!((crate::srgb_encode(encoded) - 0.5).abs() < 1e-6, "{encoded}");
        // Far above the knee the mean is the geometric one.
        let far = averaged(&[1e4, 1e6, 0.0]);
        assert!((8e4..3e5).contains(&far), "{far}");
        let negative = averaged(&[-4.0, 4.0, 9.0]);
        assert!(negative.abs() < 1e-6, "{negative}");
    }

    #[test]
    fn every_depth_is_rounded_to_what_is_nearest() {
        let one = Domain::open([2]);
        let of = |samples: Samples<1>| {
            let plane = Plane::new(Role::Scalar, samples);
            let mut out = plane.samples.clone();
            Averaging::of(&[&plane]).set(&mut out, 0, &mut [6.625]);
            out.value(0, 0)
        };
        assert_eq!(of(Samples::U8(Grid::from_vec(one, 1, vec![0, 9]).unwrap())), 7.0);
        assert_eq!(of(Samples::U16(Grid::from_vec(one, 1, vec![0, 9]).unwrap())), 7.0);
        assert_eq!(of(Samples::F16(Grid::from_vec(one, 1, vec![0, 0x4880]).unwrap())), 6.625);
        assert_eq!(of(Samples::F32(Grid::from_vec(one, 1, vec![0.0, 9.0]).unwrap())), 6.625);
    }
}
