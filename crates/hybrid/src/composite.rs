//! How a block meets what stands: cut along the path of least error, or with its overlap re-synthesised. `[Ding 3.3]`

use selvedge_core::{Exemplars, Look, SampleId, SeamCosts, Window};
use selvedge_quilting::boundary_cut::{Overlaps, boundary_cut};
use selvedge_quilting::search::Candidate;

use crate::canvas::Canvas;
use crate::error::Error;
use crate::options::Resynthesize;
use crate::pixel::{PixelScratch, Pixels};
use crate::stats::Stats;
use crate::thresholds::Limit;

/// Samples on both sides of a bad seam that are re-synthesised: fewer leave no room for a transition, more redo what
/// was good.
pub(crate) const BESIDE_SEAMS: u32 = 2;

/// A block that was found, and where it goes.
pub(crate) struct Laying {
    pub(crate) core: Window<2>,
    /// The block with its overlaps.
    pub(crate) window: Window<2>,
    /// Overlap on the low side of each axis.
    pub(crate) before: [u32; 2],
    /// Overlap on the high side of each axis.
    pub(crate) after: [u32; 2],
    /// Where the window begins in the exemplars.
    pub(crate) chosen: Candidate,
    /// How often it was split.
    pub(crate) level: usize,
    /// By sample of the window.
    pub(crate) errors: Vec<u64>,
}

impl Laying {
    /// The same block so much further.
    pub(crate) fn moved(self, by: [i32; 2]) -> Self {
        Self { core: self.core.moved(by), window: self.window.moved(by), ..self }
    }
}

/// Lays blocks.
pub(crate) struct Compositor<'a> {
    pub(crate) exemplars: &'a Exemplars<2>,
    pub(crate) pixels: Pixels<'a>,
    pub(crate) costs: SeamCosts<2>,
    pub(crate) resynthesize: Resynthesize,
    /// An overlap of this mean error or more is re-synthesised; never without one.
    pub(crate) recut: Option<Limit>,
    /// A sample of a larger error is re-synthesised.
    pub(crate) pixel: Limit,
}

impl Compositor<'_> {
    /// Lays a block over `under`, what was known of its window.
    pub(crate) fn lay(
        &self,
        laying: &Laying,
        under: &Look,
        canvas: &mut Canvas,
        (stats, scratch): (&mut Stats, &mut PixelScratch),
    ) -> Result<(), Error> {
        let (error, samples) = (laying.errors.iter().sum::<u64>(), under.samples() as u64);
        // "Smaller than k times the largest error": what is just as large is re-synthesised.
        let cut = self.recut.is_none_or(|limit| samples == 0 || error == 0 || !limit.is_passed(error + 1, samples));
        stats.cuts += u64::from(cut && 0 < samples);
        stats.resyntheses += u64::from(!cut);
        let mut shown = match (cut, self.resynthesize) {
            (true, _) | (false, Resynthesize::Seam) => self.cut(laying, under)?,
            (false, Resynthesize::Overlap) => vec![true; laying.errors.len()],
        };
        let places = self.paste(laying, under, canvas, &mut shown);
        if cut {
            return Ok(());
        }
        let bad = match self.resynthesize {
            Resynthesize::Overlap => places
                .iter()
                .enumerate()
                .filter_map(|(i, &place)| {
                    let place = place.filter(|_| shown[i] && under.known()[i])?;
                    self.pixel.is_passed(laying.errors[i], 1).then_some(place)
                })
                .collect(),
            Resynthesize::Seam => self.along_seams(laying, canvas, &shown),
        };
        let bad: Vec<usize> = bad.into_iter().filter(|&place: &usize| !canvas.is_fixed(place)).collect();
        bad.iter().for_each(|&place| canvas.wait(place));
        stats.pixels += self.pixels.resynthesize(canvas, &bad, scratch)?;
        Ok(())
    }

    /// Lays a block cut, whatever its error.
    pub(crate) fn lay_cut(&self, laying: &Laying, under: &Look, canvas: &mut Canvas) -> Result<(), Error> {
        let mut shown = self.cut(laying, under)?;
        self.paste(laying, under, canvas, &mut shown);
        Ok(())
    }

    fn cut(&self, laying: &Laying, under: &Look) -> Result<Vec<bool>, Error> {
        let side = |n: u32| n as usize;
        let overlaps = Overlaps {
            left: side(laying.before[1]),
            top: side(laying.before[0]),
            right: side(laying.after[1]),
            bottom: side(laying.after[0]),
        };
        Ok(boundary_cut(laying.window.shape.map(side), overlaps, &laying.errors, Some(under.known()))?.new)
    }

    /// Writes what is shown of a block, and takes back what of it may not be: fixed samples, and what stood in the
    /// block itself. Answers the window's places.
    fn paste(&self, laying: &Laying, under: &Look, canvas: &mut Canvas, shown: &mut [bool]) -> Vec<Option<usize>> {
        let (Laying { core, window, chosen, .. }, output) = (laying, canvas.domain());
        let places: Vec<Option<usize>> = window.places(output).collect();
        let source = &self.exemplars.sources()[chosen.source];
        let first = self.exemplars.table().first(chosen.source);
        let from = Window { start: chosen.at.map(|v| v as i32), shape: window.shape }.places(source.domain());
        let local = window.local();
        for (i, (&place, from)) in places.iter().zip(from).enumerate() {
            let at = local.position(i);
            let in_core = (0..2).all(|a| {
                let p = window.start[a] + at[a] as i32;
                core.start[a] <= p && p < core.end(a)
            });
            let stays = under.known()[i] && (in_core || place.is_some_and(|place| canvas.is_fixed(place)));
            shown[i] &= !stays;
            if let (Some(place), Some(from), true) = (place, from, shown[i]) {
                canvas.set(place, SampleId::new(first + from as u32), laying.level as u8);
            }
        }
        places
    }

    /// The places beside what is visible of a block's edge.
    fn along_seams(&self, laying: &Laying, canvas: &Canvas, shown: &[bool]) -> Vec<usize> {
        let (window, output) = (&laying.window, canvas.domain());
        let local = window.local();
        let limit = seam_limit(&self.pixel);
        let mut places = Vec::new();
        for (i, at) in local.positions().enumerate() {
            for axis in 0..2 {
                let Some(next) = local.next(at, axis) else { continue };
                if shown[i] == shown[local.index(next)] {
                    continue;
                }
                let Some(here) = window.position(output, at) else { continue };
                if i64::from(self.costs.at(&canvas.map, here, axis)) <= limit {
                    continue;
                }
                beside(canvas, here, axis, BESIDE_SEAMS, &mut places);
            }
        }
        places.sort_unstable();
        places.dedup();
        places
    }
}

/// The price of a seam both of whose samples have this error.
pub(crate) fn seam_limit(pixel: &Limit) -> i64 {
    (2.0 * (pixel.whole() as f64).sqrt() * f64::from(SeamCosts::<2>::SCALE)) as i64
}

/// The assigned places within `radius` of a seam between a position and the next one along an axis.
pub(crate) fn beside(canvas: &Canvas, at: [u32; 2], axis: usize, radius: u32, places: &mut Vec<usize>) {
    let (domain, r) = (canvas.domain(), radius as i32);
    let mut window = Window { start: at.map(|v| v as i32 - r + 1), shape: [2 * radius - 1; 2] };
    // As far on the far side of the seam as on the near one.
    window.shape[axis] += 1;
    let assigned = |&place: &usize| canvas.id(place).is_assigned();
    places.extend(window.places(domain).flatten().filter(assigned));
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, Source, SourceMap, Start, Transform};

    #[test]
    fn both_sides_of_a_seam_are_beside_it() {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let features = Grid::try_filled(Domain::open([1, 1]), 1, 0).unwrap();
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let output = Domain { shape: [9, 11], periodic: [false, true] };
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        map.ids.plane_mut(0).fill(SampleId::new(0));
        map.ids.set(0, [4, 4], SampleId::UNASSIGNED);
        let canvas = Canvas::new(Start { map, fixed: None, sources: None }).unwrap();
        for (at, axis, radius) in [([4, 5], 0, 1), ([4, 5], 1, 2), ([0, 10], 1, 3), ([7, 2], 0, 2)] {
            let mut found = Vec::new();
            beside(&canvas, at, axis, radius, &mut found);
            let ends = [at, output.next(at, axis).unwrap()];
            let is_near = |place: &[u32; 2]| {
                ends.iter().any(|end| {
                    (0..2).all(|a| {
                        let d = place[a].abs_diff(end[a]);
                        (if output.periodic[a] { d.min(output.shape[a] - d) } else { d }) < radius
                    })
                })
            };
            let expected = output.positions().filter(|place| is_near(place) && *place != [4, 4]);
            found.sort_unstable();
            assert_eq!(found, expected.map(|place| output.index(place)).collect::<Vec<_>>(), "{at:?} {axis} {radius}");
        }
    }
}
