//! From a decoder's interleaved bytes to planar grids.

use selvedge_core::{Domain, Grid};

use crate::error::Problem;
use crate::header::Header;

/// Planar samples from interleaved ones of `N` bytes each.
pub(crate) fn deinterleave<T: Copy + Default, const N: usize>(
    header: &Header,
    bytes: &[u8],
    sample: impl Fn([u8; N]) -> T,
) -> Result<Grid<T, 2>, Problem> {
    let domain = Domain::open([header.height as u32, header.width as u32]);
    let mut grid = Grid::try_filled(domain, header.channels, T::default())?;
    let expected = domain.len() * header.channels * N;
    if bytes.len() != expected {
        return Err(selvedge_core::Error::Length { expected, found: bytes.len() }.into());
    }
    let (samples, _) = bytes.as_chunks::<N>();
    for c in 0..header.channels {
        for (to, from) in grid.plane_mut(c).iter_mut().zip(samples[c..].iter().step_by(header.channels)) {
            *to = sample(*from);
        }
    }
    Ok(grid)
}
