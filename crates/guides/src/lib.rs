//! Maps that steer: what exemplars and target are compared by. `[Efros01 3]`
//!
//! "That quantity could include image intensity, blurred image intensity, local image orientation angles, or other
//! derived quantities": [`luminance`], [`blur`], [`orientation`], [`edge_distance`], [`position`], or any pictures made
//! registered by [`encode_together`]. A [`Guide`](selvedge_core::Guide) holds such maps under exemplars and output, and
//! [`match_histogram`] brings the one into the range of the other.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Guide, Plane, Role, Samples};
//! use selvedge_guides::{blur, encode_together, luminance, match_histogram};
//! # fn main() -> Result<(), selvedge_guides::Error> {
//! let ramp = |from: u8, step: u8| -> Result<Plane<2>, selvedge_core::Error> {
//!     let samples = (0..8).map(|x| from + step * x).collect();
//!     Ok(Plane::new(Role::Color, Samples::U8(Grid::from_vec(Domain::open([1, 8]), 1, samples)?)))
//! };
//! let (cloth, target) = (ramp(0, 30)?, ramp(90, 4)?);
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&cloth)])?;
//! let mut maps = encode_together(&[&cloth, &target])?.iter().map(luminance).collect::<Result<Vec<_>, _>>()?;
//! let target = maps.remove(1);
//! let guide = Guide::new(&exemplars, &maps, target)?.derive(|map| blur(map, 0.3))?;
//! // The grey target asks for all of the cloth's range.
//! assert_eq!(match_histogram(guide)?.target().samples(), [0, 30, 60, 90, 120, 150, 180, 210]);
//! # Ok(())
//! # }
//! ```
//!
//! Everything is decided on 8-bit features and computed in f64 in a fixed order: the same on every machine.
//!
//! # Features
//! `rayon` (default): rows are smoothed on the caller's pool; the result is the same without it.
#![forbid(unsafe_code)]

mod edges;
mod error;
mod gaussian;
mod histogram;
mod orientation;

use std::borrow::Cow;

use selvedge_core::{Encoder, Grid, Plane, Samples, collected, reserve};

use gaussian::Gaussian;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use edges::{edge_distance, position};
pub use error::Error;
pub use histogram::match_histogram;
pub use orientation::orientation;

/// Features of pictures of any depth on one scale. Grey ones are taken as colour where others have colour; alpha is
/// left out.
///
/// # Errors
/// Those of [`Encoder::fit`].
pub fn encode_together(planes: &[&Plane<2>]) -> Result<Vec<Grid<u8, 2>>, Error> {
    let any_color = planes.iter().any(|p| p.color_channels() == 3);
    let planes = planes.iter().map(|&p| if any_color { colored(p) } else { Ok(Cow::Borrowed(p)) });
    let planes = planes.collect::<Result<Vec<_>, _>>()?;
    let each: Vec<&[Plane<2>]> = planes.iter().map(|p| std::slice::from_ref(&**p)).collect();
    let encoder = Encoder::fit(&each)?;
    Ok(each.iter().map(|p| encoder.encode(p)).collect::<Result<_, _>>()?)
}

/// A grey plane as red, green and blue; any other as it is.
fn colored(plane: &Plane<2>) -> Result<Cow<'_, Plane<2>>, Error> {
    fn thrice<T: Copy>(grid: &Grid<T, 2>) -> Result<Grid<T, 2>, Error> {
        let (mut samples, one) = (Vec::new(), grid.plane(0));
        reserve(&mut samples, 3 * one.len())?;
        (0..3).for_each(|_| samples.extend_from_slice(one));
        Ok(Grid::from_vec(grid.domain(), 3, samples)?)
    }
    if plane.color_channels() != 1 {
        return Ok(Cow::Borrowed(plane));
    }
    let samples = match &plane.samples {
        Samples::U8(g) => Samples::U8(thrice(g)?),
        Samples::U16(g) => Samples::U16(thrice(g)?),
        Samples::F16(g) => Samples::F16(thrice(g)?),
        Samples::F32(g) => Samples::F32(thrice(g)?),
    };
    Ok(Cow::Owned(Plane::new(plane.role, samples)))
}

/// Luminance: of three channels `(77 R + 150 G + 29 B) / 256`, the weights of BT.601; of any other number their mean.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn luminance<const D: usize>(features: &Grid<u8, D>) -> Result<Grid<u8, D>, Error> {
    let weights = match features.channels() {
        3 => vec![77, 150, 29],
        n => vec![1; n],
    };
    let whole = weights.iter().sum::<u32>().max(1);
    let mut out = Grid::try_filled(features.domain(), 1, 0)?;
    for (i, to) in out.samples_mut().iter_mut().enumerate() {
        let sum: u32 = weights.iter().enumerate().map(|(c, &w)| w * u32::from(features.plane(c)[i])).sum();
        *to = ((sum + whole / 2) / whole) as u8;
    }
    Ok(out)
}

/// Each channel blurred by a Gaussian of standard deviation `sigma` in samples, 0 to 1000; periodic axes wrap, others
/// repeat their border.
///
/// # Errors
/// [`Error::Blur`], and [`Error::Core`] if memory is short.
pub fn blur(map: &Grid<u8, 2>, sigma: f64) -> Result<Grid<u8, 2>, Error> {
    let gaussian = Gaussian::new(sigma)?;
    let mut out = Grid::try_filled(map.domain(), map.channels(), 0)?;
    for c in 0..map.channels() {
        let values = collected(map.plane(c).iter().map(|&v| f64::from(v)))?;
        let smooth = gaussian.smooth(map.domain(), &values)?;
        out.plane_mut(c).iter_mut().zip(smooth).for_each(|(to, v)| *to = (v + 0.5) as u8);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Role};

    fn plane(samples: Samples<2>) -> Plane<2> {
        Plane::new(Role::Color, samples)
    }

    #[test]
    fn grey_and_colour_of_any_depth_are_put_on_one_scale() {
        let domain = Domain::open([1, 2]);
        let color = Grid::from_vec(domain, 3, vec![10_u8, 200, 20, 200, 30, 200]).unwrap();
        let grey = Grid::from_vec(domain, 1, vec![257_u16 * 10, 257 * 200]).unwrap();
        let light = Grid::from_vec(domain, 1, vec![0.0_f32, 1.0]).unwrap();
        let planes = [plane(Samples::U8(color)), plane(Samples::U16(grey)), plane(Samples::F32(light))];
        let all = encode_together(&planes.each_ref()).unwrap();
        assert_eq!(all[0].samples(), [10, 200, 20, 200, 30, 200]);
        assert_eq!(all[1].samples(), [10, 200, 10, 200, 10, 200]);
        assert_eq!(all[2].samples(), [0, 255, 0, 255, 0, 255]);
        assert_eq!(luminance(&all[0]).unwrap().samples(), [18, 200]);
        assert_eq!(luminance(&all[1]).unwrap().samples(), [10, 200]);
    }

    #[test]
    fn blurs_keep_constants_and_spread_points_like_a_gaussian() {
        let constant = Grid::try_filled(Domain::open([5, 7]), 2, 91_u8).unwrap();
        assert_eq!(blur(&constant, 40.0).unwrap(), constant);
        let mut point = Grid::try_filled(Domain::open([21, 21]), 1, 0_u8).unwrap();
        point.set(0, [10, 10], 255);
        let spread = blur(&point, 1.0).unwrap();
        // 255 / (2 pi) * exp(-d^2 / 2) at distances 0, 1 and sqrt(2).
        assert_eq!([[10, 10], [10, 11], [9, 11]].map(|at| spread.get(0, at)), [41, 25, 15]);
        assert_eq!(blur(&point, 0.0).unwrap(), point);
    }

    #[test]
    fn blurs_wrap_on_periodic_axes_only() {
        let mut edge = Grid::try_filled(Domain { shape: [9, 9], periodic: [false, true] }, 1, 0_u8).unwrap();
        edge.set(0, [4, 0], 255);
        let wrapped = blur(&edge, 1.0).unwrap();
        assert_eq!(wrapped.get(0, [4, 8]), wrapped.get(0, [4, 1]));
        assert_eq!(blur(&edge.with_periodic([false; 2]), 1.0).unwrap().get(0, [4, 8]), 0);
    }

    #[test]
    fn blurs_out_of_range_are_refused() {
        let map = Grid::try_filled(Domain::open([2, 2]), 1, 0_u8).unwrap();
        for sigma in [-1.0, f64::NAN, f64::INFINITY, 1e4] {
            assert!(matches!(blur(&map, sigma), Err(Error::Blur { .. })));
        }
    }
}
