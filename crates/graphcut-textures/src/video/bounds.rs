//! Frames of which few are compared: what differs little can only be where means of boxes do.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use selvedge_core::{Bytes, Domain, Error as CoreError, Source, par, reserve};

/// Sides of the boxes.
const BOX: u32 = 8;

/// A clip of frames that are compared when they are asked for.
#[derive(Clone, Debug)]
pub(super) struct Bounded<'c> {
    pub(super) clip: &'c Source<3>,
    pub(super) weights: &'c [u8],
    /// By frame, channel and box, sums of what it holds.
    sums: Vec<u16>,
    /// Sums of a frame.
    of_frame: usize,
}

impl<'c> Bounded<'c> {
    /// The bytes of the sums: two a box and channel.
    pub(super) fn bytes(clip: Domain<3>, channels: usize) -> Bytes {
        let [frames, height, width] = clip.shape;
        let boxes = Domain::open([frames, height.div_ceil(BOX), width.div_ceil(BOX)]);
        Bytes::of_samples(boxes, 2 * channels as u64)
    }

    /// Of a clip without a mask.
    pub(super) fn new(clip: &'c Source<3>, weights: &'c [u8]) -> Self {
        let [frames, height, width] = clip.domain().shape;
        let (columns, rows) = (width.div_ceil(BOX) as usize, height.div_ceil(BOX) as usize);
        let pixels = height as usize * width as usize;
        let of_frame = |t: usize| -> Vec<u16> {
            let mut sums = vec![0; rows * columns * weights.len()];
            for (c, sums) in sums.chunks_mut(rows * columns).enumerate() {
                let frame = &clip.features.plane(c)[t * pixels..][..pixels];
                for (y, row) in frame.chunks(width as usize).enumerate() {
                    let sums = &mut sums[y / BOX as usize * columns..][..columns];
                    let boxes = row.chunks(BOX as usize).map(|part| part.iter().map(|&v| u16::from(v)).sum::<u16>());
                    sums.iter_mut().zip(boxes).for_each(|(sum, more)| *sum += more);
                }
            }
            sums
        };
        let sums = par::map_indexed(frames as usize, of_frame).concat();
        Self { clip, weights, sums, of_frame: rows * columns * weights.len() }
    }

    /// No more than two frames differ by: of samples whose sums differ by `d`, the squares of differences add up to
    /// `d^2 / n` or more, where a box has `n`, and none has more than a whole one.
    fn least(&self, a: u32, b: u32) -> u64 {
        let [a, b] = [a, b].map(|t| &self.sums[t as usize * self.of_frame..][..self.of_frame]);
        let boxes = (self.of_frame / self.weights.len().max(1)).max(1);
        let of = |(a, b): (&[u16], &[u16])| -> u64 {
            a.iter().zip(b).map(|(&a, &b)| u64::from(u32::from(a.abs_diff(b)).pow(2))).sum()
        };
        let channels = a.chunks(boxes).zip(b.chunks(boxes)).zip(self.weights);
        channels.map(|(both, &weight)| of(both) * u64::from(weight)).sum::<u64>() / u64::from(BOX * BOX)
    }

    /// Least differences of each frame and all later ones.
    pub(super) fn all(&self) -> Vec<Vec<u64>> {
        let frames = self.clip.domain().shape[0];
        par::map_indexed(frames as usize, |i| (i as u32 + 1..frames).map(|j| self.least(i as u32, j)).collect())
    }
}

/// What comes out in order of its value, which is looked at only where a bound says that it may be the next.
pub(super) struct Ordered<T> {
    heap: BinaryHeap<Entry<T>>,
}

/// The least first; of equal ones a bound, then the lesser one.
struct Entry<T> {
    value: f64,
    exact: bool,
    what: T,
}

impl<T: Ord> Ord for Entry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_value = other.value.total_cmp(&self.value);
        by_value.then_with(|| other.exact.cmp(&self.exact)).then_with(|| other.what.cmp(&self.what))
    }
}

impl<T: Ord> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Ord> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T: Ord> Eq for Entry<T> {}

impl<T: Ord> Ordered<T> {
    /// Of what has these bounds, or values, so many at most.
    pub(super) fn new(most: usize, bounds: impl Iterator<Item = (f64, T)>) -> Result<Self, CoreError> {
        let mut entries = Vec::new();
        reserve(&mut entries, most)?;
        entries.extend(bounds.map(|(value, what)| Entry { value, exact: false, what }));
        Ok(Self { heap: entries.into() })
    }

    /// The next one that counts, by its value.
    pub(super) fn next<E>(
        &mut self,
        counts: impl Fn(&T) -> bool,
        mut value: impl FnMut(&T) -> Result<f64, E>,
    ) -> Result<Option<(f64, T)>, E> {
        while let Some(entry) = self.heap.pop() {
            if !counts(&entry.what) {
                continue;
            }
            if entry.exact {
                return Ok(Some((entry.value, entry.what)));
            }
            self.heap.push(Entry { value: value(&entry.what)?, exact: true, what: entry.what });
        }
        Ok(None)
    }
}
