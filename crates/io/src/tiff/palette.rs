//! Palettes. The decoder refuses them, so it is shown the same file as grey, and the colours are looked up afterwards.

use selvedge_core::Grid;

use super::directory::{Directory, PHOTOMETRIC};
use crate::Format;
use crate::error::Problem;

/// Photometric interpretation of a palette, and of grey with black at 0.
pub(super) const PALETTE: u16 = 3;
const GREY: u16 = 1;

/// Makes the first directory say grey instead of what it says.
pub(super) fn show_as_grey(file: &mut [u8]) -> Result<(), Problem> {
    let directory = Directory::of(file)?;
    directory.set(file, PHOTOMETRIC, GREY).ok_or_else(|| Problem::ends_early(Format::Tiff))
}

/// The colours of indices, and how many indices lie beyond the palette. Colours have 16 bits in the file, of which
/// palettes use the upper 8.
pub(super) fn expand(indices: &Grid<u8, 2>, colors: &[u16]) -> Result<(Grid<u8, 2>, u64), Problem> {
    let n = colors.len() / 3;
    let mut grid = Grid::try_filled(indices.domain(), 3, 0_u8)?;
    for c in 0..3 {
        for (to, &index) in grid.plane_mut(c).iter_mut().zip(indices.plane(0)) {
            let known = usize::from(index) < n;
            *to = if known { (colors[c * n + usize::from(index)] >> 8) as u8 } else { 0 };
        }
    }
    let beyond = indices.plane(0).iter().filter(|i| n <= usize::from(**i)).count() as u64;
    Ok((grid, beyond))
}
