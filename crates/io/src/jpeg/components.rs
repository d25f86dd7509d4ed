//! The components of a frame: their coefficients, their samples, and the picture that they make together.

use selvedge_core::{Grid, try_vec};

use super::frame::Frame;
use super::idct;
use crate::error::Problem;
use crate::header::Header;

/// One component. Sizes are of height and width.
pub(super) struct Component {
    pub(super) id: u8,
    pub(super) factors: [u32; 2],
    /// Its own samples [A.1.1].
    pub(super) size: [u32; 2],
    /// Blocks that hold these, and those that whole units of all components have.
    pub(super) blocks: [u32; 2],
    pub(super) padded: [u32; 2],
    /// Place of its quantization table, and the table itself once its first scan began.
    pub(super) table: u8,
    pub(super) quantization: Option<[u16; 64]>,
    /// Of each coefficient, bits that are still to come; `u8::MAX` if nothing of it came.
    pub(super) missing: [u8; 64],
    /// Block by block, each row by row; only of progressive frames.
    coefficients: Vec<i16>,
    /// Row by row, as wide as its padded blocks.
    samples: Vec<u8>,
}

impl Component {
    pub(super) fn new(id: u8, factors: [u32; 2], most: [u32; 2], shape: [u32; 2], table: u8) -> Self {
        let each = |f: fn(u32, u32, u32) -> u32| [0, 1].map(|axis| f(shape[axis], factors[axis], most[axis]));
        let size = each(|n, factor, most| (n * factor).div_ceil(most));
        Self {
            id,
            factors,
            size,
            blocks: size.map(|n| n.div_ceil(8)),
            padded: each(|n, factor, most| n.div_ceil(8 * most) * factor),
            table,
            quantization: None,
            missing: [u8::MAX; 64],
            coefficients: Vec::new(),
            samples: Vec::new(),
        }
    }

    /// The coefficients of a block, kept until all scans were read. Rows of blocks are made when they are come to.
    pub(super) fn block_mut(&mut self, [y, x]: [u32; 2]) -> Result<&mut [i16; 64], Problem> {
        let stride = self.padded[1] as usize;
        grow(&mut self.coefficients, (y as usize + 1) * stride * 64, self.padded[0] as usize * stride * 64)?;
        let at = (y as usize * stride + x as usize) * 64;
        Ok(self.coefficients[at..].first_chunk_mut().expect("a row of whole blocks"))
    }

    /// Puts the samples of a block into their place.
    pub(super) fn put(&mut self, [y, x]: [u32; 2], block: &[i16; 64]) -> Result<(), Problem> {
        let stride = self.padded[1] as usize * 8;
        grow(&mut self.samples, (y as usize + 1) * 8 * stride, self.padded[0] as usize * 8 * stride)?;
        let table = self.quantization.as_ref().expect("set when the scan began");
        let samples = idct::inverse(&std::array::from_fn(|i| i32::from(block[i]) * i32::from(table[i])));
        let rows = self.samples[y as usize * 8 * stride..].chunks_exact_mut(stride);
        for (row, values) in rows.zip(samples.as_chunks::<8>().0) {
            row[x as usize * 8..][..8].copy_from_slice(values);
        }
        Ok(())
    }

    /// Samples of all coefficients that were kept.
    pub(super) fn finish(&mut self) -> Result<(), Problem> {
        let coefficients = std::mem::take(&mut self.coefficients);
        let stride = self.padded[1] as usize;
        for (i, block) in coefficients.as_chunks::<64>().0.iter().enumerate() {
            self.put([(i / stride) as u32, (i % stride) as u32], block)?;
        }
        Ok(())
    }

    fn row(&self, y: u32) -> &[u8] {
        &self.samples[y as usize * self.padded[1] as usize * 8..][..self.size[1] as usize]
    }
}

/// Makes room for the first `len` of `all` values: memory follows what was read, not what a header claims.
fn grow<T: Copy + Default>(values: &mut Vec<T>, len: usize, all: usize) -> Result<(), Problem> {
    if len <= values.len() {
        return Ok(());
    }
    if values.capacity() < len {
        let more = len.max((2 * values.capacity()).min(all)) - values.len();
        let bytes = (len * size_of::<T>()) as u64;
        values.try_reserve_exact(more).map_err(|_| selvedge_core::Error::Allocation { bytes })?;
    }
    values.resize(len, T::default());
    Ok(())
}

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
/// Where a component has half of the samples, its own are weighed 3 to 1 with their neighbours, as libjpeg does, for the
/// standard says nothing; at any other ratio the sample that covers the place is taken.
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
