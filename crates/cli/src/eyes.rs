//! Pictures for eyes: 8 bits whatever they were, and no larger than is looked at.

use std::path::Path;

use selvedge_core::{Bytes, Depth, Domain, Encoder, Grid, Plane, Samples};
use selvedge_io::{Association, Metadata};

use crate::failure::Failure;

/// The same picture in 8 bits. Floats are shown as `--explain` shows them, and as methods see them: light beyond white
/// on a logarithmic curve, heights over their range.
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
    let planes = std::slice::from_ref(plane);
    let colors = Encoder::fit(&[planes])?.encode(planes)?;
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

fn shape_tiled(domain: Domain<2>) -> [u32; 2] {
    [0, 1].map(|axis| domain.shape[axis].saturating_mul(1 + u32::from(domain.periodic[axis])))
}

/// An upper bound of what such copies take: as samples, as a file, and while that is made.
pub(crate) fn tiled_bytes(domain: Domain<2>, channels: usize) -> Bytes {
    let [height, width] = shape_tiled(domain).map(u64::from);
    Bytes(channels as u64 * 4) * height * width
}

/// A picture in RGB on white, `n` times smaller.
///
/// # Errors
/// Those of [`eight`].
pub(crate) fn on_white(plane: &Plane<2>, n: u32) -> Result<Grid<u8, 2>, Failure> {
    let small = smaller(plane, n)?;
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

/// A picture in 8 bits, `n` times smaller.
///
/// # Errors
/// Those of [`eight`].
pub(crate) fn smaller(plane: &Plane<2>, n: u32) -> Result<Plane<2>, Failure> {
    let eight = eight(plane)?;
    let Samples::U8(grid) = &eight.samples else { return Err(not_eight()) };
    if n <= 1 {
        return Ok(eight);
    }
    Ok(Plane { samples: Samples::U8(reduced(grid, n)?), ..eight })
}

fn not_eight() -> Failure {
    Failure::new(70, "a conversion to 8 bits gave something else").remedy("please report it")
}

/// The means of `n * n` samples; what does not fill a square is left out.
fn reduced(grid: &Grid<u8, 2>, n: u32) -> Result<Grid<u8, 2>, Failure> {
    let domain = Domain::open(grid.domain().shape.map(|side| (side / n).max(1)));
    let mut out = Grid::try_filled(domain, grid.channels(), 0_u8)?;
    let block = Domain::open([0, 1].map(|axis| n.min(grid.domain().shape[axis])));
    for c in 0..grid.channels() {
        for [y, x] in domain.positions() {
            let sum: u64 = block.positions().map(|[dy, dx]| u64::from(grid.get(c, [y * n + dy, x * n + dx]))).sum();
            out.set(c, [y, x], ((sum + block.len() as u64 / 2) / block.len() as u64) as u8);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Role;

    #[test]
    fn large_pictures_are_reduced_to_means() {
        let samples = (0..7 * 5).map(|i| i as u8 * 7).collect();
        let grid = Grid::from_vec(Domain::open([5, 7]), 1, samples).unwrap();
        let small = reduced(&grid, 2).unwrap();
        assert_eq!(small.domain().shape, [2, 3]);
        assert_eq!(small.samples()[0], (7 + 49 + 56 + 2) / 4);
        assert_eq!(reduced(&grid, 6).unwrap().domain().shape, [1, 1]);
    }

    #[test]
    fn light_beyond_white_keeps_its_differences() {
        let light = Grid::from_vec(Domain::open([1, 4]), 1, vec![0.0_f32, 1.0, 10.0, 1000.0]).unwrap();
        let Samples::U8(seen) = eight(&Plane::new(Role::Color, Samples::F32(light))).unwrap().samples else {
            unreachable!()
        };
        assert!(seen.samples().windows(2).all(|two| two[0] < two[1]), "{:?}", seen.samples());
    }

    #[test]
    fn what_is_transparent_is_white_paper() {
        let grid = Grid::from_vec(Domain::open([1, 2]), 2, vec![10_u8, 10, 0, 255]).unwrap();
        let plane = Plane::with_alpha(Role::Color, Samples::U8(grid));
        assert_eq!(on_white(&plane, 1).unwrap().samples(), [255, 10, 255, 10, 255, 10]);
    }
}
