//! Patches by the sums of their parts, in a tree: what differs in these differs at least so much in its samples.

use std::ops::Range;

use selvedge_core::{Bytes, Domain, reserve, try_vec};

use crate::error::Error;

/// Of so many samples at most, patches are compared by quarters: they rule out more than halves do, and take four times
/// the memory.
const QUARTERED: usize = 1 << 18;

/// The parts of a patch whose sums are compared: quarters along each axis, or halves, without what is left over.
#[derive(Clone, Copy)]
pub(super) struct Parts<const D: usize> {
    /// Their sides.
    shape: [u32; D],
    /// How many lie along each axis.
    count: Domain<D>,
}

impl<const D: usize> Parts<D> {
    /// Of the patches of a shape among so many samples.
    pub(super) fn of(shape: [u32; D], samples: usize) -> Self {
        let most = if D < 3 && samples <= QUARTERED { 4 } else { 2 };
        let side = shape.map(|n| n.div_ceil(most).max(1));
        Self { shape: side, count: Domain::open(std::array::from_fn(|a| shape[a] / side[a])) }
    }

    /// Samples of each.
    pub(super) fn samples(&self) -> usize {
        Domain::open(self.shape).len()
    }

    /// How many a patch has.
    pub(super) fn count(&self) -> usize {
        self.count.len()
    }

    /// The part that a sample of a patch lies in.
    pub(super) fn at(&self, sample: [u32; D]) -> Option<usize> {
        let part = std::array::from_fn(|a| sample[a] / self.shape[a]);
        self.count.contains(part).then(|| self.count.index(part))
    }
}

/// An upper bound of the bytes that patches of sources hold by their parts, as each is made.
pub(super) fn estimate<const D: usize>(sources: &[Domain<D>], channels: usize) -> Bytes {
    let samples: Bytes = sources.iter().map(|source| Bytes::of_samples(*source, 1)).sum();
    // Starts; sums and those before; numbers of two bytes of each part, and half as much for nodes.
    let of_parts = |parts: u64| 4 + channels as u64 * (8 + 3 * parts);
    let quartered = if D < 3 { of_parts(16) } else { 0 };
    samples * of_parts(1 << D) + Bytes((QUARTERED as u64).min(samples.0)) * quartered
}

/// Sums as numbers of 16 bits, so that several are compared at once.
#[derive(Clone)]
pub(super) struct Codes {
    /// Steps that a sum of each channel is worth: 16 for a grey level of the mean where channels weigh most, elsewhere
    /// as many fewer as they weigh less in squares.
    steps: Vec<f64>,
    /// What a square of a step is worth in errors.
    square: f64,
    /// Numbers of a patch.
    width: usize,
}

impl Codes {
    pub(super) fn of<const D: usize>(parts: &Parts<D>, weights: &[u8]) -> Self {
        let most = f64::from(weights.iter().copied().max().unwrap_or(1).max(1));
        let samples = parts.samples() as f64;
        let steps = weights.iter().map(|&w| 16.0 / samples * (f64::from(w) / most).sqrt()).collect();
        Self { steps, square: most * samples / 256.0, width: parts.count() * weights.len() }
    }

    /// At most 4080.
    fn code(&self, sum: u32, channel: usize) -> i16 {
        (f64::from(sum) * self.steps[channel]) as i16
    }

    /// What numbers may differ by, in sums of squares, where samples differ by an error at most: each was rounded by
    /// less than a step.
    pub(super) fn reach(&self, error: u64) -> u64 {
        let apart = (error as f64 / self.square).sqrt() + (self.width as f64).sqrt();
        (apart * apart + 1.0) as u64
    }
}

/// What patches are compared with by their parts.
pub(super) struct Wanted {
    /// Numbers, channel by channel: those of one tell most of what the others do.
    codes: Vec<i16>,
    /// All bits set for those that are compared.
    mask: Vec<i16>,
}

impl Wanted {
    /// Of sums over all parts, channel by channel, of which those parts count that are `known`.
    pub(super) fn new(codes: &Codes, sums: &[u32], known: impl ExactSizeIterator<Item = bool> + Clone) -> Self {
        let (channels, parts) = (codes.steps.len(), known.len());
        let mask = (0..channels).flat_map(|_| known.clone().map(|known| -i16::from(known))).collect();
        let codes = sums.iter().enumerate().map(|(i, &sum)| codes.code(sum, i / parts)).collect();
        Self { codes, mask }
    }

    /// True if a patch's numbers differ by no more than `reach`, as a sum of squares. Most that do not are told by a
    /// few.
    fn is_within(&self, codes: &[i16], reach: u64) -> bool {
        let mut sum = 0;
        let ([codes, own, mask], rest) = parted([codes, &self.codes, &self.mask]);
        for ((codes, own), mask) in codes.iter().zip(own).zip(mask) {
            sum += squares(COMPARED, |i| codes[i].wrapping_sub(own[i]) & mask[i]);
            if reach < sum {
                return false;
            }
        }
        let [codes, own, mask] = rest;
        sum + squares(codes.len(), |i| codes[i].wrapping_sub(own[i]) & mask[i]) <= reach
    }

    /// The least that patches can have within a box.
    fn beyond(&self, low: &[i16], high: &[i16]) -> u64 {
        let out = |low: i16, high: i16, own: i16| low.wrapping_sub(own).max(own.wrapping_sub(high)).max(0);
        let ([lows, highs, own, mask], rest) = parted([low, high, &self.codes, &self.mask]);
        let all = lows.iter().zip(highs).zip(own.iter().zip(mask));
        let whole = all.map(|((low, high), (own, mask))| squares(COMPARED, |i| out(low[i], high[i], own[i]) & mask[i]));
        let [low, high, own, mask] = rest;
        whole.sum::<u64>() + squares(low.len(), |i| out(low[i], high[i], own[i]) & mask[i])
    }
}

/// Numbers in groups of [`COMPARED`], which are compared at once, and what is left over.
fn parted<const N: usize>(of: [&[i16]; N]) -> ([&[[i16; COMPARED]]; N], [&[i16]; N]) {
    let parted = of.map(<[i16]>::as_chunks);
    (parted.map(|(groups, _)| groups), parted.map(|(_, rest)| rest))
}

/// The sum of so many squares, [`COMPARED`] at most: they fit into 31 bits, 4080^2 * 16 < 2^31.
#[inline(always)]
fn squares(count: usize, apart: impl Fn(usize) -> i16) -> u64 {
    let square = |i: usize| i32::from(apart(i)).wrapping_mul(i32::from(apart(i)));
    (0..count).map(square).fold(0, i32::wrapping_add) as u64
}

/// Patches at most of a node without halves.
const LEAF: usize = 32;
/// Patches at most that say along which number others differ most.
const ASKED: usize = 16;
/// Numbers that are compared before it is asked whether more have to be.
const COMPARED: usize = 16;

/// All patches of a source, halved again and again where their parts differ most.
pub(super) struct Tree {
    /// First samples of patches, those that are like each other side by side.
    starts: Vec<u32>,
    /// The numbers of each.
    codes: Vec<i16>,
    /// The least and the greatest numbers of each node: a node, all of its first half, all of its second.
    boxes: Vec<i16>,
    /// The node of each node's second half.
    second: Vec<u32>,
    /// Numbers of a patch.
    width: usize,
}

impl Tree {
    /// Of the patches at `starts`.
    pub(super) fn new(mut starts: Vec<u32>, sums: &Sums) -> Result<Self, Error> {
        let width = sums.offsets.len();
        let mut tree = Self { starts: Vec::new(), codes: Vec::new(), boxes: Vec::new(), second: Vec::new(), width };
        reserve(&mut tree.codes, starts.len() * width)?;
        if !starts.is_empty() {
            tree.grow(&mut starts, sums)?;
        }
        Ok(Self { starts, ..tree })
    }

    /// A node and all below it.
    fn grow(&mut self, starts: &mut [u32], sums: &Sums) -> Result<(), Error> {
        let (node, width) = (self.second.len(), self.width);
        reserve(&mut self.second, 1)?;
        reserve(&mut self.boxes, 2 * width)?;
        self.second.push(0);
        self.boxes.extend(std::iter::repeat_n(i16::MAX, width).chain(std::iter::repeat_n(0, width)));
        if starts.len() <= LEAF {
            let first = self.codes.len();
            self.codes.extend(starts.iter().flat_map(|&start| (0..width).map(move |k| sums.code(start, k))));
            let (low, high) = self.boxes[2 * node * width..].split_at_mut(width);
            for codes in self.codes[first..].chunks_exact(width) {
                low.iter_mut().zip(codes).for_each(|(low, &code)| *low = code.min(*low));
                high.iter_mut().zip(codes).for_each(|(high, &code)| *high = code.max(*high));
            }
            return Ok(());
        }
        let half = starts.len() / 2;
        let widest = sums.widest(starts);
        starts.select_nth_unstable_by_key(half, |&start| sums.code(start, widest));
        let (first, second) = starts.split_at_mut(half);
        self.grow(first, sums)?;
        let other = self.second.len();
        self.second[node] = other as u32;
        self.grow(second, sums)?;
        let (own, below) = self.boxes[2 * node * width..].split_at_mut(2 * width);
        let (low, high) = own.split_at_mut(width);
        for half in [0, other - node - 1] {
            let (least, most) = below[2 * half * width..][..2 * width].split_at(width);
            low.iter_mut().zip(least).for_each(|(low, &code)| *low = code.min(*low));
            high.iter_mut().zip(most).for_each(|(high, &code)| *high = code.max(*high));
        }
        Ok(())
    }

    /// Asks for the patches whose numbers differ by no more than `reach`, the most promising first; `ask` answers with
    /// the reach from then on.
    pub(super) fn search(&self, wanted: &Wanted, reach: &mut u64, ask: &mut impl FnMut(usize) -> u64) {
        if !self.starts.is_empty() {
            self.descend(0, 0..self.starts.len(), wanted, reach, ask);
        }
    }

    fn descend(
        &self,
        node: usize,
        range: Range<usize>,
        wanted: &Wanted,
        reach: &mut u64,
        ask: &mut impl FnMut(usize) -> u64,
    ) {
        if range.len() <= LEAF {
            let codes = self.codes[range.start * self.width..].chunks_exact(self.width);
            for (&start, codes) in self.starts[range].iter().zip(codes) {
                if wanted.is_within(codes, *reach) {
                    *reach = ask(start as usize);
                }
            }
            return;
        }
        let middle = range.start + range.len() / 2;
        let halves = [(node + 1, range.start..middle), (self.second[node] as usize, middle..range.end)];
        let mut halves = halves.map(|(node, range)| {
            let (low, high) = self.boxes[2 * node * self.width..][..2 * self.width].split_at(self.width);
            (wanted.beyond(low, high), node, range)
        });
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (apart, node, range) in halves {
            if apart <= *reach {
                self.descend(node, range, wanted, reach, ask);
            }
        }
    }
}

/// Sums over the parts of the patches of a source.
pub(super) struct Sums<'a> {
    codes: &'a Codes,
    /// Over a part that starts at a value.
    sums: Vec<u32>,
    /// Where each of a patch's sums is, from its first value.
    offsets: Vec<usize>,
}

impl<'a> Sums<'a> {
    /// Of samples one after the other, their channels side by side.
    pub(super) fn new<const D: usize>(
        features: &[u8],
        domain: Domain<D>,
        parts: &Parts<D>,
        codes: &'a Codes,
    ) -> Result<Self, Error> {
        let (channels, strides) = (codes.steps.len(), domain.strides());
        let mut sums = try_vec(features.len(), 0_u32)?;
        sums.iter_mut().zip(features).for_each(|(sum, &value)| *sum = u32::from(value));
        let mut from = try_vec(sums.len(), 0_u32)?;
        for (axis, &stride) in strides.iter().enumerate() {
            // Lines along an axis lie side by side, `by` of them. Parts that reach beyond the end have what there is.
            let (side, part, by) = (domain.shape[axis] as usize, parts.shape[axis] as usize, stride * channels);
            from.copy_from_slice(&sums);
            for first in (0..sums.len()).step_by((side * by).max(1)) {
                for step in (0..side.saturating_sub(1)).rev() {
                    let here = first + step * by;
                    for i in here..here + by {
                        let leaves = if step + part < side { from[i + part * by] } else { 0 };
                        sums[i] = from[i] + sums[i + by] - leaves;
                    }
                }
            }
        }
        let corner = |part: [u32; D]| (0..D).map(|a| (part[a] * parts.shape[a]) as usize * strides[a]).sum::<usize>();
        let of = |c: usize| parts.count.positions().map(move |part| corner(part) * channels + c);
        let offsets = (0..channels).flat_map(of);
        Ok(Self { codes, sums, offsets: offsets.collect() })
    }

    /// A number of the patch at a start.
    fn code(&self, start: u32, number: usize) -> i16 {
        let channels = self.codes.steps.len();
        let channel = number / (self.offsets.len() / channels);
        self.codes.code(self.sums[start as usize * channels + self.offsets[number]], channel)
    }

    /// The number in which some patches differ most.
    fn widest(&self, starts: &[u32]) -> usize {
        let some = starts.iter().step_by(starts.len().div_ceil(ASKED));
        let apart = |number: &usize| {
            let codes = some.clone().map(|&start| self.code(start, *number));
            let (low, high) = codes.fold((i16::MAX, 0), |(low, high), code| (code.min(low), code.max(high)));
            high - low
        };
        (0..self.offsets.len()).max_by_key(apart).unwrap_or(0)
    }
}
