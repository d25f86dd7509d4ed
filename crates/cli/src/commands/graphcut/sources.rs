//! The sources of `graphcut`: orientations, scales, and which of them each place may copy from.

use std::sync::Arc;

use selvedge_core::{Grid, Source, Transform};

use super::Graphcut;
use super::scales::Scales;
use crate::failure::Failure;
use crate::inputs::Input;
use crate::loom::Loom;

/// One way to turn exemplars: clockwise degrees, and whether they are mirrored before.
type Orientation = (f64, bool);

impl Graphcut {
    /// The orientations asked for, each once, as they are first.
    pub(super) fn orientations(&self) -> Vec<Orientation> {
        let mut all: Vec<Orientation> = Vec::new();
        for degrees in std::iter::once(0.0).chain(self.rotate.iter().copied()) {
            for turn in if self.turn { 0..4 } else { 0..1 } {
                for mirror in if self.mirror { vec![false, true] } else { vec![false] } {
                    let orientation = ((degrees + 90.0 * f64::from(turn)).rem_euclid(360.0), mirror);
                    if !all.contains(&orientation) {
                        all.push(orientation);
                    }
                }
            }
        }
        all
    }

    /// Every orientation at every scale, scale by scale.
    pub(super) fn transforms(&self, scales: &[f64]) -> Vec<Transform> {
        let mut all: Vec<Transform> = Vec::new();
        for scale in scales {
            let turned =
                self.orientations().into_iter().map(|(degrees, mirror)| Transform::new(degrees, *scale, mirror));
            let fresh: Vec<Transform> = turned.filter(|transform| !all.contains(transform)).collect();
            all.extend(fresh);
        }
        all
    }

    /// By position, which sources may be copied from.
    pub(super) fn sources(&self, loom: &mut Loom<'_>, field: &Scales) -> Result<Grid<u64, 2>, Failure> {
        let picture = field.file().map(|path| loom.read(&Input::new(loom.session, path)?)).transpose()?;
        let mut allowed = field.allowed(loom.domain, picture.as_ref())?;
        let of_levels: Vec<u64> = field.levels().into_iter().map(|scale| self.of_scale(loom, scale)).collect();
        for bits in allowed.plane_mut(0) {
            let set = (0..of_levels.len()).filter(|level| *bits >> level & 1 == 1);
            *bits = set.fold(0, |sources, level| sources | of_levels[level]);
        }
        Ok(allowed)
    }

    /// Exemplars that no region fits into are laid where nothing larger may be.
    pub(super) fn warn_of_small(&self, loom: &Loom<'_>, [height, width]: [u32; 2]) {
        let sources = loom.loaded.exemplars.sources();
        for (number, path) in loom.loaded.given().iter().enumerate() {
            let mut own = sources.iter().filter(|s| usize::from(s.origin.exemplar) == number).map(|s| s.domain().shape);
            if own.all(|[h, w]| h < height || w < width) {
                let what = format!(
                    "smaller than the regions of {width}x{height} px; use a smaller --region to see more of it"
                );
                loom.session.warn(path, &what);
            }
        }
    }

    /// The sources of a scale, but for the picture that is gone on from. What is the same at several scales is one
    /// source.
    fn of_scale(&self, loom: &Loom<'_>, scale: f64) -> u64 {
        let (given, turned) = (loom.loaded.given().len(), self.transforms(&[scale]));
        let sources = loom.loaded.exemplars.sources().iter().enumerate();
        let here = |(number, s): (usize, &Arc<Source<2>>)| {
            let laid = usize::from(s.origin.exemplar) < given && turned.contains(&s.origin.transform);
            if laid { 1 << number } else { 0_u64 }
        };
        sources.map(here).fold(0, |all, bit| all | bit)
    }
}
