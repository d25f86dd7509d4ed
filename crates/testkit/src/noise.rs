//! A small hash and the noises made of it: integer mixing, and `+ - * /` on `f64`, so the same on every machine.

/// A field of random numbers over the plane, drawn once and for all by its seed.
#[derive(Clone, Copy, Debug)]
pub struct Noise(u32);

/// Gradients of [`Noise::smooth`]: eight directions of unit length.
const GRADIENTS: [(f64, f64); 8] = {
    const D: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [(1.0, 0.0), (D, D), (0.0, 1.0), (-D, D), (-1.0, 0.0), (-D, -D), (0.0, -1.0), (D, -D)]
};

impl Noise {
    /// The field named `seed`.
    pub const fn new(seed: u32) -> Self {
        Self(seed)
    }

    /// Another field, independent of this one.
    pub const fn other(self, which: u32) -> Self {
        Self(mix(self.0 ^ which.wrapping_mul(0x9e37_79b9)))
    }

    /// 32 random bits for the cell `(x, y)`.
    pub const fn bits(self, x: i32, y: i32) -> u32 {
        mix(mix(mix(self.0).wrapping_add(x as u32)).wrapping_add(y as u32))
    }

    /// A random number in `[0, 1)` for the cell `(x, y)`.
    pub fn cell(self, x: i32, y: i32) -> f64 {
        f64::from(self.bits(x, y)) / 4_294_967_296.0
    }

    /// A random number in `[-1, 1)` for the cell `(x, y)`.
    pub fn signed(self, x: i32, y: i32) -> f64 {
        2.0 * self.cell(x, y) - 1.0
    }

    /// Gradient noise: smooth, about `[-1, 1]`, one bump per unit square.
    pub fn smooth(self, x: f64, y: f64) -> f64 {
        let (x0, y0) = (x.floor(), y.floor());
        let (dx, dy) = (x - x0, y - y0);
        let corner = |i: i32, j: i32| {
            let (gx, gy) = GRADIENTS[(self.bits(x0 as i32 + i, y0 as i32 + j) >> 29) as usize];
            gx * (dx - f64::from(i)) + gy * (dy - f64::from(j))
        };
        let (sx, sy) = (ease(dx), ease(dy));
        let top = lerp(corner(0, 0), corner(1, 0), sx);
        let bottom = lerp(corner(0, 1), corner(1, 1), sx);
        1.4 * lerp(top, bottom, sy)
    }

    /// `octaves` layers of [`Noise::smooth`], each twice as fine and half as strong; about `[-1, 1]`.
    pub fn layers(self, x: f64, y: f64, octaves: u32) -> f64 {
        let (mut sum, mut scale, mut weight) = (0.0, 1.0, 0.5);
        for octave in 0..octaves {
            sum += weight * self.other(octave).smooth(x * scale, y * scale);
            scale *= 2.0;
            weight *= 0.5;
        }
        1.3 * sum
    }
}

/// Mixes 32 bits so that each bit of the result hangs on each bit of the input.
const fn mix(mut h: u32) -> u32 {
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// The quintic that goes from 0 to 1 with no slope and no bend at either end.
fn ease(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// The point `t` of the way from `a` to `b`.
pub(crate) fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// 0 below `lo`, 1 above `hi`, and a smooth way between.
pub(crate) fn ramp(lo: f64, hi: f64, x: f64) -> f64 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_noise_is_smooth_and_stays_in_its_range() {
        let noise = Noise::new(9);
        let at = |i: i32| noise.smooth(f64::from(i) / 50.0, 0.37);
        let values: Vec<f64> = (0..5000).map(at).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.2));
        assert!(values.windows(2).all(|w| (w[1] - w[0]).abs() < 0.12));
        assert!(values.iter().any(|v| 0.5 < v.abs()), "and is not flat");
    }

    #[test]
    fn fields_of_other_names_are_unlike() {
        let (a, b) = (Noise::new(1), Noise::new(1).other(1));
        let correlation: f64 = (0..10_000).map(|i| a.signed(i, 3) * b.signed(i, 3)).sum::<f64>() / 10_000.0;
        assert!(correlation.abs() < 0.02, "{correlation}");
    }
}
