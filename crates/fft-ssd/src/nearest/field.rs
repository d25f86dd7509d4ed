//! Pictures as words: what one instruction subtracts and squares.

use super::{Field, Windows};
use crate::Error;
use crate::kernel::SHIFTS;
use selvedge_core::{Domain, try_vec};

/// Two 16-bit values a word: of two channels, or of one at a pixel and the next.
#[derive(Clone, Copy, Debug)]
struct Plane {
    channel: usize,
    /// The other half: a channel and its pixel's distance; nothing if 0.
    other: Option<(usize, usize)>,
    /// Pixels along x that a word holds.
    pixels: usize,
}

/// Channels of one weight, and where their words lie in a cell.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) weight: u32,
    planes: Vec<Plane>,
}

/// Channels that weigh the same are summed before they are weighed. A last odd one shares its words with its
/// neighbour's along x, if cells hold whole pairs.
pub(super) fn groups(weights: &[u8], step: usize) -> Vec<Group> {
    let plane = |channels: &[usize]| match *channels {
        [channel, other] => Plane { channel, other: Some((other, 0)), pixels: 1 },
        [channel, ..] if step.is_multiple_of(2) => Plane { channel, other: Some((channel, 1)), pixels: 2 },
        _ => Plane { channel: channels[0], other: None, pixels: 1 },
    };
    let mut values: Vec<u8> = weights.iter().copied().filter(|&w| 0 < w).collect();
    values.sort_unstable();
    values.dedup();
    let group = |weight: u8| {
        let channels: Vec<usize> = (0..weights.len()).filter(|&c| weights[c] == weight).collect();
        Group { weight: u32::from(weight), planes: channels.chunks(2).map(plane).collect() }
    };
    values.into_iter().map(group).collect()
}

/// A picture continued around its periodic axes by as much as windows reach.
pub(super) struct Continued<'a> {
    field: Field<'a>,
    pub(super) shape: [usize; 2],
}

impl<'a> Continued<'a> {
    /// For windows at every position of `over`, in units of `step`.
    pub(super) fn new(field: Field<'a>, over: Domain<2>, windows: Windows, step: u32) -> Self {
        let touched = |axis: usize| match over.shape[axis] {
            0 => 0,
            n => (n - 1) as usize * step as usize + windows.side as usize,
        };
        Self { field, shape: [touched(0), touched(1)] }
    }

    fn index(&self, y: usize, x: usize) -> usize {
        let [h, w] = self.field.features.domain().shape.map(|n| n as usize);
        y % h * w + x % w
    }

    fn is_valid(&self, y: usize, x: usize) -> bool {
        self.field.valid.is_none_or(|v| v.plane(0)[self.index(y, x)])
    }

    pub(super) fn is_masked(&self) -> bool {
        self.field.valid.is_some_and(|v| v.plane(0).contains(&false))
    }

    fn word(&self, plane: Plane, y: usize, x: usize) -> u32 {
        let value = |channel: usize, x: usize| u32::from(self.field.features.plane(channel)[self.index(y, x)]);
        let other = plane.other.filter(|&(_, by)| x + by < self.shape[1]);
        value(plane.channel, x) | other.map_or(0, |(channel, by)| value(channel, x + by)) << 16
    }
}

/// Words of the picture whose windows are asked for: cell by cell, tap by tap.
pub(super) struct Asked {
    /// Words, and for each whether its halves count; empty if all do.
    pub(super) words: Vec<u32>,
    pub(super) masks: Vec<u32>,
    /// Taps a cell.
    pub(super) taps: usize,
    /// Cells a row.
    pub(super) columns: usize,
}

impl Asked {
    pub(super) fn new(picture: &Continued<'_>, group: &Group, step: usize) -> Result<Self, Error> {
        let (rows, columns) = (picture.shape[0] / step, picture.shape[1] / step);
        let taps = offsets(group, step, 0, 0).len();
        let mut words = try_vec(rows * columns * taps, 0)?;
        let masked = picture.is_masked();
        let mut masks = try_vec(if masked { words.len() } else { 0 }, 0)?;
        for cell in 0..rows * columns {
            let [y0, x0] = [cell / columns * step, cell % columns * step];
            for (tap, (plane, y, x)) in places(group, step).enumerate() {
                words[cell * taps + tap] = picture.word(plane, y0 + y, x0 + x);
                if masked {
                    let half = |on: bool| if on { 0xffff } else { 0 };
                    let by = plane.other.map_or(0, |(_, by)| by);
                    let other = picture.is_valid(y0 + y, x0 + x + by);
                    masks[cell * taps + tap] = half(picture.is_valid(y0 + y, x0 + x)) | half(other) << 16;
                }
            }
        }
        Ok(Self { words, masks, taps, columns })
    }
}

/// Words of a source, plane by plane, with room on both sides for lanes that reach beyond it.
pub(super) struct Offered {
    pub(super) words: Vec<u32>,
    pub(super) width: usize,
    /// Where each tap of a cell lies, from the cell's first word.
    pub(super) offsets: Vec<usize>,
}

impl Offered {
    pub(super) fn new(source: &Continued<'_>, group: &Group, step: usize) -> Result<Self, Error> {
        let [h, w] = source.shape;
        let width = w + 2 * SHIFTS + step;
        let mut words = try_vec(h * width * group.planes.len() + SHIFTS, 0)?;
        for (plane, words) in group.planes.iter().zip(words.chunks_mut((h * width).max(1))) {
            for y in 0..h {
                for x in 0..w {
                    words[y * width + SHIFTS + x] = source.word(*plane, y, x);
                }
            }
        }
        Ok(Self { words, width, offsets: offsets(group, step, width, h * width) })
    }
}

/// For each position of a window in a source 0, or all ones if it is none: also beyond, for lanes that reach there.
pub(super) struct Barred {
    marks: Vec<u32>,
    width: usize,
}

impl Barred {
    pub(super) fn new(source: &Continued<'_>, over: Domain<2>, side: usize) -> Result<Self, Error> {
        let [rows, columns] = over.shape.map(|n| n as usize);
        let width = columns + 2 * SHIFTS;
        let mut marks = try_vec(rows * width, u32::MAX)?;
        for y in 0..rows {
            marks[y * width + SHIFTS..][..columns].fill(0);
        }
        if source.is_masked() {
            // Samples that are not valid above and left of each corner.
            let [h, w] = source.shape;
            let mut sums = try_vec((h + 1) * (w + 1), 0_u32)?;
            for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
                let at = (y + 1) * (w + 1) + x + 1;
                let above = sums[at - w - 1] + sums[at - 1] - sums[at - w - 2];
                sums[at] = above + u32::from(!source.is_valid(y, x));
            }
            let corner = |y: usize, x: usize| sums[y * (w + 1) + x];
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let inside = corner(y + side, x + side) + corner(y, x) - corner(y + side, x) - corner(y, x + side);
                if inside != 0 {
                    marks[y * width + SHIFTS + x] = u32::MAX;
                }
            }
        }
        Ok(Self { marks, width })
    }

    /// The marks of lanes whose first is column `x`, which may lie up to a vector left of the source.
    pub(super) fn row(&self, y: usize, x: isize) -> &[u32] {
        &self.marks[self.at(y, x)..]
    }

    /// The marks of all positions, in an order that [`at`](Self::at) tells.
    pub(super) fn marks(&self) -> &[u32] {
        &self.marks
    }

    /// Where the mark of a position lies.
    pub(super) fn at(&self, y: usize, x: isize) -> usize {
        y * self.width + (x + SHIFTS as isize) as usize
    }
}

/// Plane, row and column of each tap of a cell.
fn places(group: &Group, step: usize) -> impl Iterator<Item = (Plane, usize, usize)> {
    let of =
        move |&plane: &Plane| (0..step).flat_map(move |y| (0..step).step_by(plane.pixels).map(move |x| (plane, y, x)));
    group.planes.iter().flat_map(of)
}

fn offsets(group: &Group, step: usize, width: usize, plane: usize) -> Vec<usize> {
    let of = |number: usize, p: &Plane| {
        let columns = p.pixels;
        (0..step).flat_map(move |y| (0..step).step_by(columns).map(move |x| number * plane + y * width + x))
    };
    group.planes.iter().enumerate().flat_map(|(number, p)| of(number, p)).collect()
}
