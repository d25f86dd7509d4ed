//! Multi-resolution splining: coarse detail is blended widely, fine detail closely. `[Kwatra03 5]`
//!
//! Burt and Adelson's scheme (1983) with their kernel, but without dropping samples between levels: so it works on any
//! size, wraps where the output does, and needs only the neighbourhood of a position.

use selvedge_core::{Domain, Error, Grid, Patch, Payload, Plane, Render, SampleId, SourceMap, Window};

use super::mixing::Mixing;
use super::{Laid, Mixed, Part, gathered, render};

/// A source map whose seams are splined: each band of detail is blended over a width of its own.
///
/// Positions that no seam is near are copied bit for bit. Where a patch is not defined, the output itself stands in for
/// it. Values are averaged as they are stored, colours weighed by their alpha, and never leave the exemplars' range; normals
/// keep their length.
#[derive(Clone, Debug)]
pub struct Splined<'m, const D: usize> {
    laid: Laid<'m, D>,
    levels: u32,
}

impl<'m, const D: usize> Splined<'m, D> {
    /// The greatest number of bands.
    pub const MOST: u32 = 5;

    /// Splines seams over `levels` bands, from 0 (no splining) to 5; the coarsest is blended over about `2^levels` samples.
    /// Patches count where their source is `valid`, as for [`Feathered`](crate::Feathered).
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate), [`crate::Error::ForeignMap`] if the map names unknown samples,
    /// [`crate::Error::Shape`] for validity of other shapes than the sources.
    pub fn new(
        map: &'m SourceMap<D>,
        valid: Vec<Option<&'m Grid<bool, D>>>,
        levels: u32,
    ) -> Result<Self, crate::Error> {
        Self::validate(levels)?;
        Ok(Self { laid: Laid::new(map, valid)?, levels })
    }

    /// Checks a number of bands.
    ///
    /// # Errors
    /// [`crate::Error::Range`] if there are more than [`MOST`](Self::MOST).
    pub fn validate(levels: u32) -> Result<(), crate::Error> {
        let wrong = || crate::Error::Range { option: "spline", value: f64::from(levels), range: "0 to 5" };
        if levels <= Self::MOST { Ok(()) } else { Err(wrong()) }
    }

    /// The same, but positions where `kept` is true are copied, whatever is near.
    ///
    /// # Errors
    /// [`crate::Error::Shape`] if it has another shape than the map.
    pub fn keeping(self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        Ok(Self { laid: self.laid.keeping(kept)?, ..self })
    }

    /// Samples on each side of a position that its blend depends on.
    fn margin(&self) -> u32 {
        2 * ((1 << self.levels) - 1)
    }

    fn blend(&self, payload: &Payload<'_, D>, mixing: &Mixing, part: &Part<D>) -> Result<Mixed, Error> {
        let map = self.laid.map;
        let window = self.laid.around(&part.window, self.margin());
        let places = window.places(map.domain()).flatten();
        let shown: Vec<SampleId> = places.map(|i| map.ids.plane(0)[i]).collect();
        let mut sums: Vec<Vec<f64>> = Vec::new();
        for patch in self.meeting(&window) {
            let (ids, mask) = self.of_patch(&patch, &window, &shown);
            let values = gathered(payload, mixing, ids)?;
            sums.resize(values.len(), vec![0.0; shown.len()]);
            accumulate(values, mask, window.shape, self.levels, &mut sums);
        }
        let local = Domain::open(window.shape);
        let corner: [u32; D] = std::array::from_fn(|a| (part.window.start[a] - window.start[a]) as u32);
        let mut mixed = Mixed::default();
        for &(at, place) in &part.wanted {
            let i = local.index(std::array::from_fn(|a| at[a] + corner[a]));
            mixed.places.push(place);
            mixed.values.extend(sums.iter().map(|s| s[i]));
        }
        Ok(mixed)
    }

    /// The patches in a window, each once.
    fn meeting(&self, window: &Window<D>) -> Vec<Patch<D>> {
        let mut found = self.laid.map.patches(window);
        for patch in &mut found {
            // Offsets that a source's period parts show the same samples.
            let domain = self.laid.map.table.sources()[patch.source].1;
            for axis in (0..D).filter(|&a| domain.periodic[a]) {
                patch.offset[axis] = patch.offset[axis].rem_euclid(domain.shape[axis] as i32);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// A patch's samples over a window, and where it shows.
    fn of_patch(&self, patch: &Patch<D>, window: &Window<D>, shown: &[SampleId]) -> (Vec<SampleId>, Vec<f64>) {
        let table = &self.laid.map.table;
        let domain = table.sources()[patch.source].1;
        let valid = |&p: &usize| self.laid.is_valid(patch.source, domain.position(p));
        let id = |p: Option<usize>| p.filter(valid).map(|p| SampleId::new(table.first(patch.source) + p as u32));
        let own: Vec<Option<SampleId>> = patch.places(domain, window).map(id).collect();
        let mask = own.iter().zip(shown).map(|(own, shown)| f64::from(u8::from(*own == Some(*shown)))).collect();
        (own.iter().zip(shown).map(|(own, &shown)| own.unwrap_or(shown)).collect(), mask)
    }
}

impl<const D: usize> Render<D> for Splined<'_, D> {
    /// # Complexity
    /// Time `O(positions near seams * levels)` for each patch in a box.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        render(&self.laid, planes, self.margin(), |payload, mixing, part| self.blend(payload, mixing, part))
    }
}

/// Adds a patch's bands, each weighed by the mask as coarse as the band.
fn accumulate<const D: usize>(
    mut fine: Vec<Vec<f64>>,
    mut mask: Vec<f64>,
    shape: [u32; D],
    levels: u32,
    sums: &mut [Vec<f64>],
) {
    for level in 0..levels {
        for (fine, sum) in fine.iter_mut().zip(sums.iter_mut()) {
            let coarse = blurred(fine, shape, 1 << level);
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum += mask[i] * (fine[i] - coarse[i]);
            }
            *fine = coarse;
        }
        mask = blurred(&mask, shape, 1 << level);
    }
    for (fine, sum) in fine.iter().zip(sums.iter_mut()) {
        for (i, sum) in sum.iter_mut().enumerate() {
            *sum += mask[i] * fine[i];
        }
    }
}

/// Burt and Adelson's kernel, 1 4 6 4 1 sixteenths, with gaps, along each axis; the last sample goes on beyond a border.
fn blurred<const D: usize>(values: &[f64], shape: [u32; D], gap: usize) -> Vec<f64> {
    let (mut now, mut before) = (values.to_vec(), values.to_vec());
    for (axis, stride) in Domain::open(shape).strides().into_iter().enumerate() {
        let side = shape[axis] as usize;
        before.copy_from_slice(&now);
        for (to, from) in now.chunks_exact_mut(side * stride).zip(before.chunks_exact(side * stride)) {
            if stride == 1 { blur_line(to, from, gap) } else { blur_lines(to, from, side, stride, gap) }
        }
    }
    now
}

fn kernel(middle: f64, near: [f64; 2], far: [f64; 2]) -> f64 {
    (6.0 * middle + 4.0 * (near[0] + near[1]) + far[0] + far[1]) / 16.0
}

/// Along one line.
fn blur_line(to: &mut [f64], from: &[f64], gap: usize) {
    let last = from.len() - 1;
    let at = |p: usize, back: usize, ahead: usize| from[(p + ahead).saturating_sub(back).min(last)];
    let border = |p| kernel(from[p], [at(p, gap, 0), at(p, 0, gap)], [at(p, 2 * gap, 0), at(p, 0, 2 * gap)]);
    let inside = (2 * gap).min(from.len())..from.len().saturating_sub(2 * gap);
    for p in (0..inside.start).chain(inside.end.max(inside.start)..from.len()) {
        to[p] = border(p);
    }
    if inside.is_empty() {
        return;
    }
    let n = inside.len();
    let shifted = [0, 1, 2, 3, 4].map(|i| &from[i * gap..][..n]);
    for (i, to) in to[inside].iter_mut().enumerate() {
        *to = kernel(shifted[2][i], [shifted[1][i], shifted[3][i]], [shifted[0][i], shifted[4][i]]);
    }
}

/// Across `side` lines of `stride` samples.
fn blur_lines(to: &mut [f64], from: &[f64], side: usize, stride: usize, gap: usize) {
    let line = |p: usize| &from[p.min(side - 1) * stride..][..stride];
    for (p, to) in to.chunks_exact_mut(stride).enumerate() {
        let [a, b, c, d, e] =
            [line(p.saturating_sub(2 * gap)), line(p.saturating_sub(gap)), line(p), line(p + gap), line(p + 2 * gap)];
        for (i, to) in to.iter_mut().enumerate() {
            *to = kernel(c[i], [b[i], d[i]], [a[i], e[i]]);
        }
    }
}
