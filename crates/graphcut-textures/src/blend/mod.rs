//! Hiding seams that no cut avoids: patches are blended across them. `[Kwatra03 5]`
//!
//! Both blends render a map box by box: only positions that have a seam in reach are computed, all others are copied.

mod feather;
mod mixing;
mod near;
mod spline;

pub use feather::Feathered;
pub use spline::Splined;

use selvedge_core::{Domain, Error, Grid, Payload, Plane, SampleId, SourceMap, Window, par};

use self::mixing::Mixing;
use self::near::near_seams;

/// Side of the boxes that are blended one by one.
const BOX: u32 = 64;

/// A map, and what blending has to know besides.
#[derive(Clone, Debug)]
struct Laid<'m, const D: usize> {
    map: &'m SourceMap<D>,
    /// By source: which of its samples may show.
    valid: Vec<Option<&'m Grid<bool, D>>>,
    /// Positions that are copied, whatever is near.
    kept: Option<&'m Grid<bool, D>>,
}

impl<'m, const D: usize> Laid<'m, D> {
    fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>) -> Result<Self, crate::Error> {
        crate::start::check_map(&map.table, map)?;
        let of_sources = valid.iter().map(|v| v.map(Grid::domain)).chain(std::iter::repeat(None));
        for ((_, domain), found) in map.table.sources().iter().zip(of_sources) {
            check_shape("validity of a source", *domain, found)?;
        }
        Ok(Self { map, valid, kept: None })
    }

    fn keeping(mut self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        check_shape("mask of fixed samples", self.map.domain(), Some(kept.domain()))?;
        self.kept = Some(kept);
        Ok(self)
    }

    fn is_valid(&self, source: usize, at: [u32; D]) -> bool {
        self.valid.get(source).copied().flatten().is_none_or(|v| v.get(0, at))
    }

    /// A box and what is `margin` around it: as far as the output reaches on open axes, around periodic ones.
    fn around(&self, inner: &Window<D>, margin: u32) -> Window<D> {
        let output = self.map.domain();
        let mut outer = *inner;
        for axis in 0..D {
            let (mut start, mut end) = (inner.start[axis] - margin as i32, inner.end(axis) + margin as i32);
            if !output.periodic[axis] {
                (start, end) = (start.max(0), end.min(output.shape[axis] as i32));
            }
            (outer.start[axis], outer.shape[axis]) = (start, (end - start) as u32);
        }
        outer
    }
}

fn check_shape<const D: usize>(
    what: &'static str,
    expected: Domain<D>,
    found: Option<Domain<D>>,
) -> Result<(), crate::Error> {
    match found.filter(|f| f.shape != expected.shape) {
        Some(f) => Err(crate::Error::Shape { what, expected: expected.shape.to_vec(), found: f.shape.to_vec() }),
        None => Ok(()),
    }
}

/// Part of an output and the positions in it that are to be blended.
struct Part<const D: usize> {
    window: Window<D>,
    /// Position in the window, and place in the output's buffer.
    wanted: Vec<([u32; D], u32)>,
}

/// Blended samples as numbers: all channels of a place side by side.
#[derive(Default)]
struct Mixed {
    places: Vec<u32>,
    values: Vec<f64>,
}

/// Renders a map, and what `blend` makes of the positions that have a seam within `reach` along every axis.
fn render<const D: usize>(
    laid: &Laid<'_, D>,
    planes: &[&Plane<D>],
    reach: u32,
    blend: impl Fn(&Payload<'_, D>, &Mixing, &Part<D>) -> Result<Mixed, Error> + Sync,
) -> Result<Plane<D>, Error> {
    let payload = Payload::new(&laid.map.table, planes)?;
    let mut plane = payload.gather(&laid.map.ids)?;
    let mut near = near_seams(laid.map, reach)?;
    if let Some(kept) = laid.kept {
        near.iter_mut().zip(kept.plane(0)).for_each(|(near, kept)| *near &= !kept);
    }
    let mixing = Mixing::new(planes);
    let windows = boxes(laid.map.domain());
    // Some at a time: their values are held until they are written.
    for windows in windows.chunks(64) {
        let mixed = par::map_indexed(windows.len(), |i| {
            let part = part(&windows[i], laid.map.domain(), &near);
            if part.wanted.is_empty() { Ok(Mixed::default()) } else { blend(&payload, &mixing, &part) }
        });
        for mixed in mixed {
            let Mixed { places, mut values } = mixed?;
            for (&place, values) in places.iter().zip(values.chunks_mut(plane.samples.channels())) {
                mixing.set(&mut plane.samples, place as usize, values);
            }
        }
    }
    Ok(plane)
}

fn boxes<const D: usize>(output: Domain<D>) -> Vec<Window<D>> {
    let boxes = Domain::open(output.shape.map(|n| n.div_ceil(BOX)));
    let window = |b: [u32; D]| Window {
        start: b.map(|v| (v * BOX) as i32),
        shape: std::array::from_fn(|a| BOX.min(output.shape[a] - b[a] * BOX)),
    };
    boxes.positions().map(window).collect()
}

fn part<const D: usize>(window: &Window<D>, output: Domain<D>, near: &[bool]) -> Part<D> {
    let positions = Domain::open(window.shape).positions().zip(window.places(output).flatten().map(|p| p as u32));
    Part { window: *window, wanted: positions.filter(|&(_, place)| near[place as usize]).collect() }
}

/// The payload's samples of these numbers, in order, as numbers that may be averaged; planar.
fn gathered<const D: usize>(
    payload: &Payload<'_, D>,
    mixing: &Mixing,
    ids: Vec<SampleId>,
) -> Result<Vec<Vec<f64>>, Error> {
    let mut shape = [1; D];
    shape[D - 1] = ids.len() as u32;
    Ok(mixing.numbers(&payload.gather(&Grid::from_vec(Domain::open(shape), 1, ids)?)?))
}
