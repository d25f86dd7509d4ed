//! Pictures for eyes: 8 bits whatever they were, and no larger than is looked at.

use std::path::Path;

use selvedge_core::{Bytes, Depth, Domain, Encoder, Grid, Plane, Role, Samples, srgb_encode};
use selvedge_io::{Association, Metadata};

use crate::failure::Failure;

/// The same picture in 8 bits. Light of floats is shown as a screen shows it, with a shoulder towards white for what is
/// beyond; heights and other floats over their range, as methods see them.
///
/// # Errors
/// No memory for it, or samples that are no numbers.
pub(crate) fn eight(plane: &Plane<2>) -> Result<Plane<2>, Failure> {
    if matches!(plane.samples.depth(), Depth::U8 | Depth::U16) {
        let converted = selvedge_io::convert(plane, Depth::U8, &Metadata::default());
        return Ok(converted.map_err(|problem| Failure::from_problem(Path::new("a preview"), problem))?.plane);
    }
    // Light where alpha is 0 cannot be divided by it, and shows best as it is.
    let straight = selvedge_io::associate(plane, Association::Straight).map(|done| done.plane);
    let plane = &straight.unwrap_or_else(|_| plane.clone());
    let colors = if plane.role == Role::Color { lit(plane)? } else { ranged(plane)? };
    let mut grid = Grid::try_filled(plane.domain(), plane.samples.channels(), 0_u8)?;
    for c in 0..colors.channels() {
        grid.plane_mut(c).copy_from_slice(colors.plane(c));
    }
    if plane.alpha {
        let alpha = plane.color_channels();
        let of = |i| (plane.samples.value(alpha, i).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        grid.plane_mut(alpha).iter_mut().enumerate().for_each(|(i, to)| *to = of(i));
    }
    Ok(Plane { samples: Samples::U8(grid), association: Association::Straight, ..plane.clone() })
}

/// As methods see it.
fn ranged(plane: &Plane<2>) -> Result<Grid<u8, 2>, Failure> {
    let planes = std::slice::from_ref(plane);
    Ok(Encoder::fit(&[planes])?.encode(planes)?)
}

/// Light as a screen shows it. What methods see spreads all light over the steps that there are: beside a sun, grass
/// and sky would be one grey.
fn lit(plane: &Plane<2>) -> Result<Grid<u8, 2>, Failure> {
    let (n, colors) = (plane.domain().len(), plane.color_channels());
    // The median of some thousand samples: a picture whose half is brighter than grey is one of large numbers.
    let every = n.div_ceil(4096).max(1);
    let mut some: Vec<f64> = (0..n).step_by(every).map(|i| plane.samples.value(colors / 2, i)).collect();
    some.sort_unstable_by(f64::total_cmp);
    let median = some.get(some.len() / 2).copied().unwrap_or_default();
    let scale = if GREY < median { GREY / median } else { 1.0 };
    let mut grid = Grid::try_filled(plane.domain(), colors, 0_u8)?;
    for c in 0..colors {
        let of = |i| (srgb_encode(shoulder(plane.samples.value(c, i) * scale)) * 255.0 + 0.5) as u8;
        grid.plane_mut(c).iter_mut().enumerate().for_each(|(i, to)| *to = of(i));
    }
    Ok(grid)
}

/// Where light begins to be pressed together, and how bright half of a picture may be. Both are choices: what is
/// darker than the knee is shown as it is, so that an HDR picture looks like its 8-bit one wherever that has room; a
/// picture whose half is above middle light is shown darker, or all of it would lie beyond the knee.
const KNEE: f64 = 0.8;
const GREY: f64 = 0.5;

/// Light as it is up to the knee; beyond, with the same slope at first, towards 1.
fn shoulder(light: f64) -> f64 {
    if light <= KNEE {
        return light.max(0.0);
    }
    let (beyond, room) = (light - KNEE, 1.0 - KNEE);
    KNEE + room * beyond / (beyond + room)
}

/// Two by two copies of an output beside each other, in 8 bits; one along an axis that is open.
///
/// # Errors
/// Those of [`eight`].
pub(crate) fn tiled(plane: &Plane<2>, domain: Domain<2>) -> Result<Plane<2>, Failure> {
    let one = eight(plane)?;
    let Samples::U8(grid) = &one.samples else { return Err(not_eight()) };
    let twice = Domain::open(shape_tiled(domain));
    let mut out = Grid::try_filled(twice, grid.channels(), 0_u8)?;
    for c in 0..grid.channels() {
        for at in twice.positions() {
            out.set(c, at, grid.get(c, [0, 1].map(|axis| at[axis] % domain.shape[axis])));
        }
    }
    Ok(Plane { samples: Samples::U8(out), ..one })
}

/// Height and width of such copies.
pub(crate) fn shape_tiled(domain: Domain<2>) -> [u32; 2] {
    [0, 1].map(|axis| domain.shape[axis].saturating_mul(1 + u32::from(domain.periodic[axis])))
}

/// An upper bound of what such copies take: as samples, as a file, and while that is made.
pub(crate) fn tiled_bytes(domain: Domain<2>, channels: usize) -> Bytes {
    let [height, width] = shape_tiled(domain).map(u64::from);
    Bytes(channels as u64 * 4) * height * width
}

/// A picture in RGB on white, no side longer than this.
///
/// # Errors
/// Those of [`eight`].
pub(crate) fn on_white(plane: &Plane<2>, longest: u32) -> Result<Grid<u8, 2>, Failure> {
    let small = smaller(plane, longest)?;
    let Samples::U8(grid) = &small.samples else { return Err(not_eight()) };
    let (colors, alpha) = (small.color_channels(), small.alpha);
    let mut out = Grid::try_filled(grid.domain(), 3, 0_u8)?;
    for c in 0..3 {
        let from = grid.plane(c.min(colors - 1));
        for (i, to) in out.plane_mut(c).iter_mut().enumerate() {
            let opaque = if alpha { u32::from(grid.plane(colors)[i]) } else { 255 };
            *to = ((u32::from(from[i]) * opaque + 255 * (255 - opaque) + 127) / 255) as u8;
        }
    }
    Ok(out)
}

/// A picture in 8 bits, no side longer than this.
///
/// # Errors
/// Those of [`eight`].
pub(crate) fn smaller(plane: &Plane<2>, longest: u32) -> Result<Plane<2>, Failure> {
    let eight = eight(plane)?;
    let Samples::U8(grid) = &eight.samples else { return Err(not_eight()) };
    if grid.domain().shape.iter().all(|&side| side <= longest) {
        return Ok(eight);
    }
    Ok(Plane { samples: Samples::U8(grid.reduced(longest)?), ..eight })
}

/// What cannot be.
pub(crate) fn not_eight() -> Failure {
    Failure::new(70, "a conversion to 8 bits gave something else").remedy("please report it")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_beyond_white_keeps_its_differences() {
        let light = Grid::from_vec(Domain::open([1, 4]), 1, vec![0.0_f32, 1.0, 10.0, 1000.0]).unwrap();
        let Samples::U8(seen) = eight(&Plane::new(Role::Color, Samples::F32(light))).unwrap().samples else {
            unreachable!()
        };
        assert!(seen.samples().windows(2).all(|two| two[0] < two[1]), "{:?}", seen.samples());
    }

    #[test]
    fn light_looks_as_on_a_screen() {
        let seen = |scale: f32| {
            let mut light = [0.0_f32, 0.05, 0.2, 0.4, 0.7].map(|v| v * scale).repeat(100);
            light.push(60_000.0 * scale);
            let light = Grid::from_vec(Domain::open([1, 501]), 1, light).unwrap();
            let Samples::U8(seen) = eight(&Plane::new(Role::Color, Samples::F32(light))).unwrap().samples else {
                unreachable!()
            };
            seen.into_vec()
        };
        // A sun changes nothing, and large numbers are a matter of units.
        assert_eq!(seen(1.0)[..5], [0.0, 0.05, 0.2, 0.4, 0.7].map(|v| (srgb_encode(v) * 255.0).round() as u8));
        let large = seen(1000.0);
        assert_eq!((large[2], large[0], large[500]), ((srgb_encode(0.5) * 255.0).round() as u8, 0, 255));
    }

    #[test]
    fn what_is_transparent_is_white_paper() {
        let grid = Grid::from_vec(Domain::open([1, 2]), 2, vec![10_u8, 10, 0, 255]).unwrap();
        let plane = Plane::with_alpha(Role::Color, Samples::U8(grid));
        assert_eq!(on_white(&plane, 2).unwrap().samples(), [255, 10, 255, 10, 255, 10]);
    }
}
