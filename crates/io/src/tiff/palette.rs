//! Palettes. The decoder refuses them, so it is shown the same file as grey, and the colours are looked up afterwards.

use selvedge_core::Grid;

use crate::Format;
use crate::error::Problem;

/// Photometric interpretation of a palette, and of grey with black at 0.
pub(super) const PALETTE: u16 = 3;
const GREY: u16 = 1;
const PHOTOMETRIC: u16 = 262;

/// Makes the first directory say grey instead of palette.
pub(super) fn show_as_grey(file: &mut [u8]) -> Result<(), Problem> {
    patch(file).ok_or_else(|| Problem::ends_early(Format::Tiff))
}

fn patch(file: &mut [u8]) -> Option<()> {
    let little = file.starts_with(b"II");
    let big_tiff = file.get(if little { 2 } else { 3 }) == Some(&43);
    let number = |at: usize, len: usize| {
        let bytes = file.get(at..at.checked_add(len)?)?;
        let order: Vec<u8> = if little { bytes.iter().rev().copied().collect() } else { bytes.to_vec() };
        usize::try_from(order.into_iter().fold(0_u64, |n, b| n << 8 | u64::from(b))).ok()
    };
    // Offset of the directory, its count, its entries: wider in BigTIFF.
    let (directory, count, entry, value) =
        if big_tiff { (number(8, 8)?, 8, 20, 12) } else { (number(4, 4)?, 2, 12, 8) };
    let entries = number(directory, count)?;
    let first = directory.checked_add(count)?;
    let ours = (0..entries).map_while(|i| first.checked_add(i.checked_mul(entry)?));
    let at = ours.take_while(|at| *at < file.len()).find(|at| number(*at, 2) == Some(PHOTOMETRIC.into()))? + value;
    let grey = if little { GREY.to_le_bytes() } else { GREY.to_be_bytes() };
    file.get_mut(at..at.checked_add(2)?)?.copy_from_slice(&grey);
    Some(())
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
