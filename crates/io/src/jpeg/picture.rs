//! The picture that the components of a frame make together.

use selvedge_core::{Grid, try_vec};

use super::components::Component;
use super::frame::Frame;
use crate::error::Problem;
use crate::header::Header;

/// How components become channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Colors {
    AsStored,
    YCbCr,
    /// As everyone stores it: 255 is no ink.
    Cmyk,
    Ycck,
}

/// The picture of the frame's components.
pub(super) fn picture(frame: &Frame, colors: Colors, header: &Header) -> Result<Grid<u8, 2>, Problem> {
    let width = frame.width as usize;
    let mut grid = Grid::try_filled(header.domain(), header.channels, 0_u8)?;
    let mut rows = try_vec(width * frame.components.len(), 0_u8)?;
    let mut sums = try_vec(width + 1, 0_u16)?;
    for y in 0..frame.height {
        for (component, row) in frame.components.iter().zip(rows.chunks_exact_mut(width)) {
            upsample(component, frame.most, y, &mut sums, row);
        }
        let rows: Vec<&[u8]> = rows.chunks_exact(width).collect();
        let start = y as usize * width;
        if colors == Colors::AsStored {
            (0..header.channels).for_each(|c| grid.plane_mut(c)[start..][..width].copy_from_slice(rows[c]));
            continue;
        }
        let color = |x: usize| match colors {
            Colors::Cmyk => [0, 1, 2].map(|c| over(rows[c][x], rows[3][x])),
            Colors::Ycck => rgb([0, 1, 2].map(|c| rows[c][x])).map(|v| over(255 - v, rows[3][x])),
            _ => rgb([0, 1, 2].map(|c| rows[c][x])),
        };
        (0..width).for_each(|x| {
            let values = color(x);
            (0..3).for_each(|c| grid.plane_mut(c)[start + x] = values[c]);
        });
    }
    Ok(grid)
}

/// RGB of YCbCr, in 16 bits of each factor [JFIF 1.02].
fn rgb([y, cb, cr]: [u8; 3]) -> [u8; 3] {
    let (y, cb, cr) = (i32::from(y) << 16 | 1 << 15, i32::from(cb) - 128, i32::from(cr) - 128);
    [y + 91_881 * cr, y - 22_554 * cb - 46_802 * cr, y + 116_130 * cb].map(|v| (v >> 16).clamp(0, 255) as u8)
}

/// What an ink lets pass, over black that lets pass so much.
fn over(ink: u8, black: u8) -> u8 {
    ((u32::from(ink) * u32::from(black) + 127) / 255) as u8
}

/// One row of a component in the size of the picture.
///
/// Where a component has half of the samples, its own are weighed 3 to 1 with their neighbours, as libjpeg does, for
/// the standard says nothing; at any other ratio the sample that covers the place is taken.
fn upsample(component: &Component, most: [u32; 2], y: u32, sums: &mut [u16], to: &mut [u8]) {
    let [down, across] = [0, 1].map(|axis| most[axis] == 2 * component.factors[axis]);
    let same = [0, 1].map(|axis| most[axis] == component.factors[axis]);
    let covering = |at: u32, axis: usize| (2 * at + 1) * component.factors[axis] / (2 * most[axis]);
    let near = component.row(covering(y, 0));
    let last = component.size[0] - 1;
    let other = if y.is_multiple_of(2) { (y / 2).saturating_sub(1) } else { (y / 2 + 1).min(last) };
    let odd = u16::from(!y.is_multiple_of(2));
    match (down, across) {
        (true, _) if same[1] => {
            for ((to, near), far) in to.iter_mut().zip(near).zip(component.row(other)) {
                *to = ((3 * u16::from(*near) + u16::from(*far) + 1 + odd) / 4) as u8;
            }
        }
        (true, true) if 2 < near.len() => {
            let far = component.row(other);
            sums.iter_mut().zip(near.iter().zip(far)).for_each(|(s, (n, f))| *s = 3 * u16::from(*n) + u16::from(*f));
            between(&sums[..near.len()], [8, 7], 4, to);
        }
        (_, true) if same[0] && 2 < near.len() => {
            sums.iter_mut().zip(near).for_each(|(s, n)| *s = u16::from(*n));
            between(&sums[..near.len()], [1, 2], 2, to);
        }
        _ if same[1] => to.copy_from_slice(&near[..to.len()]),
        _ => (0..).zip(to).for_each(|(x, to)| *to = near[covering(x, 1) as usize]),
    }
}

/// Two values of each: three parts of it and one of its neighbour. Rounding alternates, so that it does not drift.
fn between(from: &[u16], round: [u16; 2], shift: u32, to: &mut [u8]) {
    for (x, to) in to.iter_mut().enumerate() {
        let (at, side) = (x / 2, x % 2);
        let neighbour = if side == 0 { at.saturating_sub(1) } else { (at + 1).min(from.len() - 1) };
        *to = ((3 * from[at] + from[neighbour] + round[side]) >> shift) as u8;
    }
}
