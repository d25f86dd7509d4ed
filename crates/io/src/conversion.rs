//! What becomes of a plane whose samples are computed anew: by another depth, or by alpha.

use half::f16;
use selvedge_core::{Grid, Plane};

use crate::Warning;
use crate::error::Problem;

/// A plane in another depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    /// The plane.
    pub plane: Plane<2>,
    /// Samples whose value the new depth cannot hold, so that they became its greatest or least.
    pub clipped: u64,
    /// What could not be followed.
    pub warnings: Vec<Warning>,
}

/// Every sample by a function of its channel and place.
pub(crate) fn each<T: Copy + Default>(
    plane: &Plane<2>,
    mut f: impl FnMut(usize, usize) -> T,
) -> Result<Grid<T, 2>, Problem> {
    let mut out = Grid::try_filled(plane.domain(), plane.samples.channels(), T::default())?;
    for c in 0..out.channels() {
        for (i, to) in out.plane_mut(c).iter_mut().enumerate() {
            *to = f(c, i);
        }
    }
    Ok(out)
}

/// Nor may a product leave the range of floats.
pub(crate) fn to_float(v: f64, clipped: &mut u64) -> f32 {
    let limit = f64::from(f32::MAX);
    *clipped += u64::from(limit < v.abs());
    v.clamp(-limit, limit) as f32
}

/// Floats beyond the range of halves would become infinite.
pub(crate) fn to_half(v: f64, clipped: &mut u64) -> u16 {
    let limit = f16::MAX.to_f64();
    if limit < v.abs() {
        *clipped += 1;
    }
    f16::from_f32(v.clamp(-limit, limit) as f32).to_bits()
}
