//! From a decoder's interleaved bytes to planar grids, and the right way up.

use selvedge_core::{Grid, Samples, Transform, try_vec};

use crate::Depth;
use crate::error::Problem;
use crate::header::Header;

/// Zeros for a decoder to fill. The system gives memory for them only where something is written, so that a file that
/// ends after its header takes none.
pub(crate) fn zeros<T: Copy + Default>(len: usize) -> Result<Vec<T>, Problem> {
    // Zeros at once cannot be refused, so the same room is asked for first.
    let mut asked = Vec::<T>::new();
    let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
    asked.try_reserve_exact(len).map_err(|_| selvedge_core::Error::Allocation { bytes })?;
    drop(asked);
    Ok(vec![T::default(); len])
}

/// A grid of [`zeros`].
pub(crate) fn zero_grid<T: Copy + Default>(header: &Header) -> Result<Grid<T, 2>, Problem> {
    let domain = header.domain();
    Ok(Grid::from_vec(domain, header.channels, zeros(domain.len() * header.channels)?)?)
}

/// Planar samples from interleaved ones of `N` bytes each.
pub(crate) fn deinterleave<T: Copy + Default, const N: usize>(
    header: &Header,
    bytes: &[u8],
    sample: impl Fn([u8; N]) -> T,
) -> Result<Grid<T, 2>, Problem> {
    let domain = header.domain();
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

/// Planar samples of the header's depth from interleaved ones in the machine's byte order.
pub(crate) fn from_native(header: &Header, bytes: &[u8]) -> Result<Samples<2>, Problem> {
    Ok(match header.depth {
        Depth::U8 => Samples::U8(deinterleave(header, bytes, |b: [u8; 1]| b[0])?),
        Depth::U16 => Samples::U16(deinterleave(header, bytes, u16::from_ne_bytes)?),
        Depth::F16 => Samples::F16(deinterleave(header, bytes, u16::from_ne_bytes)?),
        Depth::F32 => Samples::F32(deinterleave(header, bytes, f32::from_ne_bytes)?),
    })
}

/// One byte for each of a row-padded file's samples of 1, 2 or 4 bits.
pub(crate) fn unpack(packed: &[u8], bits: u8, row: usize, rows: usize) -> Result<Vec<u8>, Problem> {
    let stride = (row * usize::from(bits)).div_ceil(8);
    let mut out = try_vec(row * rows, 0_u8)?;
    if row == 0 || packed.len() < stride * rows {
        return Err(selvedge_core::Error::Length { expected: stride * rows, found: packed.len() }.into());
    }
    for (to, from) in out.chunks_exact_mut(row).zip(packed.chunks_exact(stride)) {
        for (i, value) in to.iter_mut().enumerate() {
            let bit = i * usize::from(bits);
            let shift = 8 - usize::from(bits) - bit % 8;
            *value = from[bit / 8] >> shift & (u8::MAX >> (8 - bits));
        }
    }
    Ok(out)
}

/// Turns a picture the way its EXIF orientation (1..=8) says; anything else is left as it is.
pub(crate) fn orient(samples: Samples<2>, orientation: u8) -> Result<Samples<2>, Problem> {
    let (quarter_turns, mirror) = match orientation {
        2 => (0, true),
        3 => (2, false),
        4 => (2, true),
        5 => (3, true),
        6 => (1, false),
        7 => (1, true),
        8 => (3, false),
        _ => return Ok(samples),
    };
    let transform = Transform::Exact { quarter_turns, mirror };
    Ok(match samples {
        Samples::U8(grid) => Samples::U8(turned(&grid, transform)?),
        Samples::U16(grid) => Samples::U16(turned(&grid, transform)?),
        Samples::F16(grid) => Samples::F16(turned(&grid, transform)?),
        Samples::F32(grid) => Samples::F32(turned(&grid, transform)?),
    })
}

fn turned<T: Copy + Default>(grid: &Grid<T, 2>, transform: Transform) -> Result<Grid<T, 2>, Problem> {
    let domain = transform.domain(grid.domain());
    let mut out = Grid::try_filled(domain, grid.channels(), T::default())?;
    for c in 0..grid.channels() {
        for (to, at) in out.plane_mut(c).iter_mut().zip(domain.positions()) {
            *to = grid.get(c, transform.origin(domain, at));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    #[test]
    fn every_orientation_shows_the_corner_where_exif_says() {
        // EXIF 2.32, tag 274: where row 0 and column 0 of the file are to be shown. The file is `1 2 3 / 4 5 6`.
        let shown: [&[u8]; 8] = [
            &[1, 2, 3, 4, 5, 6],
            &[3, 2, 1, 6, 5, 4],
            &[6, 5, 4, 3, 2, 1],
            &[4, 5, 6, 1, 2, 3],
            &[1, 4, 2, 5, 3, 6],
            &[4, 1, 5, 2, 6, 3],
            &[6, 3, 5, 2, 4, 1],
            &[3, 6, 2, 5, 1, 4],
        ];
        for (expected, orientation) in shown.into_iter().zip(1..) {
            let file = Grid::from_vec(Domain::open([2, 3]), 1, vec![1, 2, 3, 4, 5, 6]).unwrap();
            let Samples::U8(out) = orient(Samples::U8(file), orientation).unwrap() else { unreachable!() };
            assert_eq!(out.plane(0), expected, "orientation {orientation}");
        }
    }

    #[test]
    fn packed_bits_are_spread_row_by_row() {
        assert_eq!(unpack(&[0b1010_0000, 0b0110_0000], 1, 3, 2).unwrap(), [1, 0, 1, 0, 1, 1]);
        assert_eq!(unpack(&[0b1101_1000], 2, 3, 1).unwrap(), [3, 1, 2]);
        assert_eq!(unpack(&[0xab, 0xc0], 4, 3, 1).unwrap(), [10, 11, 12]);
        assert!(unpack(&[0xab], 4, 3, 1).is_err());
    }
}
