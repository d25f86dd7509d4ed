//! Sources packed for the direct kernels: one 32-bit word a position, holding what one instruction multiplies.

use crate::Error;
use crate::extension::Extension;
use crate::source::SourceView;
use selvedge_core::try_vec;

/// Words past the last sample that a kernel may read (and then ignores): the rest of its lanes and of its rows.
pub(crate) const SLACK: usize = 128;

/// How many values a word holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    /// Four bytes.
    Bytes = 4,
    /// Two 16-bit integers.
    Pairs = 2,
}

/// What the lanes of one plane of words hold: `channels` values each of `pixels` neighbours along x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Packing {
    /// The first of its channels.
    pub(crate) first: usize,
    pub(crate) channels: usize,
    pub(crate) pixels: usize,
}

impl Packing {
    /// Fills words with channels first; what remains shares a word with its neighbours along x, so that no lane but
    /// the fourth of three is idle.
    pub(crate) fn of(channels: usize, lanes: Lanes) -> impl Iterator<Item = Self> {
        let width = lanes as usize;
        (0..channels).step_by(width).map(move |first| {
            let channels = (channels - first).min(width);
            Self { first, channels, pixels: width / channels }
        })
    }

    /// Channel and neighbour in each lane.
    pub(crate) fn lanes(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.channels * self.pixels).map(move |lane| (self.first + lane % self.channels, lane / self.channels))
    }
}

/// Value in a lane of a word; `value` fits the lane.
#[inline]
pub(crate) fn in_lane(value: i32, lane: usize, lanes: Lanes) -> u32 {
    match lanes {
        Lanes::Bytes => u32::from(value as u8) << (8 * lane),
        Lanes::Pairs => u32::from(value as u16) << (16 * lane),
    }
}

/// An extended source as words: plane by plane, row-major.
#[derive(Debug)]
pub(crate) struct Packed {
    pub(crate) lanes: Lanes,
    pub(crate) words: Vec<u32>,
    /// Words from one row to the next; planes and frames follow without gaps.
    pub(crate) width: usize,
    /// Words from one plane to the next.
    pub(crate) plane: usize,
}

impl Packed {
    /// Words that a source needs.
    pub(crate) fn len(samples: usize, width: usize, channels: usize, lanes: Lanes) -> usize {
        samples * Packing::of(channels, lanes).count() + 4 * width + SLACK
    }

    pub(crate) fn new(
        source: &SourceView<'_>,
        channels: usize,
        extension: &Extension,
        lanes: Lanes,
    ) -> Result<Self, Error> {
        let (plane, width) = (extension.len(), extension.shape[2]);
        let mut words = try_vec(Self::len(plane, width, channels, lanes), 0_u32)?;
        let (first, columns) = extension.columns();
        for (packing, words) in Packing::of(channels, lanes).zip(words.chunks_mut(plane.max(1))) {
            for (row, from) in extension.rows(source) {
                let words = &mut words[row * width..(row + 1) * width];
                for (lane, (c, pixel)) in packing.lanes().enumerate() {
                    // Left of the first column lie words whose later pixels are inside.
                    let skip = pixel.saturating_sub(first);
                    let to = &mut words[(first + skip).saturating_sub(pixel)..];
                    let row = &source.plane(c)[from..from + source.shape[2]];
                    for (word, &x) in to.iter_mut().zip(&columns[skip.min(columns.len())..]) {
                        if source.is_valid(from + x as usize) {
                            *word |= in_lane(i32::from(row[x as usize]), lane, lanes);
                        }
                    }
                }
            }
        }
        Ok(Self { lanes, words, width, plane })
    }
}
