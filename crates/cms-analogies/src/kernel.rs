//! How a picture of low resolution was made of a large one.

/// What a sample of low resolution is the mean of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// A square of the ratio's side.
    #[default]
    Box,
    /// A Gaussian whose standard deviation is half the ratio, cut at three of them: a blur.
    Gauss,
    /// Lanczos of three lobes, as programs for pictures enlarge and reduce.
    Lanczos,
}

/// A weight of 1.
const ONE: f64 = 65_536.0;

impl Kernel {
    /// The weight of what lies so many samples from the middle, where the ratio is 1.
    fn at(self, distance: f64) -> f64 {
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { libm::sin(x) / x };
        let turn = std::f64::consts::PI * distance;
        match self {
            Self::Box => {
                // Half of an outermost sample.
                let beyond = distance.abs() - 0.5;
                if beyond < -1e-9 {
                    1.0
                } else if beyond < 1e-9 {
                    0.5
                } else {
                    0.0
                }
            }
            Self::Gauss if distance.abs() <= self.reach() => libm::exp(-2.0 * distance * distance),
            Self::Lanczos if distance.abs() < self.reach() => sinc(turn) * sinc(turn / 3.0),
            Self::Gauss | Self::Lanczos => 0.0,
        }
    }

    /// How far it reaches, in samples of low resolution.
    fn reach(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Gauss => 1.5,
            Self::Lanczos => 3.0,
        }
    }

    /// Weights at distances 0, 1, ... from a sample, in whole numbers.
    pub(crate) fn weights(self, ratio: u32) -> Vec<i64> {
        let last = (self.reach() * f64::from(ratio)).floor() as u32;
        (0..=last).map(|d| (ONE * self.at(f64::from(d) / f64::from(ratio))).round() as i64).collect()
    }

    /// What a sample of low resolution sees along an axis: by how far from its first sample, and its share.
    pub(crate) fn shares(self, ratio: u32) -> Vec<(i64, f64)> {
        let middle = f64::from(ratio - 1) / 2.0;
        let reach = (self.reach() * f64::from(ratio)).ceil() as i64;
        let weight = |by: i64| self.at((by as f64 - middle) / f64::from(ratio));
        // A sine is not 0 where it should be.
        let all = (-reach..i64::from(ratio) + reach).map(|by| (by, weight(by))).filter(|(_, w)| 1e-9 < w.abs());
        let all: Vec<(i64, f64)> = all.collect();
        let sum: f64 = all.iter().map(|(_, w)| w).sum();
        all.into_iter().map(|(by, w)| (by, w / sum)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_a_square_and_the_others_reach_farther() {
        assert_eq!(Kernel::Box.weights(3), [65_536, 65_536]);
        assert_eq!(Kernel::Box.weights(4), [65_536, 65_536, 32_768]);
        assert_eq!(Kernel::Box.weights(1), [65_536]);
        let quarters: Vec<(i64, f64)> = (0..4).map(|by| (by, 0.25)).collect();
        assert_eq!(Kernel::Box.shares(4), quarters);
        for kernel in [Kernel::Gauss, Kernel::Lanczos] {
            for ratio in [1, 2, 5, 8] {
                let (weights, shares) = (kernel.weights(ratio), kernel.shares(ratio));
                assert!(ratio as usize <= weights.len() && weights[0] == 65_536, "{kernel:?} {weights:?}");
                assert!((shares.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
                let middle: f64 = shares.iter().map(|(by, w)| *by as f64 * w).sum();
                assert!((middle - f64::from(ratio - 1) / 2.0).abs() < 1e-9, "{kernel:?} {ratio}: {middle}");
            }
        }
        // As far as weights go, and no farther: 1.5 ratios from the middle.
        let reach = |ratio: u32| Kernel::Gauss.shares(ratio).iter().map(|(by, _)| *by).min();
        assert_eq!([reach(4), reach(5)], [Some(-4), Some(-5)]);
        assert!(Kernel::Lanczos.weights(4)[5..7].iter().all(|&w| w < 0), "lobes");
        assert_eq!(Kernel::Lanczos.shares(1), [(0, 1.0)]);
    }
}
