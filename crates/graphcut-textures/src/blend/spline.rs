//! Multi-resolution splining: coarse detail is blended widely, fine detail closely. `[Kwatra03 5]`
//!
//! Burt and Adelson's scheme (1983) with their kernel, but without dropping samples between levels: so it works on any
//! size, wraps where the output does, and needs only the neighbourhood of a position.

use selvedge_core::{Domain, Error, Exemplars, Plane, Render, SampleId, Samples, SourceMap, par};

use super::feather::is_valid;
use super::{gathered, set};
use crate::patch::Patch;
use crate::region::patches;
use crate::window::Window;

/// Side of the boxes that are blended one by one.
const BOX: u32 = 64;

/// A source map whose seams are splined: each band of detail is blended over a width of its own.
///
/// Boxes in which only one patch shows are copied bit for bit. Where a patch is not defined, the output itself stands
/// in for it. Values are averaged as they are stored.
#[derive(Clone, Debug)]
pub struct Splined<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    map: SourceMap<D>,
    levels: u32,
}

impl<'e, const D: usize> Splined<'e, D> {
    /// Splines seams over `levels` bands, from 0 (no splining) to 5; the coarsest is blended over about `2^levels` samples.
    ///
    /// # Errors
    /// [`crate::Error::Range`] for other values, [`crate::Error::ForeignMap`] if the map names unknown samples.
    pub fn new(exemplars: &'e Exemplars<D>, map: SourceMap<D>, levels: u32) -> Result<Self, crate::Error> {
        if 5 < levels {
            return Err(crate::Error::Range { option: "spline", value: f64::from(levels), range: "0 to 5" });
        }
        crate::check_map(exemplars, &map)?;
        Ok(Self { exemplars, map, levels })
    }

    /// Samples on each side of a box that its blend depends on.
    fn margin(&self) -> u32 {
        2 * ((1 << self.levels) - 1)
    }

    /// The blended values of a box, planar; `None` if a single patch shows around it.
    fn blend(&self, inner: &Window<D>, planes: &[&Plane<D>]) -> Result<Option<Vec<Vec<f64>>>, Error> {
        let output = self.map.domain();
        let window = inner.grown(output, [self.margin(); D], [self.margin(); D]);
        let found = patches(&self.map, &window);
        if found.len() < 2 || self.levels == 0 {
            return Ok(None);
        }
        let shown: Vec<SampleId> =
            window.indices(output).into_iter().map(|i| self.map.ids.plane(0)[i as usize]).collect();
        let mut sums: Vec<Vec<f64>> = Vec::new();
        for patch in &found {
            let (ids, mask) = self.of_patch(patch, &window, &shown);
            let values = gathered(&self.map.table, ids, planes)?;
            sums.resize(values.channels(), vec![0.0; shown.len()]);
            accumulate(&values, mask, window.shape, self.levels, &mut sums);
        }
        let local: Vec<usize> = positions_of(inner, &window, output);
        Ok(Some(sums.into_iter().map(|s| local.iter().map(|&i| s[i]).collect()).collect()))
    }

    /// A patch's samples over a window, and where it shows.
    fn of_patch(&self, patch: &Patch<D>, window: &Window<D>, shown: &[SampleId]) -> (Vec<SampleId>, Vec<f64>) {
        let domain = self.exemplars.sources()[patch.source].domain();
        let first = self.exemplars.table().first(patch.source);
        let mut places = vec![Some(0_u32)];
        for axis in 0..D {
            let along: Vec<_> = patch.places(domain, window, axis).collect();
            places = places.iter().flat_map(|p| along.iter().map(move |a| Some((*p)? + (*a)?))).collect();
        }
        let id = |p: Option<u32>| p.map(|p| SampleId::new(first + p)).filter(|&id| is_valid(self.exemplars, id));
        let own: Vec<Option<SampleId>> = places.into_iter().map(id).collect();
        let mask = own.iter().zip(shown).map(|(own, shown)| f64::from(u8::from(*own == Some(*shown)))).collect();
        (own.iter().zip(shown).map(|(own, &shown)| own.unwrap_or(shown)).collect(), mask)
    }
}

/// Places of a window's positions in the larger window's buffer.
fn positions_of<const D: usize>(inner: &Window<D>, outer: &Window<D>, output: Domain<D>) -> Vec<usize> {
    let side = |a: usize| output.shape[a] as i32;
    let local = Window {
        start: std::array::from_fn(|a| (inner.start[a] - outer.start[a]).rem_euclid(side(a).max(1))),
        shape: inner.shape,
    };
    // Where the window goes all the way around, so do places in it.
    let periodic = std::array::from_fn(|a| output.periodic[a] && outer.shape[a] == output.shape[a]);
    local.indices(Domain { shape: outer.shape, periodic }).into_iter().map(|i| i as usize).collect()
}

/// Adds a patch's bands, each weighed by the mask as coarse as the band.
fn accumulate<const D: usize>(
    values: &Samples<D>,
    mut mask: Vec<f64>,
    shape: [u32; D],
    levels: u32,
    sums: &mut [Vec<f64>],
) {
    let n = mask.len();
    let mut fine: Vec<Vec<f64>> =
        (0..values.channels()).map(|c| (0..n).map(|i| values.value(c, i)).collect()).collect();
    for level in 0..levels {
        for (fine, sum) in fine.iter_mut().zip(sums.iter_mut()) {
            let coarse = blurred(fine, shape, 1 << level);
            for i in 0..n {
                sum[i] += mask[i] * (fine[i] - coarse[i]);
            }
            *fine = coarse;
        }
        mask = blurred(&mask, shape, 1 << level);
    }
    for (fine, sum) in fine.iter().zip(sums.iter_mut()) {
        for i in 0..n {
            sum[i] += mask[i] * fine[i];
        }
    }
}

/// Burt and Adelson's kernel, 1 4 6 4 1 sixteenths, with gaps, along each axis; the last sample goes on beyond a border.
fn blurred<const D: usize>(values: &[f64], shape: [u32; D], gap: i64) -> Vec<f64> {
    let mut now = values.to_vec();
    for (axis, stride) in Domain::open(shape).strides().into_iter().enumerate() {
        let side = i64::from(shape[axis]);
        let before = now.clone();
        for (i, to) in now.iter_mut().enumerate() {
            let p = (i / stride) as i64 % side;
            let tap = |d: i64| before[(i as i64 + ((p + d * gap).clamp(0, side - 1) - p) * stride as i64) as usize];
            *to = (6.0 * tap(0) + 4.0 * (tap(-1) + tap(1)) + tap(-2) + tap(2)) / 16.0;
        }
    }
    now
}

impl<const D: usize> Render<D> for Splined<'_, D> {
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        let mut plane = self.map.render(planes)?;
        let output = self.map.domain();
        let boxes = Domain::open(output.shape.map(|n| n.div_ceil(BOX)));
        let windows: Vec<Window<D>> = boxes
            .positions()
            .map(|b| Window {
                start: b.map(|v| (v * BOX) as i32),
                shape: std::array::from_fn(|a| BOX.min(output.shape[a] - b[a] * BOX)),
            })
            .collect();
        // A row of boxes at a time: their values are held until they are written.
        let row = boxes.shape[D - 1].max(1) as usize;
        for windows in windows.chunks(row) {
            let blended = par::map_indexed(windows.len(), |i| self.blend(&windows[i], planes));
            for (window, blended) in windows.iter().zip(blended) {
                let Some(channels) = blended? else { continue };
                let places = window.indices(output);
                for (c, values) in channels.iter().enumerate() {
                    for (&place, &value) in places.iter().zip(values) {
                        set(&mut plane.samples, c, place as usize, value);
                    }
                }
            }
        }
        Ok(plane)
    }
}
