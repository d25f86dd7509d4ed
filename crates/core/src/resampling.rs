//! Where samples of sources come from that are mirrored, turned by any angle and scaled.

use crate::Domain;

/// A mirror, a turn about the centre and a magnification, over the last two axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resampling {
    /// Cosine and sine of the clockwise angle.
    pub(crate) cos: f64,
    pub(crate) sin: f64,
    pub(crate) scale: f64,
    pub(crate) mirror: bool,
}

/// Where a sample comes from: a place between exemplar samples, on the last two axes.
pub(crate) struct Taps {
    first: [i64; 2],
    weights: [[f64; 4]; 2],
}

impl Resampling {
    pub(crate) fn new(degrees: f64, scale: f64, mirror: bool) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Self { cos, sin, scale, mirror }
    }

    /// The box around the turned and scaled exemplar. Only axes that stay as they are keep their period.
    pub(crate) fn domain<const D: usize>(&self, mut exemplar: Domain<D>) -> Domain<D> {
        let [h, w] = [D - 2, D - 1].map(|a| f64::from(exemplar.shape[a]) * self.scale);
        let (cos, sin) = (self.cos.abs(), self.sin.abs());
        // The rounding errors of sines must not add a sample.
        let side = |v: f64| ((v - 1e-6).ceil() as u32).max(1);
        (exemplar.shape[D - 2], exemplar.shape[D - 1]) = (side(h * cos + w * sin), side(w * cos + h * sin));
        (exemplar.periodic[D - 2], exemplar.periodic[D - 1]) = (false, false);
        exemplar
    }

    /// The exemplar's place under a place of the source, both in samples with the first at 0.
    fn place(&self, exemplar: [u32; 2], source: [u32; 2], at: [f64; 2]) -> [f64; 2] {
        let centre = |shape: [u32; 2]| shape.map(|n| (f64::from(n) - 1.0) / 2.0);
        let (to, from) = (centre(exemplar), centre(source));
        let [y, x] = self.undo([at[0] - from[0], at[1] - from[1]]);
        [to[0] + y, to[1] + x]
    }

    /// Where a place of the source lies in the exemplar, both from their centres.
    pub(crate) fn undo(&self, at: [f64; 2]) -> [f64; 2] {
        let (y, x) = (at[0] / self.scale, at[1] / self.scale);
        // Undoing a clockwise turn of a picture whose y axis points down.
        let across = x * self.cos + y * self.sin;
        [y * self.cos - x * self.sin, if self.mirror { -across } else { across }]
    }

    /// Places averaged to one sample along an axis: more where the exemplar shrinks.
    pub(crate) fn spots(&self) -> u32 {
        ((1.0 / self.scale).ceil() as u32).clamp(1, 16)
    }

    /// Calls `f` with the taps of each spot of a sample.
    pub(crate) fn each_spot(&self, exemplar: [u32; 2], source: [u32; 2], at: [u32; 2], mut f: impl FnMut(&Taps)) {
        let n = self.spots();
        let inside = |spot: u32| (f64::from(spot) + 0.5) / f64::from(n) - 0.5;
        for spot in 0..n * n {
            let at = [f64::from(at[0]) + inside(spot / n), f64::from(at[1]) + inside(spot % n)];
            f(&Taps::at(self.place(exemplar, source, at)));
        }
    }
}

impl Taps {
    /// Catmull and Rom's cubic through four samples an axis.
    fn at(place: [f64; 2]) -> Self {
        let mut taps = Self { first: [0; 2], weights: [[0.0; 4]; 2] };
        for (axis, p) in place.into_iter().enumerate() {
            let floor = p.floor();
            let t = p - floor;
            taps.first[axis] = floor as i64 - 1;
            taps.weights[axis] = [
                0.5 * t * (t * (2.0 - t) - 1.0),
                0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
                0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
                0.5 * t * t * (t - 1.0),
            ];
        }
        taps
    }

    /// The place along an axis of a tap, moved inside.
    fn along(&self, axis: usize, tap: usize, side: u32) -> usize {
        (self.first[axis] + tap as i64).clamp(0, i64::from(side) - 1) as usize
    }

    /// The value between the samples; never beyond the four around it, so that edges do not ring.
    pub(crate) fn value(&self, shape: [u32; 2], sample: impl Fn(usize) -> f64) -> f64 {
        let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
        for ty in 0..4 {
            for tx in 0..4 {
                let v = sample(self.along(0, ty, shape[0]) * shape[1] as usize + self.along(1, tx, shape[1]));
                sum += v * self.weights[0][ty] * self.weights[1][tx];
                if (1..3).contains(&ty) && (1..3).contains(&tx) {
                    (low, high) = (low.min(v), high.max(v));
                }
            }
        }
        sum.clamp(low, high)
    }

    /// True if the samples around the place exist and are valid; outside of it, only weights that are not 0 count.
    pub(crate) fn is_valid(&self, shape: [u32; 2], valid: impl Fn(usize) -> bool) -> bool {
        (1..3).all(|ty| {
            (1..3).all(|tx| {
                let needed = self.weights[0][ty].abs() * self.weights[1][tx].abs() > 1e-9;
                let at = [self.first[0] + ty as i64, self.first[1] + tx as i64];
                let inside = (0..2).all(|a| 0 <= at[a] && at[a] < i64::from(shape[a]));
                !needed || inside && valid(at[0] as usize * shape[1] as usize + at[1] as usize)
            })
        })
    }
}
