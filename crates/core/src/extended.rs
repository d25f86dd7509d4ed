//! Exemplars with further channels of their samples.

use std::sync::Arc;

use crate::{Error, Exemplars, Grid, Source, try_vec, weights};

impl<const D: usize> Exemplars<D> {
    /// The same sources with further channels after their own, one grid a source: where all of the own channels count 1
    /// together, all of these count `weight`, shared out by `weights`; in whole numbers, as [`Guide::join`] has them.
    ///
    /// # Errors
    /// Those of [`with_features`](Self::with_features), [`Error::GuideWeight`], [`Error::GuideProportion`].
    ///
    /// [`Guide::join`]: crate::Guide::join
    pub fn extended(&self, more: Vec<Grid<u8, D>>, weights: &[u8], weight: f64) -> Result<Self, Error> {
        let (expected, found) = (self.sources().len(), more.len());
        if expected != found {
            return Err(Error::GuideCount { expected, found });
        }
        let weights = weights::of_parts(&[(1.0, self.weights()), (weight, weights)])?;
        let both = |(source, more): (&Arc<Source<D>>, &Grid<u8, D>)| {
            let [own, more] = [&source.features, more].map(Grid::samples);
            let mut samples = try_vec(own.len() + more.len(), 0)?;
            samples[..own.len()].copy_from_slice(own);
            samples[own.len()..].copy_from_slice(more);
            Grid::from_vec(source.domain(), weights.len(), samples)
        };
        let all = self.sources().iter().zip(&more).map(both).collect::<Result<_, _>>()?;
        self.with_features(all, weights)
    }
}
