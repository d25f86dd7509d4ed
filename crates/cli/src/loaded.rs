//! Exemplars that were read.

use std::path::{Path, PathBuf};

use selvedge_core::{Encoder, Exemplars, Grid, Guide, Plane};
use selvedge_io::{Fingerprint, Metadata};

use crate::failure::Failure;

/// Exemplars as methods see them, and what is rendered from them.
pub(crate) struct ExemplarSet {
    pub(crate) exemplars: Exemplars<2>,
    /// What made their features: other pictures that are compared with them go through it.
    pub(crate) encoder: Encoder,
    pub(crate) paths: Vec<PathBuf>,
    /// Samples in the depth and the channels of the output.
    pub(crate) payload: Vec<Plane<2>>,
    /// Of the exemplars.
    pub(crate) fingerprints: Vec<Fingerprint>,
    /// Where each may be used, as its mask says.
    pub(crate) masks: Vec<Option<Grid<bool, 2>>>,
    /// Of the masks, and of planes that decided with the exemplars.
    pub(crate) other_fingerprints: Vec<Fingerprint>,
    /// How many were given as exemplars; a backdrop comes after them.
    pub(crate) given: usize,
    /// What the first exemplar says besides its samples.
    pub(crate) metadata: Metadata,
}

impl ExemplarSet {
    /// True if what a guide shows has holes where exemplars have none: no header tells.
    pub(crate) fn has_fewer_holes(&self, guide: &Guide<2>) -> bool {
        guide.exemplars().is_masked() && !self.exemplars.is_masked()
    }

    /// Names of what was given as exemplars.
    pub(crate) fn given(&self) -> &[PathBuf] {
        &self.paths[..self.given]
    }

    /// An error about the exemplars, with the name of the file if there is just one.
    pub(crate) fn about(&self, failure: Failure) -> Failure {
        match self.given() {
            [only] => failure.about(only),
            _ => failure,
        }
    }

    /// The first exemplar of this shape.
    pub(crate) fn of_shape(&self, shape: &[u32]) -> Option<&Path> {
        let found = self.payload.iter().position(|plane| plane.domain().shape == shape)?;
        self.paths.get(found).map(PathBuf::as_path)
    }

    /// All that was read, by name and content.
    pub(crate) fn all_fingerprints(&self) -> Vec<Fingerprint> {
        self.fingerprints.iter().chain(&self.other_fingerprints).cloned().collect()
    }
}
