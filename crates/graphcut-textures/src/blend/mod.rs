//! Hiding seams that no cut avoids: patches are blended across them. `[Kwatra03 5]`

mod feather;
mod spline;

pub use feather::Feathered;
pub use spline::Splined;

use half::f16;
use selvedge_core::{Domain, Error, Grid, Plane, Render, SampleId, Samples, SourceMap, SourceTable};

/// The plane's samples for a list of exemplar samples, in order.
fn gathered<const D: usize>(
    table: &SourceTable<D>,
    ids: Vec<SampleId>,
    planes: &[&Plane<D>],
) -> Result<Samples<D>, Error> {
    let mut shape = [1; D];
    shape[D - 1] = ids.len() as u32;
    let map = SourceMap { ids: Grid::from_vec(Domain::open(shape), 1, ids)?, table: table.clone() };
    Ok(map.render(planes)?.samples)
}

/// Sets a sample from a number: integers are rounded and held in their range.
fn set<const D: usize>(samples: &mut Samples<D>, channel: usize, index: usize, value: f64) {
    match samples {
        Samples::U8(g) => g.plane_mut(channel)[index] = (value + 0.5) as u8,
        Samples::U16(g) => g.plane_mut(channel)[index] = (value + 0.5) as u16,
        Samples::F16(g) => g.plane_mut(channel)[index] = f16::from_f32(value as f32).to_bits(),
        Samples::F32(g) => g.plane_mut(channel)[index] = value as f32,
    }
}
