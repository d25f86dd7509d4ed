//! Samples as numbers that may be averaged, and back.

use half::f16;
use selvedge_core::{NormalCoding, Plane, Role, Samples};

/// How samples of a plane are averaged: as they are stored, but colours weighed by their alpha, and normals with three
/// components made as long as one again.
pub(super) struct Mixing {
    /// The channel that is alpha.
    alpha: Option<usize>,
    normals: Option<NormalCoding>,
    /// Least and greatest stored value of each channel: what averages of bands may not leave, or they would ring.
    ranges: Vec<[f64; 2]>,
}

impl Mixing {
    pub(super) fn new<const D: usize>(planes: &[&Plane<D>]) -> Self {
        let Some(first) = planes.first() else { return Self { alpha: None, normals: None, ranges: Vec::new() } };
        let is_normal = first.role == Role::Normal;
        let range = |c: usize| if is_normal { [f64::NEG_INFINITY, f64::INFINITY] } else { range(planes, c) };
        Self {
            alpha: first.alpha.then(|| first.color_channels()),
            normals: (is_normal && 3 <= first.color_channels()).then(|| NormalCoding::of(planes)),
            ranges: (0..first.samples.channels()).map(range).collect(),
        }
    }

    /// All samples of a plane; planar.
    pub(super) fn numbers<const D: usize>(&self, plane: &Plane<D>) -> Vec<Vec<f64>> {
        let n = plane.domain().len();
        let all = |c: usize| (0..n).map(|i| plane.samples.value(c, i)).collect::<Vec<f64>>();
        let mut channels: Vec<Vec<f64>> = (0..plane.samples.channels()).map(all).collect();
        if let Some(alpha) = self.alpha {
            let (colors, alphas) = channels.split_at_mut(alpha);
            for color in colors {
                color.iter_mut().zip(&alphas[0]).for_each(|(v, a)| *v *= a);
            }
        }
        channels
    }

    /// Sets a sample to an average of [`numbers`](Self::numbers); one that comes out transparent stays what it is.
    pub(super) fn set<const D: usize>(&self, samples: &mut Samples<D>, index: usize, values: &mut [f64]) {
        if let Some(alpha) = self.alpha {
            let weight = values[alpha];
            if weight < self.ranges[alpha][1] * 1e-3 || weight <= 0.0 {
                return;
            }
            values[..alpha].iter_mut().for_each(|v| *v /= weight);
        }
        if let (Some(normals), [x, y, z, ..]) = (self.normals, &mut *values) {
            [*x, *y, *z] = normals.unit_length([*x, *y, *z]);
        }
        for (c, (value, [low, high])) in values.iter().zip(&self.ranges).enumerate() {
            store(samples, c, index, value.clamp(*low, *high));
        }
    }
}

fn range<const D: usize>(planes: &[&Plane<D>], channel: usize) -> [f64; 2] {
    let all = planes.iter().flat_map(|p| (0..p.domain().len()).map(move |i| p.samples.value(channel, i)));
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// Sets a sample from a number: integers are rounded and held in their range.
fn store<const D: usize>(samples: &mut Samples<D>, channel: usize, index: usize, value: f64) {
    match samples {
        Samples::U8(g) => g.plane_mut(channel)[index] = (value + 0.5) as u8,
        Samples::U16(g) => g.plane_mut(channel)[index] = (value + 0.5) as u16,
        Samples::F16(g) => g.plane_mut(channel)[index] = f16::from_f32(value as f32).to_bits(),
        Samples::F32(g) => g.plane_mut(channel)[index] = value as f32,
    }
}
