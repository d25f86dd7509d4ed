//! Where blocks lie in the output, and how far each overlaps what is there already.

use selvedge_core::{Domain, Window};

/// A block's extent along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// First sample.
    pub(crate) start: u32,
    /// Samples; blocks at an open border are cropped. On a periodic axis it may reach over the end.
    pub(crate) len: u32,
    /// Samples shared with the block before.
    pub(crate) before: u32,
    /// Samples shared with the first block, where the ring closes.
    pub(crate) after: u32,
}

/// The blocks along one axis, at least `overlap` samples of each on the next. `[Efros01 2.2]`
///
/// An open axis steps by `block - overlap` and crops the last block. A periodic axis has two blocks at least, so that
/// each meets another at both ends, and spreads what does not fit by widening the overlaps. Where the two overlaps of
/// a block would then meet, the blocks are shortened, down to what the overlap asked for needs.
pub(crate) fn spans(len: u32, periodic: bool, block: u32, overlap: u32) -> Vec<Span> {
    let step = (block - overlap).max(1);
    if !periodic {
        let n = len.saturating_sub(overlap).div_ceil(step).max(1);
        return (0..n)
            .map(|i| Span {
                start: i * step,
                len: block.min(len - i * step),
                before: if i == 0 { 0 } else { overlap.min(len - i * step) },
                after: 0,
            })
            .collect();
    }
    // One sample is its own neighbour, whatever it is.
    let n = len.div_ceil(step).max(len.min(2));
    if n == 1 {
        return vec![Span { start: 0, len, before: 0, after: 0 }];
    }
    let start = |i: u32| (u64::from(i) * u64::from(len) / u64::from(n)) as u32;
    // A block's overlaps have room if it reaches no further than to the block after the next.
    let step_after = |i: u32| start(i + 1) - start(i);
    let room = (0..n).map(|i| step_after(i) + step_after((i + 1) % n)).min().unwrap_or(len);
    let block = if block <= room { block } else { room.min(len.div_ceil(n) + overlap) };
    let mut spans: Vec<Span> = (0..n)
        .map(|i| Span {
            start: start(i),
            len: block,
            before: if i == 0 { 0 } else { start(i - 1) + block - start(i) },
            after: 0,
        })
        .collect();
    spans[n as usize - 1].after = start(n - 1) + block - len;
    spans
}

/// One block: a window of the output, and the strips on which it meets what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Vertical extent.
    pub(crate) rows: Span,
    /// Horizontal extent.
    pub(crate) columns: Span,
}

impl Block {
    /// Height and width.
    pub(crate) fn shape(&self) -> [u32; 2] {
        [self.rows.len, self.columns.len]
    }

    /// True where the block lies on what was laid before it.
    pub(crate) fn is_overlap(&self, [y, x]: [u32; 2]) -> bool {
        let inside = |span: &Span, p: u32| span.before <= p && p < span.len - span.after;
        !(inside(&self.rows, y) && inside(&self.columns, x))
    }

    /// Where it lies in the output.
    pub(crate) fn window(&self) -> Window<2> {
        Window { start: [self.rows.start as i32, self.columns.start as i32], shape: self.shape() }
    }

    /// The steps from this block's first sample to another's; the shorter way round on periodic axes.
    pub(crate) fn way_to(&self, output: Domain<2>, to: &Self) -> [i64; 2] {
        let way = |axis: usize, from: u32, to: u32| {
            let (d, side) = (i64::from(to) - i64::from(from), i64::from(output.shape[axis]));
            if output.periodic[axis] { (d + side / 2).rem_euclid(side) - side / 2 } else { d }
        };
        [way(0, self.rows.start, to.rows.start), way(1, self.columns.start, to.columns.start)]
    }
}

/// All blocks of an output, numbered in raster order. `[Efros01 2.2]`
#[derive(Clone, Debug)]
pub(crate) struct BlockGrid {
    periodic: [bool; 2],
    rows: Vec<Span>,
    columns: Vec<Span>,
}

impl BlockGrid {
    pub(crate) fn new(output: Domain<2>, block: u32, overlap: u32) -> Self {
        let rows = spans(output.shape[0], output.periodic[0], block, overlap);
        let columns = spans(output.shape[1], output.periodic[1], block, overlap);
        Self { periodic: output.periodic, rows, columns }
    }

    /// Blocks in all.
    pub(crate) fn len(&self) -> usize {
        self.rows.len() * self.columns.len()
    }

    /// How many waves there are, at least one.
    ///
    /// The blocks of a wave neither touch nor follow from each other: all that a block agrees with was laid in waves
    /// before, as it would be in raster order. A block also meets the one above on its right, so row `i` stays two
    /// blocks behind row `i - 1`: its block `j` is in wave `2 i + j`. Where columns close to a ring, a row's first
    /// block meets the last one of the row above, and every wave is one block.
    pub(crate) fn waves(&self) -> usize {
        if self.periodic[1] { self.len() } else { 2 * (self.rows.len() - 1) + self.columns.len() }
    }

    /// Blocks of the longest wave, or a few more.
    pub(crate) fn longest_wave(&self) -> usize {
        if self.periodic[1] { 1 } else { self.rows.len().min(self.columns.len().div_ceil(2)) }
    }

    /// All shapes of blocks, each with the numbers of samples on its overlaps, of which there are few.
    pub(crate) fn templates(&self) -> Vec<([u32; 2], u64)> {
        let kinds = |spans: &[Span]| {
            let mut kinds: Vec<(u32, u32)> = spans.iter().map(|s| (s.len, (s.before + s.after).min(s.len))).collect();
            kinds.sort_unstable();
            kinds.dedup();
            kinds
        };
        let columns = kinds(&self.columns);
        let of = |(height, above): (u32, u32), (width, beside): (u32, u32)| {
            let free = u64::from(height - above) * u64::from(width - beside);
            ([height, width], u64::from(height) * u64::from(width) - free)
        };
        kinds(&self.rows).into_iter().flat_map(|row| columns.iter().map(move |&column| of(row, column))).collect()
    }

    /// The blocks of a wave, in raster order.
    pub(crate) fn wave(&self, wave: usize) -> impl Iterator<Item = usize> + use<> {
        let (rows, columns) = (self.rows.len(), self.columns.len());
        let ring = self.periodic[1].then_some(wave);
        let first = (wave + 1).saturating_sub(columns).div_ceil(2);
        let last = if ring.is_some() { 0 } else { rows.min(wave / 2 + 1) };
        ring.into_iter().chain((first..last).map(move |i| i * columns + wave - 2 * i))
    }

    /// Block number `number`.
    pub(crate) fn block(&self, number: usize) -> Block {
        let n = self.columns.len();
        Block { rows: self.rows[number / n], columns: self.columns[number % n] }
    }

    /// The blocks next to a block, diagonally as well, that come before it.
    pub(crate) fn neighbors(&self, number: usize) -> impl Iterator<Item = usize> {
        let (n_rows, n_columns) = (self.rows.len(), self.columns.len());
        let rows = beside(number / n_columns, n_rows, self.periodic[0]);
        let columns = beside(number % n_columns, n_columns, self.periodic[1]);
        let all = rows.into_iter().flat_map(move |i| columns.into_iter().map(move |j| Some(i? * n_columns + j?)));
        all.flatten().filter(move |&neighbor| neighbor < number)
    }
}

/// An index, the one before and the one after, round the end where the axis is periodic.
fn beside(i: usize, n: usize, periodic: bool) -> [Option<usize>; 3] {
    let before = i.checked_sub(1).or(periodic.then_some(n - 1));
    let after = Some(i + 1).filter(|&i| i < n).or(periodic.then_some(0));
    [Some(i), before, after]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_axes_crop_the_last_block() {
        let s = spans(20, false, 8, 2);
        assert_eq!(
            s.iter().map(|s| (s.start, s.len, s.before)).collect::<Vec<_>>(),
            [(0, 8, 0), (6, 8, 2), (12, 8, 2)]
        );
        let s = spans(21, false, 8, 2);
        assert_eq!(s[3], Span { start: 18, len: 3, before: 2, after: 0 });
        assert_eq!(spans(3, false, 8, 2), [Span { start: 0, len: 3, before: 0, after: 0 }]);
    }

    #[test]
    fn every_axis_is_covered_once() {
        for periodic in [false, true] {
            for (len, block) in (1..60).flat_map(|l| (1..20).map(move |b| (l, b))) {
                for overlap in 0..=block / 2 {
                    check(len, periodic, block, overlap);
                }
            }
        }
    }

    #[test]
    fn overlaps_are_what_was_laid_before() {
        for (periodic, shape) in [([false; 2], [23, 31]), ([true, false], [20, 24]), ([true; 2], [30, 17])] {
            let output = Domain { shape, periodic };
            let grid = BlockGrid::new(output, 9, 3);
            let mut laid = vec![false; output.len()];
            for block in (0..grid.len()).map(|number| grid.block(number)) {
                let places =
                    block.window().places(output).map(|place| place.expect("blocks end where the output does"));
                let places: Vec<_> = block.window().local().positions().zip(places).collect();
                assert!(places.iter().all(|&(p, at)| block.is_overlap(p) == laid[at]));
                places.iter().for_each(|&(_, at)| laid[at] = true);
            }
            assert!(laid.iter().all(|&l| l));
        }
    }

    #[test]
    fn waves_hold_every_block_once_after_all_that_it_meets() {
        for (output, block, overlap) in
            [([50, 60], 9, 3), ([9, 60], 9, 3), ([70, 9], 8, 4), ([33, 41], 8, 4), ([5, 5], 9, 2)]
        {
            for periodic in [[false, false], [true, false], [false, true], [true, true]] {
                let domain = Domain { shape: output, periodic };
                let grid = BlockGrid::new(domain, block, overlap);
                let mut wave_of = vec![None; grid.len()];
                let mut owner = vec![None; domain.len()];
                for wave in 0..grid.waves() {
                    let numbers: Vec<usize> = grid.wave(wave).collect();
                    assert!(numbers.is_sorted());
                    for &number in &numbers {
                        assert_eq!(wave_of[number].replace(wave), None, "{number} twice");
                        assert!(grid.neighbors(number).all(|n| wave_of[n].is_some_and(|w| w < wave)), "{number}");
                        let block = grid.block(number);
                        for at in block.window().places(domain).flatten() {
                            assert!(owner[at].replace(wave) != Some(wave), "blocks of wave {wave} touch");
                        }
                    }
                }
                assert!(wave_of.iter().all(Option::is_some), "{output:?} {periodic:?}");
            }
        }
    }

    fn check(len: u32, periodic: bool, block: u32, overlap: u32) {
        let mut filled = vec![0_u32; len as usize];
        let all = spans(len, periodic, block, overlap);
        let closed = all.last().is_some_and(|last| 0 < last.after);
        assert!(closed == (periodic && 1 < len && 0 < overlap) || overlap == 0, "{len} {block} {overlap}");
        for span in all {
            let at = |i: u32| ((span.start + i) % len) as usize;
            let shared = (0..span.len).filter(|&i| filled[at(i)] != 0).count() as u32;
            assert_eq!(shared, span.before + span.after, "{len} {periodic} {block} {overlap} {span:?}");
            assert!((0..span.before).all(|i| filled[at(i)] != 0));
            assert!((0..span.after).all(|i| filled[at(span.len - 1 - i)] != 0));
            assert!(periodic || shared < span.len, "each block adds something");
            assert!(periodic || span.start + span.len <= len);
            assert!(span.before + span.after <= span.len, "{len} {periodic} {block} {overlap} {span:?}");
            if periodic && 1 < len && 0 < overlap {
                // Every block but the first meets the one before.
                assert!((span.start == 0) == (span.before == 0), "{len} {block} {overlap} {span:?}");
            }
            (0..span.len).for_each(|i| filled[at(i)] += 1);
        }
        assert!(filled.iter().all(|&n| n != 0));
    }
}
