//! Colour spaces that are turned into RGB.

use selvedge_core::Grid;

use crate::error::Problem;

/// YCbCr of the full range to RGB [TIFF 6.0 21, with the coefficients of BT.601].
pub(super) fn from_ycbcr(grid: &Grid<u8, 2>) -> Result<Grid<u8, 2>, Problem> {
    let mut out = Grid::try_filled(grid.domain(), 3, 0_u8)?;
    for i in 0..grid.domain().len() {
        let [y, cb, cr] = [0, 1, 2].map(|c| f64::from(grid.plane(c)[i]));
        let (cb, cr) = (cb - 128.0, cr - 128.0);
        let rgb = [y + 1.402 * cr, y - (0.114 * 1.772 * cb + 0.299 * 1.402 * cr) / 0.587, y + 1.772 * cb];
        for (c, v) in rgb.into_iter().enumerate() {
            out.plane_mut(c)[i] = (v + 0.5) as u8;
        }
    }
    Ok(out)
}

/// CMYK to RGB without a profile: ink takes light away.
pub(super) fn from_cmyk<T: Copy + Default>(
    grid: &Grid<T, 2>,
    max: u32,
    to: impl Fn(T) -> u32,
    from: impl Fn(u32) -> T,
) -> Result<Grid<T, 2>, Problem> {
    let mut out = Grid::try_filled(grid.domain(), 3, T::default())?;
    for c in 0..3 {
        for i in 0..grid.domain().len() {
            let (ink, black) = (u64::from(max - to(grid.plane(c)[i])), u64::from(max - to(grid.plane(3)[i])));
            let max = u64::from(max);
            out.plane_mut(c)[i] = from(((ink * black + max / 2) / max) as u32);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    #[test]
    fn greys_and_primaries() {
        let ycbcr = vec![0, 255, 76, 128, 128, 85, 128, 128, 255];
        let out = from_ycbcr(&Grid::from_vec(Domain::open([1, 3]), 3, ycbcr).unwrap()).unwrap();
        assert_eq!([0, 1, 2].map(|i| [0, 1, 2].map(|c| out.plane(c)[i])), [[0; 3], [255; 3], [254, 0, 0]]);
        let cmyk = vec![0_u8, 255, 0, 0, 255, 0, 0, 0, 0, 0, 0, 255];
        let grid = Grid::from_vec(Domain::open([1, 3]), 4, cmyk).unwrap();
        let out = from_cmyk(&grid, 255, u32::from, |v| v as u8).unwrap();
        assert_eq!([0, 1, 2].map(|i| [0, 1, 2].map(|c| out.plane(c)[i])), [[255; 3], [0, 0, 255], [0; 3]]);
    }
}
