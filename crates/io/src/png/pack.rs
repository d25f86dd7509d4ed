//! A picture's rows as the zlib stream of a PNG, packed in bands on all threads.
//!
//! A band is packed by itself and ends on a whole byte, so that bands only have to be joined. Where bands end follows
//! from the picture's width: the bytes are the same on any number of threads.

use std::io;

use flate2::{Compress, Compression, FlushCompress};
use selvedge_core::par;
use simd_adler32::Adler32;

/// About as many bytes of rows make a band; of smaller ones, more could not be matched with what came before.
const BAND: usize = 1 << 17;
/// Of 1024x1024 px of woven radishes this level makes 1.89 MB in 30 ms on one thread; the usual 6 makes 1.65 MB in 100
/// ms.
const LEVEL: u32 = 1;
/// About as many bytes as one packer keeps, as a test sees it: its window, and tables of what came before.
const PACKER: usize = 400 << 10;
/// What a stream of 32 KiB windows begins with.
const HEADER: [u8; 2] = [0x78, 0x01];

/// Rows of one size.
pub(super) struct Rows<F> {
    pub(super) count: usize,
    /// Bytes of a row.
    pub(super) bytes: usize,
    /// Bytes of a pixel.
    pub(super) pixel: usize,
    /// Writes row `y`.
    pub(super) read: F,
}

/// About how many bytes packing so many rows of so many bytes takes at once, beside what it hands over.
pub(crate) fn packing_room(count: usize, bytes: usize) -> usize {
    let rows = BAND.div_ceil(bytes.max(1)).min(count).max(1);
    let band = rows.saturating_mul(bytes.saturating_add(1));
    // Filtered, and packed, where no bytes take an eighth more; and two rows as they were read.
    let one = band.saturating_mul(2).saturating_add(band / 8 + PACKER).saturating_add(bytes.saturating_mul(2));
    one.saturating_mul(at_once().min(count.div_ceil(rows)))
}

impl<F: Fn(usize, &mut [u8]) + Sync> Rows<F> {
    /// About how many bytes packing takes at once, beside what it hands over.
    pub(super) fn room(&self) -> usize {
        packing_room(self.count, self.bytes)
    }

    /// Hands over the parts of the stream, in order.
    pub(super) fn pack<E: From<io::Error>>(&self, mut part: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        part(&HEADER)?;
        let rows = BAND.div_ceil(self.bytes.max(1));
        let bands = self.count.div_ceil(rows);
        let mut sum = Adler32::new();
        let at_once = at_once();
        for first in (0..bands).step_by(at_once) {
            let band = |i: usize| self.band((first + i) * rows, rows);
            for band in par::map_indexed(at_once.min(bands - first), band) {
                let (filtered, packed) = band?;
                sum.write(&filtered);
                part(&packed)?;
            }
        }
        part(&sum.finish().to_be_bytes())
    }

    /// Rows from one on, filtered, and packed.
    fn band(&self, first: usize, rows: usize) -> io::Result<(Vec<u8>, Vec<u8>)> {
        let end = self.count.min(first + rows);
        let mut filtered = fallible((end - first) * (1 + self.bytes))?;
        let mut two = fallible(2 * self.bytes)?;
        two.resize(2 * self.bytes, 0);
        let (mut above, mut row) = two.split_at_mut(self.bytes);
        if let Some(before) = first.checked_sub(1) {
            (self.read)(before, above);
        }
        for y in first..end {
            (self.read)(y, row);
            filtered.push(4);
            paeth(above, row, self.pixel, &mut filtered);
            (above, row) = (row, above);
        }
        let flush = if end == self.count { FlushCompress::Finish } else { FlushCompress::Sync };
        let packed = deflate(&filtered, flush)?;
        Ok((filtered, packed))
    }
}

/// As many bands as keep all threads busy: they take memory.
fn at_once() -> usize {
    2 * par::threads()
}

/// Appends what is left of a row after its prediction from the left, from above, and from above on the left, whichever
/// is nearest to left + above - above left: the filter of type 4.
fn paeth(above: &[u8], row: &[u8], pixel: usize, to: &mut Vec<u8>) {
    let first = pixel.min(row.len());
    // Nothing is left of the first pixel: above is what is nearest.
    to.extend(row[..first].iter().zip(above).map(|(v, above)| v.wrapping_sub(*above)));
    let left = row.iter().zip(above);
    to.extend(row[first..].iter().zip(&above[first..]).zip(left).map(|((&v, &b), (&a, &c))| {
        let (to_a, to_b) = (i16::from(b) - i16::from(c), i16::from(a) - i16::from(c));
        let (a_off, b_off, c_off) = (to_a.abs(), to_b.abs(), (to_a + to_b).abs());
        let a_or_b = if a_off <= b_off { a } else { b };
        v.wrapping_sub(if a_off.min(b_off) <= c_off { a_or_b } else { c })
    }));
}

fn deflate(bytes: &[u8], flush: FlushCompress) -> io::Result<Vec<u8>> {
    let mut packer = Compress::new(Compression::new(LEVEL), false);
    // No bytes take more room.
    let mut packed = fallible(bytes.len() + bytes.len() / 8 + 128)?;
    packer.compress_vec(bytes, &mut packed, flush).map_err(io::Error::other)?;
    if packer.total_in() != bytes.len() as u64 || packed.len() == packed.capacity() {
        return Err(io::Error::other("rows took more room packed than they may"));
    }
    Ok(packed)
}

/// An empty buffer with room.
fn fallible(bytes: usize) -> io::Result<Vec<u8>> {
    let mut buffer = Vec::new();
    buffer.try_reserve_exact(bytes).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    Ok(buffer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    /// Bytes of no pattern, and ones of patterns: all that a row can hold.
    fn value(y: usize, i: usize) -> u8 {
        let hash = (y as u32).wrapping_mul(0x9e37_79b9) ^ (i as u32).wrapping_mul(0x85eb_ca6b);
        if y.is_multiple_of(3) { (hash.wrapping_mul(0xc2b2_ae35) >> 24) as u8 } else { (y * 3 + i) as u8 }
    }

    /// The filter as the standard has it.
    fn undone(filtered: &[u8], rows: &Rows<impl Fn(usize, &mut [u8]) + Sync>) -> Vec<u8> {
        let (n, pixel) = (rows.bytes, rows.pixel);
        let mut all = vec![0_u8; rows.count * n];
        for (y, row) in filtered.chunks(n + 1).enumerate() {
            assert_eq!(row[0], 4);
            for i in 0..n {
                let at = |up: usize, left: usize| {
                    if up <= y && left <= i { i32::from(all[(y - up) * n + i - left]) } else { 0 }
                };
                let (a, b, c) = (at(0, pixel), at(1, 0), at(1, pixel));
                let p = a + b - c;
                let nearest = [a, b, c].into_iter().min_by_key(|v| (p - v).abs()).unwrap_or(0);
                all[y * n + i] = row[1 + i].wrapping_add(nearest as u8);
            }
        }
        all
    }

    /// What a write asks for is what its bands take, or little more.
    #[test]
    fn the_room_asked_for_holds_the_bands_of_all_threads() {
        for (count, bytes) in [(2, 10), (3000, 90), (500, 3 << 10), (4, 1 << 20)] {
            let rows = Rows { count, bytes, pixel: 3, read: |_, row: &mut [u8]| row.fill(7) };
            let (filtered, packed) = rows.band(0, BAND.div_ceil(bytes)).unwrap();
            let held = filtered.capacity() + packed.capacity() + 2 * bytes;
            let asked = rows.room() / at_once();
            assert!(held <= asked && asked <= 2 * held + PACKER, "{count} rows of {bytes}: {held} held, {asked} asked");
        }
    }

    #[test]
    fn the_stream_holds_the_rows() {
        for (count, pixels, pixel) in
            [(1, 1, 1), (1, 300, 3), (300, 1, 8), (500, 333, 3), (3, 70_000, 2), (1000, 131, 6)]
        {
            let read = |y: usize, row: &mut [u8]| row.iter_mut().enumerate().for_each(|(i, v)| *v = value(y, i));
            let rows = Rows { count, bytes: pixels * pixel, pixel, read };
            let mut stream = Vec::new();
            rows.pack::<io::Error>(|part| {
                stream.extend_from_slice(part);
                Ok(())
            })
            .unwrap();
            let mut filtered = Vec::new();
            flate2::read::ZlibDecoder::new(&stream[..]).read_to_end(&mut filtered).expect("right sum");
            let expected: Vec<u8> = (0..count).flat_map(|y| (0..rows.bytes).map(move |i| value(y, i))).collect();
            assert!(undone(&filtered, &rows) == expected, "{count} rows of {pixels} px of {pixel} bytes");
        }
    }
}
