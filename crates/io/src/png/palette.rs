//! Palettes, expanded by ourselves so that samples beyond the palette are seen.

use png::{BitDepth, Info};
use selvedge_core::{Grid, Samples};

use crate::codec::Context;
use crate::error::Problem;
use crate::header::Header;
use crate::samples::unpack;
use crate::{Format, Warning};

/// The colours of packed indices.
pub(super) fn expand(
    info: &Info<'_>,
    header: &Header,
    packed: &[u8],
    context: &mut Context<'_>,
) -> Result<Samples<2>, Problem> {
    let (width, height) = (header.width as usize, header.height as usize);
    let bits = info.bit_depth as u8;
    let unpacked = (info.bit_depth != BitDepth::Eight).then(|| unpack(packed, bits, width, height)).transpose()?;
    let indices = unpacked.as_deref().unwrap_or(packed);
    let colors = info.palette.as_deref().ok_or_else(|| Problem::damaged(Format::Png, "it has no palette"))?;
    let (colors, _) = colors.as_chunks::<3>();
    let alpha = info.trns.as_deref().unwrap_or_default();

    let mut grid = Grid::try_filled(header.domain(), header.channels, 0_u8)?;
    for c in 0..header.channels {
        for (to, &index) in grid.plane_mut(c).iter_mut().zip(indices) {
            let index = usize::from(index);
            *to = if c < 3 { colors.get(index).map_or(0, |rgb| rgb[c]) } else { *alpha.get(index).unwrap_or(&255) };
        }
    }
    let beyond = indices.iter().filter(|i| colors.len() <= usize::from(**i)).count() as u64;
    if 0 < beyond {
        context.warn(Warning::BeyondPalette { count: beyond });
    }
    Ok(Samples::U8(grid))
}
