//! Templates as lists of multiplications for the direct kernels.
//!
//! A kernel computes four rows of positions at once, so that a loaded image vector serves up to four template rows. Row
//! `y` of the image meets output row `o` through template row `y - o`: a [`Phase`] lists the taps of all image rows
//! that serve the same output rows.

use crate::axes::Shape;
use crate::pack::{Lanes, Packed, Packing, in_lane};
use crate::template::Checked;

/// Rows of positions that a kernel computes at once.
pub(crate) const ROWS: usize = 4;

/// One image word and its factors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tap {
    /// Word of the packed source, relative to the block's first position.
    pub(crate) offset: u32,
    /// The template's words for the output rows of the phase, from its first.
    pub(crate) words: [u32; ROWS],
}

/// Taps that serve the output rows `first .. first + rows` of a block.
#[derive(Clone, Debug)]
pub(crate) struct Phase {
    pub(crate) first: usize,
    pub(crate) rows: usize,
    pub(crate) taps: std::ops::Range<usize>,
}

/// Phases whose sums fit 32 bits; each sum counts `scale` times.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) scale: i64,
    pub(crate) phases: std::ops::Range<usize>,
}

/// A template for the direct kernels. Kept between searches for its memory.
#[derive(Debug, Default)]
pub(crate) struct Taps {
    pub(crate) taps: Vec<Tap>,
    pub(crate) phases: Vec<Phase>,
    pub(crate) groups: Vec<Group>,
    /// One past the largest offset.
    pub(crate) reach: usize,
    words: Vec<u32>,
    /// Taps by (first, rows) while a group is built.
    sorted: [Vec<Tap>; ROWS * ROWS],
}

/// Bytes hold factors of at most 7 bits and a sign: heavier weights take two groups.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Whole,
    Low,
    High,
}

impl Part {
    fn of(self, factor: i32) -> i32 {
        let low = i32::from(factor as i8);
        match self {
            Self::Whole => factor,
            Self::Low => low,
            Self::High => (factor - low) >> 8,
        }
    }
}

/// Rows `y` and words `x` of one frame of the template's words.
struct Cell {
    frame: usize,
    y: std::ops::Range<usize>,
    x: std::ops::Range<usize>,
}

impl Taps {
    /// Lists the products of a template with a packed source of that height. With `exact`, the sum of a group fits
    /// 31 bits and a sign; otherwise it is known modulo 2^32.
    pub(crate) fn build(&mut self, template: &Checked<'_>, weights: &[u8], image: &Packed, height: usize, exact: bool) {
        self.taps.clear();
        self.phases.clear();
        self.groups.clear();
        let light = image.lanes == Lanes::Pairs || weights.iter().all(|&w| w <= 1);
        let parts: &[(Part, i64)] = if light { &[(Part::Whole, 1)] } else { &[(Part::Low, 1), (Part::High, 256)] };
        for &(part, scale) in parts {
            let mut budget = Budget::new(exact);
            for (plane, packing) in Packing::of(weights.len(), image.lanes).enumerate() {
                let shape = self.pack(template, weights, packing, image.lanes, part);
                for frame in 0..shape[0] {
                    let place = plane * image.plane + frame * height * image.width;
                    let step = if exact { 64 } else { shape[2] };
                    for x in (0..shape[2]).step_by(step) {
                        let x = x..(x + step).min(shape[2]);
                        self.add(shape, frame, x, place, packing.pixels, image, &mut budget, scale);
                    }
                }
            }
            self.close(scale);
        }
        self.reach = self.taps.iter().map(|t| t.offset as usize + 1).max().unwrap_or(0);
    }

    /// Adds rows of one frame, closing the group wherever its sums could pass 32 bits.
    #[expect(clippy::too_many_arguments, reason = "the loop nest of `build`, split")]
    fn add(
        &mut self,
        shape: Shape,
        frame: usize,
        x: std::ops::Range<usize>,
        place: usize,
        pixels: usize,
        image: &Packed,
        budget: &mut Budget,
        scale: i64,
    ) {
        let mut y = 0;
        for end in 0..shape[1] {
            let row = (frame * shape[1] + end) * shape[2];
            let weight = self.words[row + x.start..row + x.end].iter().map(|&w| largest(w, image.lanes)).sum();
            if !budget.take(weight) {
                self.sort(shape, &Cell { frame, y: y..end, x: x.clone() }, place, pixels, image.width);
                self.close(scale);
                budget.restart(weight);
                y = end;
            }
        }
        self.sort(shape, &Cell { frame, y: y..shape[1], x }, place, pixels, image.width);
    }

    /// The template's words of one plane; returns their shape.
    fn pack(&mut self, template: &Checked<'_>, weights: &[u8], packing: Packing, lanes: Lanes, part: Part) -> Shape {
        let [frames, height, width] = template.shape;
        let shape = [frames, height, width.div_ceil(packing.pixels)];
        self.words.clear();
        self.words.resize(shape.iter().product(), 0);
        let len = template.len();
        for (lane, (c, pixel)) in packing.lanes().enumerate() {
            let features = &template.features[c * len..(c + 1) * len];
            for row in 0..frames * height {
                let words = &mut self.words[row * shape[2]..(row + 1) * shape[2]];
                let indices = (row * width + pixel..(row + 1) * width).step_by(packing.pixels);
                for (word, i) in words.iter_mut().zip(indices).filter(|&(_, i)| template.counts(i)) {
                    let factor = i32::from(weights[c]) * (i32::from(features[i]) - 128);
                    *word |= in_lane(part.of(factor), lane, lanes);
                }
            }
        }
        shape
    }

    /// Puts the taps of some template rows under the output rows that they serve.
    fn sort(&mut self, shape: Shape, cell: &Cell, place: usize, pixels: usize, width: usize) {
        let word = |y: usize, x: usize| self.words[(cell.frame * shape[1] + y) * shape[2] + x];
        for y in cell.y.start..cell.y.end + ROWS - 1 {
            // Template row `y - o` must lie in the cell.
            let first = (y + 1).saturating_sub(cell.y.end);
            let rows = (y - cell.y.start + 1).min(ROWS).saturating_sub(first);
            if rows == 0 {
                continue;
            }
            let list = &mut self.sorted[first * ROWS + rows - 1];
            for x in cell.x.clone() {
                let mut words = [0; ROWS];
                for (o, w) in words.iter_mut().take(rows).enumerate() {
                    *w = word(y - first - o, x);
                }
                if words != [0; ROWS] {
                    list.push(Tap { offset: (place + y * width + x * pixels) as u32, words });
                }
            }
        }
    }

    /// Ends a group.
    fn close(&mut self, scale: i64) {
        let first = self.phases.len();
        for (key, list) in self.sorted.iter_mut().enumerate().filter(|(_, list)| !list.is_empty()) {
            let start = self.taps.len();
            self.taps.append(list);
            self.phases.push(Phase { first: key / ROWS, rows: key % ROWS + 1, taps: start..self.taps.len() });
        }
        if first < self.phases.len() {
            self.groups.push(Group { scale, phases: first..self.phases.len() });
        }
    }
}

/// What the sums of a group may still reach.
struct Budget {
    left: i64,
    exact: bool,
}

impl Budget {
    const FULL: i64 = i32::MAX as i64;

    fn new(exact: bool) -> Self {
        Self { left: Self::FULL, exact }
    }

    fn take(&mut self, weight: i64) -> bool {
        self.left -= if self.exact { weight } else { 0 };
        0 <= self.left
    }

    fn restart(&mut self, weight: i64) {
        self.left = Self::FULL - weight;
    }
}

/// The largest absolute product of a word with an image word.
fn largest(word: u32, lanes: Lanes) -> i64 {
    let sum: i64 = match lanes {
        Lanes::Bytes => word.to_le_bytes().iter().map(|&b| i64::from((b as i8).unsigned_abs())).sum(),
        Lanes::Pairs => [word as i16, (word >> 16) as i16].iter().map(|&w| i64::from(w.unsigned_abs())).sum(),
    };
    255 * sum
}
