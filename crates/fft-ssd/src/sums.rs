//! Sums over masks at every position, from summed-area tables (Crow 1984).

use crate::Error;
use crate::axes::Shape;
use crate::extension::Extension;
use crate::memory::{filled, reserve};
use crate::source::SourceView;
use crate::template::Checked;
use crate::word::Word;
use selvedge_core::try_vec;

/// Sums of a plane over all boxes that start at the origin; one more coordinate an axis than the plane, except along
/// an axis of length 1, which is left as it is. Sums wrap.
#[derive(Debug)]
pub(crate) struct Table<W> {
    pub(crate) shape: Shape,
    pub(crate) sums: Vec<W>,
}

impl<W: Word> Table<W> {
    /// The shape of the table of a plane.
    pub(crate) fn shape(plane: Shape) -> Shape {
        // Only time is left out: rows and columns of length 1 are rare, frames are not.
        [if plane[0] == 1 { 1 } else { plane[0] + 1 }, plane[1] + 1, plane[2] + 1]
    }

    /// Sums of what `row(t * height + y, values)` writes; rows that it leaves alone are 0.
    pub(crate) fn new(plane: Shape, mut row: impl FnMut(usize, &mut [W])) -> Result<Self, Error> {
        let shape = Self::shape(plane);
        let [_, height, width] = shape;
        let mut sums = try_vec(shape.iter().product(), W::ZERO)?;
        let skip = usize::from(plane[0] != 1);
        for t in 0..plane[0] {
            for y in 0..plane[1] {
                let start = ((t + skip) * height + y + 1) * width;
                let (before, this) = sums.split_at_mut(start);
                let this = &mut this[..width];
                row(t * plane[1] + y, &mut this[1..]);
                let mut sum = W::ZERO;
                for (here, &above) in this.iter_mut().zip(&before[start - width..]) {
                    sum = sum.plus(*here);
                    *here = sum.plus(above);
                }
            }
            if skip == 1 {
                let frame = height * width;
                let (before, this) = sums.split_at_mut((t + 1) * frame);
                for (here, &earlier) in this.iter_mut().zip(&before[t * frame..]) {
                    *here = here.plus(earlier);
                }
            }
        }
        Ok(Self { shape, sums })
    }

    /// Sums of `sum over c of W_c * (value_c - 128)^2` over the valid samples of an extended source.
    pub(crate) fn squares(source: &SourceView<'_>, weights: &[u8], extension: &Extension) -> Result<Self, Error> {
        let (first, columns) = extension.columns();
        let mut rows = extension.rows(source).peekable();
        Self::new(extension.shape, |number, values| {
            let Some((_, from)) = rows.next_if(|&(at, _)| at == number) else { return };
            for (value, &x) in values[first..].iter_mut().zip(columns) {
                *value = W::wrapping(square(source, weights, from + x as usize));
            }
        })
    }

    /// Numbers of valid samples of an extended source.
    pub(crate) fn valid(source: &SourceView<'_>, extension: &Extension) -> Result<Self, Error> {
        let (first, columns) = extension.columns();
        let mut rows = extension.rows(source).peekable();
        Self::new(extension.shape, |number, values| {
            let Some((_, from)) = rows.next_if(|&(at, _)| at == number) else { return };
            for (value, &x) in values[first..].iter_mut().zip(columns) {
                *value = W::wrapping(i64::from(source.is_valid(from + x as usize)));
            }
        })
    }

    /// The sum over a box, given by its range along each axis.
    pub(crate) fn over(&self, of: &[std::ops::Range<usize>; 3]) -> W {
        let frame = |t: usize| {
            let at = |y: usize, x: usize| self.sums[(t * self.shape[1] + y) * self.shape[2] + x];
            let (y, x) = (&of[1], &of[2]);
            at(y.end, x.end).minus(at(y.start, x.end)).minus(at(y.end, x.start)).plus(at(y.start, x.start))
        };
        if self.shape[0] == 1 { frame(0) } else { frame(of[0].end).minus(frame(of[0].start)) }
    }
}

/// `sum over c of W_c * (value_c - 128)^2` of a source sample, 0 if it is not valid.
pub(crate) fn square(source: &SourceView<'_>, weights: &[u8], index: usize) -> i64 {
    if !source.is_valid(index) {
        return 0;
    }
    let squared = |c: usize| (i64::from(source.plane(c)[index]) - 128).pow(2);
    weights.iter().enumerate().map(|(c, &w)| i64::from(w) * squared(c)).sum()
}

/// A mask as signed corners: `sum over x of m(x) f(x + p)` is the sum of a table of `f` at `p + plus`, less that at
/// `p + minus`. A rectangle has 4 corners (8 in a clip), an L 6; a noisy mask has several a sample.
#[derive(Debug, Default)]
pub(crate) struct Corners {
    /// Places in the table, relative to the position's.
    pub(crate) plus: Vec<usize>,
    pub(crate) minus: Vec<usize>,
    /// Working memory.
    differences: Vec<i32>,
}

impl Corners {
    /// Corners in a table of that shape of the masks of templates of one shape, which are summed.
    pub(crate) fn of_masks(&mut self, templates: &[Checked<'_>], table: Shape) -> Result<(), Error> {
        let shape = templates[0].shape;
        if templates.iter().all(|t| t.mask.is_none()) {
            return self.of_boxes(shape, table, templates.len());
        }
        self.clear();
        self.count(templates, table[0] != 1)?;
        let [_, height, width] = shape.map(|n| n + 1);
        for (number, row) in self.differences.chunks(width).enumerate() {
            let place = (number / height * table[1] + number % height) * table[2];
            for (x, &difference) in row.iter().enumerate().filter(|&(_, &difference)| difference != 0) {
                let list = if 0 < difference { &mut self.plus } else { &mut self.minus };
                let times = difference.unsigned_abs() as usize;
                reserve(list, times)?;
                list.extend(std::iter::repeat_n(place + x, times));
            }
        }
        Ok(())
    }

    /// Corners of the template's box.
    pub(crate) fn of_box(&mut self, template: &Checked<'_>, table: Shape) -> Result<(), Error> {
        self.of_boxes(template.shape, table, 1)
    }

    /// No corners.
    pub(crate) fn clear(&mut self) {
        self.plus.clear();
        self.minus.clear();
    }

    /// How many table entries a position reads.
    pub(crate) fn len(&self) -> usize {
        self.plus.len() + self.minus.len()
    }

    /// Corners of a box that is counted some times.
    fn of_boxes(&mut self, shape: Shape, table: Shape, times: usize) -> Result<(), Error> {
        self.clear();
        // Bit `a` of a corner tells that it lies at the box's end along axis `a`.
        for corner in (0..8_u32).filter(|corner| table[0] != 1 || corner & 1 == 0) {
            let [t, y, x] = [0, 1, 2].map(|a: usize| if corner >> a & 1 == 1 { shape[a] } else { 0 });
            let starts = if table[0] == 1 { 2 } else { 3 } - corner.count_ones();
            let list = if starts.is_multiple_of(2) { &mut self.plus } else { &mut self.minus };
            reserve(list, times)?;
            list.extend(std::iter::repeat_n((t * table[1] + y) * table[2] + x, times));
        }
        Ok(())
    }

    /// How often each sample is counted, taken from how often its neighbour before it is, along each axis in turn; one
    /// sample more along each axis than the templates have.
    fn count(&mut self, templates: &[Checked<'_>], clip: bool) -> Result<(), Error> {
        let [frames, height, width] = templates[0].shape;
        let (row, frame) = (width + 1, (width + 1) * (height + 1));
        filled(&mut self.differences, frame * (frames + usize::from(clip)), 0)?;
        for template in templates {
            for number in 0..frames * height {
                let to = &mut self.differences[number / height * frame + number % height * row..][..width];
                match template.mask {
                    Some(mask) => to.iter_mut().zip(&mask[number * width..]).for_each(|(n, &on)| *n += i32::from(on)),
                    None => to.iter_mut().for_each(|n| *n += 1),
                }
            }
        }
        for row in self.differences.chunks_mut(row) {
            row.iter_mut().fold(0, |before, here| {
                let now = *here;
                *here = before - now;
                now
            });
        }
        self.differences.chunks_mut(frame).for_each(|frame| differ(frame, row));
        if clip {
            differ(&mut self.differences, frame);
        }
        Ok(())
    }
}

/// Takes each value from the one `step` before it, of which there is none before the first.
fn differ(values: &mut [i32], step: usize) {
    for start in (step..values.len()).step_by(step).rev() {
        let (before, here) = values.split_at_mut(start);
        here[..step].iter_mut().zip(&before[start - step..]).for_each(|(here, &before)| *here = before - *here);
    }
    values[..step].iter_mut().for_each(|first| *first = -*first);
}
