//! How much each sample of a neighborhood counts. `[Kwatra05 3.1]`

/// The Gaussian's deviation as a part of the neighborhood's size. The paper gives none. At a fourth a corner weighs a
/// fiftieth of the middle, so that where a neighborhood ends nobody sees; narrower ones would leave few votes a sample.
const DEVIATION: f64 = 0.25;

/// The weight of samples along one axis, by their distance from the first; that of a sample is the product over both
/// axes.
#[derive(Clone, Debug)]
pub(crate) struct Falloff(Vec<f64>);

impl Falloff {
    pub(crate) fn new(size: u32) -> Self {
        let (middle, deviation) = (f64::from(size - 1) / 2.0, DEVIATION * f64::from(size));
        let weight = |i: u32| {
            let by = (f64::from(i) - middle) / deviation;
            libm::exp(-by * by / 2.0)
        };
        Self((0..size).map(weight).collect())
    }

    /// All samples alike.
    pub(crate) fn flat(size: u32) -> Self {
        Self(vec![1.0; size as usize])
    }

    pub(crate) fn along(&self) -> &[f64] {
        &self.0
    }

    /// The weights between a sample and the next one: means of theirs, and 0 after the last, since what leaves the
    /// neighborhood is none of its differences.
    pub(crate) fn between(&self) -> Vec<f64> {
        self.0.windows(2).map(|two| (two[0] + two[1]) / 2.0).chain([0.0]).collect()
    }

    /// The sum over a neighborhood.
    pub(crate) fn sum(&self) -> f64 {
        let along: f64 = self.0.iter().sum();
        along * along
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_alike_to_both_sides() {
        for size in [1, 4, 7, 32] {
            let falloff = Falloff::new(size);
            let along = falloff.along();
            let mirrored: Vec<f64> = along.iter().rev().copied().collect();
            assert_eq!(along, mirrored);
            assert!(along[..along.len().div_ceil(2)].is_sorted_by(|a, b| a < b), "{along:?}");
            assert_eq!(Falloff::flat(size).sum(), f64::from(size * size));
        }
    }
}
