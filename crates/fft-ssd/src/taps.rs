//! Templates as lists of multiplications for the direct kernels.
//!
//! A kernel computes four rows of positions at once, so that a loaded image vector serves up to four template rows. Row
//! `y` of the image meets output row `o` through template row `y - o`: a [`Phase`] lists the taps of all image rows
//! that serve the same output rows.

use crate::Error;
use crate::axes::Shape;
use crate::memory::{filled, push, reserve};
use crate::pack::{Lanes, Packed, Packing, in_lane};
use crate::template::Checked;

/// Rows of positions that a kernel computes at once: they share each load of the template (`DESIGN.md`, 3).
pub(crate) const ROWS: usize = 4;

/// One image word and its factors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tap {
    /// Word of the packed source, relative to the block's first position.
    pub(crate) offset: usize,
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

    /// How often its sums count.
    fn scale(self) -> i64 {
        if self == Self::High { 256 } else { 1 }
    }
}

/// The packed source that templates are multiplied with.
pub(crate) struct Image<'a> {
    pub(crate) packed: &'a Packed,
    pub(crate) weights: &'a [u8],
    /// Rows of a frame.
    pub(crate) height: usize,
}

/// The plane of words under a part of a template.
struct Under {
    /// The word under the template's first.
    place: usize,
    /// Words from one of the template's to the next.
    pixels: usize,
    /// Words of a row.
    width: usize,
    lanes: Lanes,
}

/// Rows `y` and words `x` of one frame of the template's words.
struct Cell {
    frame: usize,
    y: std::ops::Range<usize>,
    x: std::ops::Range<usize>,
}

impl Taps {
    /// Lists the products of templates of one shape, which are summed, with a packed source of that height. With
    /// `exact`, the sum of a group fits 31 bits and a sign; otherwise it is known modulo 2^32.
    pub(crate) fn build(&mut self, templates: &[Checked<'_>], to: &Image<'_>, exact: bool) -> Result<(), Error> {
        self.taps.clear();
        self.phases.clear();
        self.groups.clear();
        let light = to.packed.lanes == Lanes::Pairs || to.weights.iter().all(|&w| w <= 1);
        let parts: &[Part] = if light { &[Part::Whole] } else { &[Part::Low, Part::High] };
        for &part in parts {
            let mut budget = Budget::new(exact);
            for template in templates {
                self.add(template, to, part, &mut budget)?;
            }
            self.close(part.scale())?;
        }
        self.reach = self.taps.iter().map(|t| t.offset + 1).max().unwrap_or(0);
        Ok(())
    }

    /// Adds one template, closing the group wherever its sums could pass 32 bits.
    fn add(&mut self, template: &Checked<'_>, to: &Image<'_>, part: Part, budget: &mut Budget) -> Result<(), Error> {
        let image = to.packed;
        for (plane, packing) in Packing::of(to.weights.len(), image.lanes).enumerate() {
            let shape = self.pack(template, to.weights, packing, image.lanes, part)?;
            for frame in 0..shape[0] {
                let place = plane * image.plane + frame * to.height * image.width;
                let step = if budget.exact { 64 } else { shape[2] };
                for x in (0..shape[2]).step_by(step) {
                    let cell = Cell { frame, y: 0..shape[1], x: x..(x + step).min(shape[2]) };
                    let under = Under { place, pixels: packing.pixels, width: image.width, lanes: image.lanes };
                    self.add_cell(shape, cell, &under, part, budget)?;
                }
            }
        }
        Ok(())
    }

    /// Adds rows of one frame.
    fn add_cell(
        &mut self,
        shape: Shape,
        mut cell: Cell,
        under: &Under,
        part: Part,
        budget: &mut Budget,
    ) -> Result<(), Error> {
        let all = cell.y.end;
        for end in 0..all {
            let row = (cell.frame * shape[1] + end) * shape[2];
            let words = &self.words[row + cell.x.start..row + cell.x.end];
            let weight = if budget.exact { words.iter().map(|&w| largest(w, under.lanes)).sum() } else { 0 };
            if !budget.take(weight) {
                cell.y.end = end;
                self.sort(shape, &cell, under)?;
                self.close(part.scale())?;
                budget.restart(weight);
                cell.y.start = end;
            }
        }
        cell.y.end = all;
        self.sort(shape, &cell, under)
    }

    /// The template's words of one plane; returns their shape.
    fn pack(
        &mut self,
        template: &Checked<'_>,
        weights: &[u8],
        packing: Packing,
        lanes: Lanes,
        part: Part,
    ) -> Result<Shape, Error> {
        let [frames, height, width] = template.shape;
        let shape = [frames, height, width.div_ceil(packing.pixels)];
        filled(&mut self.words, shape.iter().product(), 0)?;
        let len = template.len();
        for (lane, (c, pixel)) in packing.lanes().enumerate() {
            let features = &template.features[c * len..(c + 1) * len];
            let add = |(word, &feature): (&mut u32, &u8)| {
                let factor = i32::from(weights[c]) * (i32::from(feature) - 128);
                *word |= in_lane(part.of(factor), lane, lanes);
            };
            for (row, words) in self.words.chunks_mut(shape[2]).enumerate() {
                let samples = row * width + pixel.min(width)..(row + 1) * width;
                let pairs = words.iter_mut().zip(features[samples.clone()].iter().step_by(packing.pixels));
                match template.mask.map(|mask| mask[samples].iter().step_by(packing.pixels)) {
                    Some(mask) => pairs.zip(mask).filter(|(_, on)| **on).for_each(|(pair, _)| add(pair)),
                    None => pairs.for_each(add),
                }
            }
        }
        Ok(shape)
    }

    /// Puts the taps of some template rows under the output rows that they serve.
    fn sort(&mut self, shape: Shape, cell: &Cell, under: &Under) -> Result<(), Error> {
        let width = shape[2];
        for y in cell.y.start..cell.y.end + ROWS - 1 {
            // Template row `y - o` must lie in the cell.
            let first = (y + 1).saturating_sub(cell.y.end);
            let rows = (y - cell.y.start + 1).min(ROWS).saturating_sub(first);
            if rows == 0 {
                continue;
            }
            let list = &mut self.sorted[first * ROWS + rows - 1];
            reserve(list, cell.x.len())?;
            // The template row that serves each output row.
            let serving: [&[u32]; ROWS] = std::array::from_fn(|o| {
                let row = (cell.frame * shape[1] + y).wrapping_sub(first + o);
                if o < rows { &self.words[row * width..(row + 1) * width] } else { &[] }
            });
            for x in cell.x.clone() {
                let words = serving.map(|row| row.get(x).copied().unwrap_or(0));
                if words != [0; ROWS] {
                    list.push(Tap { offset: under.place + y * under.width + x * under.pixels, words });
                }
            }
        }
        Ok(())
    }

    /// Ends a group.
    fn close(&mut self, scale: i64) -> Result<(), Error> {
        let first = self.phases.len();
        for (key, list) in self.sorted.iter_mut().enumerate().filter(|(_, list)| !list.is_empty()) {
            let start = self.taps.len();
            reserve(&mut self.taps, list.len())?;
            self.taps.append(list);
            push(&mut self.phases, Phase { first: key / ROWS, rows: key % ROWS + 1, taps: start..self.taps.len() })?;
        }
        if first < self.phases.len() {
            push(&mut self.groups, Group { scale, phases: first..self.phases.len() })?;
        }
        Ok(())
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
        self.left -= weight;
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
