//! The components of a frame: their coefficients and their samples.

use super::idct;
use crate::error::Problem;

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

    /// A row of its own samples.
    pub(super) fn row(&self, y: u32) -> &[u8] {
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
