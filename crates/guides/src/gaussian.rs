//! Gaussian smoothing in f64, in a fixed order: the same on every machine.

use selvedge_core::{Domain, par, try_vec};

use crate::Error;

/// The widest blur: beyond, a map of the largest exemplars is flat, and the weights only take time.
const WIDEST: f64 = 1000.0;

/// One half of a normalised kernel.
pub(crate) struct Gaussian {
    /// Weights at distances 0, 1, ...
    weights: Vec<f64>,
}

impl Gaussian {
    /// A standard deviation in samples, cut at three of them; 0 is the identity.
    pub(crate) fn new(sigma: f64) -> Result<Self, Error> {
        if !(0.0..=WIDEST).contains(&sigma) {
            return Err(Error::Blur { sigma, limit: WIDEST });
        }
        let weight = |d: f64| if d == 0.0 { 1.0 } else { libm::exp(-d * d / (2.0 * sigma * sigma)) };
        let weights: Vec<f64> = (0..=(3.0 * sigma).ceil() as u32).map(|d| weight(f64::from(d))).collect();
        let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        Ok(Self { weights: weights.iter().map(|w| w / sum).collect() })
    }

    /// Smooths row-major values along both axes; periodic axes wrap, others repeat their border.
    pub(crate) fn smooth(&self, domain: Domain<2>, values: &[f64]) -> Result<Vec<f64>, Error> {
        let [height, width] = domain.shape.map(|s| s as usize);
        let mut across = try_vec(values.len(), 0.0)?;
        if across.is_empty() {
            return Ok(across);
        }
        par::for_rows(&mut across, width, |y, to| {
            let row = &values[y * width..(y + 1) * width];
            self.sum(to, |to, d, w| {
                for (x, to) in to.iter_mut().enumerate() {
                    *to += w * row[neighbor(x, d, width, domain.periodic[1])];
                }
            });
        });
        let mut along = try_vec(values.len(), 0.0)?;
        par::for_rows(&mut along, width, |y, to| {
            self.sum(to, |to, d, w| {
                let from = neighbor(y, d, height, domain.periodic[0]) * width;
                to.iter_mut().zip(&across[from..from + width]).for_each(|(to, v)| *to += w * v);
            });
        });
        Ok(along)
    }

    /// Adds every distance with its weight.
    fn sum(&self, to: &mut [f64], add: impl Fn(&mut [f64], isize, f64)) {
        for (d, &w) in self.weights.iter().enumerate() {
            add(to, d as isize, w);
            if 0 < d {
                add(to, -(d as isize), w);
            }
        }
    }
}

/// The place `by` away from `at` on an axis of `len`: wrapped, or at most the border.
pub(crate) fn neighbor(at: usize, by: isize, len: usize, periodic: bool) -> usize {
    let (to, len) = (at as isize + by, len as isize);
    (if periodic { to.rem_euclid(len) } else { to.clamp(0, len - 1) }) as usize
}
