//! A source continued over its borders, so that every placement becomes "the box lies inside".

use crate::Error;
use crate::axes::Shape;
use crate::placement::Range;
use crate::source::SourceView;
use selvedge_core::collected;

const OUTSIDE: u32 = u32::MAX;

/// Which part of a source, wrapped or sticking out, the positions of a search touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Extension {
    /// Samples touched along each axis.
    pub(crate) shape: Shape,
    /// Source coordinate of each coordinate of the extension, axis by axis.
    index: [Vec<u32>; 3],
    /// Samples after which an axis repeats itself.
    period: [Option<usize>; 3],
    /// Per axis, the coordinates that lie on the source.
    inside: [std::ops::Range<usize>; 3],
}

impl Extension {
    /// The samples that a template of shape `template` touches at the positions of `range`.
    pub(crate) fn new(source: Shape, range: &Range, template: Shape) -> Result<Self, Error> {
        let axis = |a: usize| {
            let n = source[a] as isize;
            let touched = (range.count[a] + template[a] - 1) as isize;
            let place = |i: isize| match range.first[a] + i {
                q if range.wraps[a] => q.rem_euclid(n) as u32,
                q if q < 0 || n <= q => OUTSIDE,
                q => q as u32,
            };
            collected((0..touched).map(place))
        };
        let index: [Vec<u32>; 3] = [axis(0)?, axis(1)?, axis(2)?];
        let inside = [0, 1, 2].map(|a: usize| {
            let first = index[a].iter().position(|&i| i != OUTSIDE).unwrap_or(0);
            first..first + index[a].iter().filter(|&&i| i != OUTSIDE).count()
        });
        let period = [0, 1, 2].map(|a: usize| range.wraps[a].then_some(source[a]));
        Ok(Self { shape: [0, 1, 2].map(|a: usize| index[a].len()), index, period, inside })
    }

    /// A name for caches: the same source, range and shape have the same extension.
    pub(crate) fn key(source: Shape, range: &Range, template: Shape) -> Key {
        let plain = |a: usize| range.first[a] == 0 && range.count[a] + template[a] - 1 == source[a];
        let part =
            |a: usize| if plain(a) { (0, source[a]) } else { (range.first[a], range.count[a] + template[a] - 1) };
        [part(0), part(1), part(2)]
    }

    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Rows of the extension, as `(t * height + y, start of the source's row)`; rows outside are left out.
    pub(crate) fn rows<'a>(&'a self, source: &'a SourceView<'_>) -> impl Iterator<Item = (usize, usize)> + 'a {
        let height = self.shape[1];
        self.inside[0].clone().flat_map(move |t| {
            self.inside[1].clone().map(move |y| {
                let from = self.index[0][t] as usize * source.shape[1] + self.index[1][y] as usize;
                (t * height + y, from * source.shape[2])
            })
        })
    }

    /// Start of the source's row under a row; `None` outside.
    pub(crate) fn row(&self, source: &SourceView<'_>, t: usize, y: usize) -> Option<usize> {
        let inside = |axis: usize, at: usize| self.index[axis].get(at).filter(|&&i| i != OUTSIDE).map(|&i| i as usize);
        Some((inside(0, t)? * source.shape[1] + inside(1, y)?) * source.shape[2])
    }

    /// How many coordinates from one on lie before the source, and how many up to its end.
    pub(crate) fn beside(&self, axis: usize, start: usize) -> (usize, usize) {
        let inside = &self.inside[axis];
        (inside.start.saturating_sub(start), inside.end.saturating_sub(start))
    }

    /// Samples after which an axis repeats itself, where it wraps around.
    pub(crate) fn period(&self, axis: usize) -> Option<usize> {
        self.period[axis]
    }

    /// Source column of each column inside, with the first of those columns.
    pub(crate) fn columns(&self) -> (usize, &[u32]) {
        (self.inside[2].start, &self.index[2][self.inside[2].clone()])
    }

    /// Per axis, the coordinates that lie on the source.
    pub(crate) fn inside(&self) -> &[std::ops::Range<usize>; 3] {
        &self.inside
    }

    /// True if every coordinate lies on the source.
    pub(crate) fn is_inside(&self) -> bool {
        (0..3).all(|a| self.inside[a] == (0..self.shape[a]))
    }
}

/// First coordinate and length along each axis.
pub(crate) type Key = [(isize, usize); 3];
