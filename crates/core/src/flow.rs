//! Motion from one frame to the next.

use crate::{Domain, Grid};

/// How far each sample moves between two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Two channels, in samples: down, and across.
    pub by: Grid<f32, 2>,
    /// Where that is known; `None` for everywhere.
    pub known: Option<Grid<bool, 2>>,
}

impl Flow {
    /// Shape and topology.
    pub fn domain(&self) -> Domain<2> {
        self.by.domain()
    }

    /// Whether the motion of a sample is known.
    pub fn is_known(&self, at: [u32; 2]) -> bool {
        self.known.as_ref().is_none_or(|known| known.get(0, at))
    }

    /// Where the motion is said to be known and is no number.
    pub fn odd(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let is_odd = |at: &[u32; 2]| self.is_known(*at) && (0..2).any(|c| !self.by.get(c, *at).is_finite());
        self.domain().positions().filter(is_odd)
    }
}
