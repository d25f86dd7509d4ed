//! Start blocks, what they split into, and their order. `[Ding 3.2]`

use selvedge_core::{Domain, Window};

use crate::options::Layout;

/// No overlap is narrower, however small the block. `[Ding 3.2]`
const LEAST_OVERLAP: u32 = 3;

/// A start block or one of the blocks that it was split into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Its box, which may reach beyond `bounds`.
    nominal: Window<2>,
    /// What of the output there is for it.
    bounds: Window<2>,
    /// Overlap on the low and high sides of each axis.
    pub(crate) overlap: [u32; 2],
    /// Number of the start block.
    pub(crate) number: u64,
    /// The way through the split tree: 1, then two bits a level.
    pub(crate) path: u64,
    /// How often it was split.
    pub(crate) level: usize,
}

impl Block {
    /// What it covers; `None` if nothing.
    pub(crate) fn core(&self) -> Option<Window<2>> {
        self.nominal.shared(&self.bounds)
    }

    /// The four congruent blocks that it splits into, in raster order, two where it is one sample wide; none if it is a
    /// single sample.
    pub(crate) fn split(&self) -> impl Iterator<Item = Self> + use<> {
        let [h, w] = self.nominal.shape;
        let halves = |side: u32| if side == 1 { 1 } else { 2 };
        let (rows, columns) = (halves(h), halves(w));
        let parent = *self;
        (0..rows).flat_map(move |y| (0..columns).map(move |x| (y, x))).filter(move |_| 1 < rows * columns).map(
            move |(y, x)| {
                let shape = [h / rows, w / columns];
                let by = [(y * shape[0]) as i32, (x * shape[1]) as i32];
                Self {
                    nominal: Window { start: parent.nominal.moved(by).start, shape },
                    overlap: parent.overlap.map(|overlap| (overlap / 2).max(LEAST_OVERLAP)),
                    path: parent.path * 4 + u64::from(2 * y + x),
                    level: parent.level + 1,
                    ..parent
                }
            },
        )
    }

    /// Its shorter side.
    pub(crate) fn shortest(&self) -> u32 {
        self.nominal.shape[0].min(self.nominal.shape[1])
    }

    /// True if it is more than a sample.
    pub(crate) fn is_splittable(&self) -> bool {
        self.nominal.shape != [1, 1]
    }
}

/// The overlap of a start block's side, outside of the block: this part of it. `[Ding 3]`
pub(crate) fn overlap_of(side: u32, part: f64) -> u32 {
    ((f64::from(side) * part) as u32).max(LEAST_OVERLAP)
}

/// The largest power of two up to a number.
pub(crate) fn power_of_two(most: u32) -> u32 {
    1 << most.max(1).ilog2()
}

/// A grown block's sides, at most.
pub(crate) fn grown(block: [u32; 2], part: f64) -> [u32; 2] {
    block.map(|side| side + 2 * overlap_of(side, part))
}

/// All start blocks, in raster order. Every sample of the output lies in one of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    output: Domain<2>,
    block: [u32; 2],
    layout: Layout,
    overlap: f64,
}

impl Blocks {
    pub(crate) fn new(output: Domain<2>, block: [u32; 2], (layout, overlap): (Layout, f64)) -> Self {
        Self { output, block, layout, overlap }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Block> + use<> {
        let blocks = *self;
        let Self { output, block, layout, overlap } = blocks;
        let rows = output.shape[0].div_ceil(block[0]);
        (0..rows).flat_map(move |row| {
            let half = if layout == Layout::Brick && row % 2 == 1 { (block[1] / 2) as i32 } else { 0 };
            // The row begins inside and goes around, or before.
            let first = if output.periodic[1] { half } else { -half };
            let columns = (output.shape[1] as i32 - first.min(0)) as u32;
            let columns = columns.div_ceil(block[1]);
            (0..columns).map(move |column| {
                let (down, across) = (blocks.along(0, row, rows, 0), blocks.along(1, column, columns, first));
                Block {
                    nominal: Window { start: [down.0, across.0], shape: block },
                    bounds: Window { start: [down.1, across.1], shape: [down.2, across.2] },
                    overlap: block.map(|side| overlap_of(side, overlap)),
                    number: u64::from(row) << 32 | u64::from(column),
                    path: 1,
                    level: 0,
                }
            })
        })
    }

    /// Where one of so many blocks along an axis starts, and where what there is for it begins and how long that is.
    /// Around a periodic axis all are about as wide: a narrow last one would have to agree with two sides at once.
    fn along(&self, axis: usize, number: u32, of: u32, first: i32) -> (i32, i32, u32) {
        let side = self.output.shape[axis];
        if !self.output.periodic[axis] {
            return (first + (number * self.block[axis]) as i32, 0, side);
        }
        let [start, end] = [number, number + 1].map(|n| (u64::from(n) * u64::from(side) / u64::from(of)) as u32);
        (first + start as i32, first + start as i32, end - start)
    }

    /// How many.
    pub(crate) fn len(&self) -> u64 {
        let [rows, columns] = [0, 1].map(|a| u64::from(self.output.shape[a].div_ceil(self.block[a])));
        let moved = match self.layout {
            Layout::Brick if !self.output.periodic[1] => {
                let more = (self.output.shape[1] + self.block[1] / 2).div_ceil(self.block[1]);
                (rows / 2) * (u64::from(more) - columns)
            }
            _ => 0,
        };
        rows * columns + moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts how often blocks and all that they split into cover each sample, level by level.
    fn covered(output: Domain<2>, blocks: Vec<Block>) -> Vec<u32> {
        let mut covered = vec![0; output.len()];
        for core in blocks.iter().filter_map(Block::core) {
            core.places(output).for_each(|place| covered[place.expect("inside")] += 1);
        }
        covered
    }

    #[test]
    fn at_every_level_every_sample_lies_in_one_block() {
        for (shape, block) in [([40, 37], [8, 8]), ([5, 3], [32, 32]), ([33, 64], [16, 32]), ([9, 70], [2, 16])] {
            for periodic in [[false, false], [false, true], [true, true]] {
                for layout in [Layout::Grid, Layout::Brick] {
                    let output = Domain { shape, periodic };
                    let blocks = Blocks::new(output, block, (layout, 0.2));
                    let mut level: Vec<Block> = blocks.iter().collect();
                    assert_eq!(level.len() as u64, blocks.len(), "{output:?} {layout:?}");
                    while !level.is_empty() {
                        assert!(covered(output, level.clone()).iter().all(|&n| n == 1), "{output:?} {block:?}");
                        level = level.iter().flat_map(Block::split).collect();
                    }
                }
            }
        }
    }

    #[test]
    fn blocks_around_an_axis_are_about_as_wide() {
        let output = Domain { shape: [64, 260], periodic: [false, true] };
        for layout in [Layout::Grid, Layout::Brick] {
            let blocks = Blocks::new(output, [32, 32], (layout, 0.2)).iter();
            let widths: Vec<u32> = blocks.map(|block| block.core().unwrap().shape[1]).collect();
            assert!(widths.iter().all(|width| (28..30).contains(width)), "{layout:?}: {widths:?}");
        }
    }

    #[test]
    fn overlaps_are_a_fifth_and_halve_down_to_three() {
        let block = Blocks::new(Domain::open([64, 64]), [64, 32], (Layout::Grid, 0.2)).iter().next().unwrap();
        assert_eq!((block.overlap, block.level), ([12, 6], 0));
        let mut overlaps = Vec::new();
        let mut next = Some(block);
        while let Some(block) = next {
            overlaps.push(block.overlap);
            next = block.split().last();
        }
        assert_eq!(overlaps, [[12, 6], [6, 3], [3, 3], [3, 3], [3, 3], [3, 3], [3, 3]]);
    }

    #[test]
    fn ways_through_the_split_tree_differ() {
        let block = Blocks::new(Domain::open([16, 8]), [16, 8], (Layout::Grid, 0.2)).iter().next().unwrap();
        let (mut ways, mut level) = (vec![block.path], vec![block]);
        while !level.is_empty() {
            level = level.iter().flat_map(Block::split).collect();
            ways.extend(level.iter().map(|b| b.path));
        }
        let all = ways.len();
        ways.sort_unstable();
        ways.dedup();
        assert_eq!(ways.len(), all);
    }
}
