//! Multi-resolution splining: coarse detail is blended widely, fine detail closely. `[Kwatra03 5]`
//!
//! Burt and Adelson's scheme (1983) with their kernel, but without dropping samples between levels: so it works on any
//! size, wraps where the output does, and needs only the neighborhood of a position.

use selvedge_core::{Bytes, Domain, Error, Grid, Plane, Render, SourceMap};

use crate::bands::{Bands, reach};
use crate::boxes::{Blend, Part, bytes, render};
use crate::map_view::MapView;
use crate::region::{Shown, grown, rows};

/// A source map whose seams are splined: each band of detail is blended over a width of its own.
///
/// Positions that no seam is near are copied bit for bit. Where a patch is not defined, the output itself stands in for
/// it. Values are averaged as they are stored, colours weighed by their alpha, and never leave the exemplars' range;
/// normals keep their length.
#[derive(Clone, Debug)]
pub struct Splined<'m, const D: usize> {
    laid: MapView<'m, D>,
    levels: u32,
}

impl<'m, const D: usize> Splined<'m, D> {
    /// The greatest number of bands: the coarsest is blended over 62 samples on each side then, more than patches
    /// mostly are wide.
    pub const MOST: u32 = 5;

    /// Splines seams over `levels` bands, from 0 (no splining) to 5; the coarsest is blended over about `2^levels`
    /// samples. Patches count where their source is `valid`, as for [`Feathered`](crate::Feathered).
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate), [`selvedge_core::Error::UnknownSample`] if the map names one,
    /// [`crate::Error::Shape`] for validity of other shapes than the sources.
    pub fn new(
        map: &'m SourceMap<D>,
        valid: Vec<Option<&'m Grid<bool, D>>>,
        levels: u32,
    ) -> Result<Self, crate::Error> {
        Self::validate(levels)?;
        Ok(Self { laid: MapView::new(map, valid)?, levels })
    }

    /// Bands that carry a difference of shade across a map's patches: the coarsest is blended over no more than half of
    /// what lies between seams, or a patch would keep nothing of its own. From 1 to [`MOST`](Self::MOST).
    ///
    /// Time `O(positions)`.
    pub fn levels_for(map: &SourceMap<D>) -> u32 {
        let (domain, last) = (map.domain(), D - 1);
        let seams = domain.positions().filter(|&at| map.is_seam(at, last)).count();
        let lines = domain.len() / (domain.shape[last] as usize).max(1);
        // Samples from seam to seam along the last axis, as many lines of it have none at their ends.
        let between = domain.len() / (seams + if domain.periodic[last] { 0 } else { lines }).max(1);
        (1..Self::MOST).take_while(|&levels| 2 << (levels + 1) <= between).count() as u32 + 1
    }

    /// Checks a number of bands.
    ///
    /// # Errors
    /// [`Range`](Error::Range) if there are more than [`MOST`](Self::MOST).
    pub fn validate(levels: u32) -> Result<(), crate::Error> {
        let wrong = || Error::range("spline", f64::from(levels), "0 to 5");
        if levels <= Self::MOST { Ok(()) } else { Err(wrong().into()) }
    }

    /// The same, but positions where `kept` is true are copied, whatever is near.
    ///
    /// # Errors
    /// [`crate::Error::Shape`] if it has another shape than the map.
    pub fn keeping(self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        Ok(Self { laid: self.laid.keeping(kept)?, ..self })
    }

    /// An upper bound of what rendering takes besides the planes and the output, for planes of so many channels.
    pub fn bytes(output: Domain<D>, channels: usize, levels: u32) -> Bytes {
        // Where nothing is in reach nothing is blended.
        if levels == 0 {
            Bytes(0)
        } else {
            bytes(output, channels, reach(levels.min(Self::MOST)), 28 + 24 * channels as u64)
        }
    }

    fn blend(&self, part: &Part<'_, D>) -> Blend {
        let mut sums = vec![vec![0.0; part.wanted.len()]; part.channels()];
        let (mut own, mut bands) = (Vec::new(), Bands::new(part.channels()));
        for Shown { patch, around } in part.shown() {
            // Where any of its bands is mixed in, and what that depends on.
            let Some(target) = grown(&around, reach(self.levels), &part.wanted) else { continue };
            let Some(region) = grown(&target, reach(self.levels), &part.window) else { continue };
            part.of_patch(&patch, &region, &mut own, &mut bands.mask);
            for (own, row) in own.chunks_exact_mut(region.shape[D - 1] as usize).zip(rows(&part.window, &region)) {
                // Where it is not defined, the output stands in for it.
                own.iter_mut().zip(&part.ids[row]).filter(|(own, _)| !own.is_assigned()).for_each(|(o, s)| *o = *s);
            }
            part.numbers(&own, &mut bands.values);
            bands.add([&region, &target, &part.wanted], self.levels, &mut sums);
        }
        Blend { channels: sums, is_blended: Vec::new() }
    }
}

impl<const D: usize> Render<D> for Splined<'_, D> {
    /// # Complexity
    /// Time `O(positions near seams * levels)` for each patch within `2^(levels + 2)` samples.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        render(&self.laid, planes, reach(self.levels), |part| self.blend(part))
    }
}
