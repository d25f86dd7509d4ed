//! One source as the engines see it.

use crate::axes::{Shape, lift};
use selvedge_core::Grid;

/// Features and validity of one source, borrowed, over three axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SourceView<'e> {
    pub(crate) shape: Shape,
    pub(crate) periodic: [bool; 3],
    /// Planar.
    pub(crate) features: &'e [u8],
    /// `None` if every sample is valid.
    pub(crate) valid: Option<&'e [bool]>,
}

impl<'e> SourceView<'e> {
    pub(crate) fn new<const D: usize>(features: &'e Grid<u8, D>, valid: Option<&'e Grid<bool, D>>) -> Self {
        let domain = features.domain();
        Self {
            shape: lift(domain.shape.map(|n| n as usize), 1),
            periodic: lift(domain.periodic, false),
            features: features.samples(),
            valid: valid.map(Grid::samples).filter(|v| v.contains(&false)),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    #[inline]
    pub(crate) fn is_valid(&self, index: usize) -> bool {
        self.valid.is_none_or(|v| v[index])
    }

    #[inline]
    pub(crate) fn plane(&self, channel: usize) -> &'e [u8] {
        &self.features[channel * self.len()..(channel + 1) * self.len()]
    }
}
