//! Sums over masks at every position, from summed-area tables (Crow 1984).

use crate::Error;
use crate::axes::Shape;
use crate::extension::Extension;
use crate::memory::reserve;
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
}

impl Corners {
    /// Corners in a table of that shape of the masks of templates of one shape, which are summed.
    pub(crate) fn of_masks(&mut self, templates: &[Checked<'_>], table: Shape) -> Result<(), Error> {
        let counted = |i: usize| templates.iter().filter(|t| t.counts(i)).count() as i32;
        let is_box = templates.iter().all(|t| t.mask.is_none());
        self.fill(templates[0].shape, table, counted, is_box)
    }

    /// Corners of the template's box.
    pub(crate) fn of_box(&mut self, template: &Checked<'_>, table: Shape) -> Result<(), Error> {
        self.fill(template.shape, table, |_| 1, true)
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

    /// Corners of what is `counted` how often at which sample of a box.
    fn fill(&mut self, shape: Shape, table: Shape, counted: impl Fn(usize) -> i32, is_box: bool) -> Result<(), Error> {
        self.clear();
        let frames = usize::from(table[0] != 1);
        // Of a box, only its corners can differ from their neighbours.
        let steps = |axis: usize| if is_box { shape[axis] } else { 1 };
        let sample = |t: usize, y: usize, x: usize| {
            let inside = t < shape[0] && y < shape[1] && x < shape[2];
            if inside { counted((t * shape[1] + y) * shape[2] + x) } else { 0 }
        };
        for t in (0..=shape[0] * frames).step_by(steps(0)) {
            for y in (0..=shape[1]).step_by(steps(1)) {
                for x in (0..=shape[2]).step_by(steps(2)) {
                    let row = |t: usize, y: usize| sample(t, y, x.wrapping_sub(1)) - sample(t, y, x);
                    let plane = |t: usize| row(t, y.wrapping_sub(1)) - row(t, y);
                    let difference = if frames == 1 { plane(t.wrapping_sub(1)) - plane(t) } else { plane(0) };
                    let list = if 0 < difference { &mut self.plus } else { &mut self.minus };
                    let place = (t * table[1] + y) * table[2] + x;
                    reserve(list, difference.unsigned_abs() as usize)?;
                    list.extend(std::iter::repeat_n(place, difference.unsigned_abs() as usize));
                }
            }
        }
        Ok(())
    }
}
