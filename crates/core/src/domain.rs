//! Shape and topology of everything that has neighbours.

/// Shape, slowest axis first, and per axis open or periodic.
///
/// Positions are unsigned, `[y, x]` or `[t, y, x]`; steps between them are signed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain<const D: usize> {
    /// Samples along each axis, slowest first.
    pub shape: [u32; D],
    /// Whether an axis wraps around.
    pub periodic: [bool; D],
}

impl<const D: usize> Domain<D> {
    /// A domain with borders on every axis.
    pub const fn open(shape: [u32; D]) -> Self {
        Self { shape, periodic: [false; D] }
    }

    /// A torus.
    pub const fn periodic(shape: [u32; D]) -> Self {
        Self { shape, periodic: [true; D] }
    }

    /// Number of samples.
    ///
    /// # Panics
    /// If the number does not fit `usize`; [`checked_len`](Self::checked_len) does not.
    pub fn len(&self) -> usize {
        self.checked_len().expect("shapes are checked when their grid is made")
    }

    /// Number of samples, `None` where it does not fit `usize`.
    pub fn checked_len(&self) -> Option<usize> {
        self.shape.iter().try_fold(1_usize, |n, &side| n.checked_mul(side as usize))
    }

    /// True if any side is 0.
    pub fn is_empty(&self) -> bool {
        self.shape.contains(&0)
    }

    /// Distance in a buffer between neighbours along each axis.
    pub fn strides(&self) -> [usize; D] {
        let mut strides = [1; D];
        for axis in (0..D.saturating_sub(1)).rev() {
            strides[axis] = strides[axis + 1] * self.shape[axis + 1] as usize;
        }
        strides
    }

    /// Place of a position in a row-major buffer.
    ///
    /// # Panics
    /// If the position lies outside, in debug builds; elsewhere the place is another position's, or none.
    /// [`contains`](Self::contains) tells, and [`Grid::get`](crate::Grid::get) always asks.
    #[inline]
    pub fn index(&self, at: [u32; D]) -> usize {
        debug_assert!(self.contains(at), "{at:?} lies outside {:?}", self.shape);
        let mut index = 0;
        for (&p, &side) in at.iter().zip(&self.shape) {
            index = index * side as usize + p as usize;
        }
        index
    }

    /// [`index`](Self::index), refused outside in every build.
    #[inline]
    pub(crate) fn inside(&self, at: [u32; D]) -> usize {
        assert!(self.contains(at), "{at:?} lies outside {:?}", self.shape);
        self.index(at)
    }

    /// Position of a place in a row-major buffer: the inverse of [`index`](Self::index).
    #[inline]
    pub fn position(&self, mut index: usize) -> [u32; D] {
        let mut at = [0; D];
        for axis in (0..D).rev() {
            let side = self.shape[axis] as usize;
            at[axis] = (index % side) as u32;
            index /= side;
        }
        at
    }

    /// True if the position lies inside.
    #[inline]
    pub fn contains(&self, at: [u32; D]) -> bool {
        at.iter().zip(&self.shape).all(|(&p, &side)| p < side)
    }

    /// The position `by` away: wrapped on periodic axes, `None` outside of open ones.
    #[inline]
    pub fn step(&self, at: [u32; D], by: [i32; D]) -> Option<[u32; D]> {
        let mut to = at;
        for axis in 0..D {
            let side = i64::from(self.shape[axis]);
            let mut p = i64::from(at[axis]) + i64::from(by[axis]);
            if self.periodic[axis] {
                p = p.rem_euclid(side);
            } else if p < 0 || side <= p {
                return None;
            }
            to[axis] = p as u32;
        }
        Some(to)
    }

    /// The sample of an axis at a place on it: around a periodic axis, else the outermost where the place is beyond.
    ///
    /// # Panics
    /// If the axis has no sample.
    #[inline]
    pub fn nearest(&self, axis: usize, place: i64) -> u32 {
        let side = i64::from(self.shape[axis]);
        (if self.periodic[axis] { place.rem_euclid(side) } else { place.clamp(0, side - 1) }) as u32
    }

    /// How far two places of an axis are from each other, the shorter way around where the axis is periodic. Both are
    /// on the axis.
    pub fn apart(&self, axis: usize, a: u32, b: u32) -> u32 {
        let along = a.abs_diff(b);
        debug_assert!(along < self.shape[axis].max(1), "{a} or {b} is outside of an axis of {}", self.shape[axis]);
        if self.periodic[axis] { along.min(self.shape[axis] - along) } else { along }
    }

    /// A place or an offset in the first turn of periodic axes; as it is along open ones.
    #[inline]
    pub fn wrapped(&self, place: [i32; D]) -> [i32; D] {
        let along = |a: usize| if self.periodic[a] { place[a].rem_euclid(self.shape[a] as i32) } else { place[a] };
        std::array::from_fn(along)
    }

    /// The position one step further along an axis; see [`step`](Self::step).
    #[inline]
    pub fn next(&self, at: [u32; D], axis: usize) -> Option<[u32; D]> {
        let mut by = [0; D];
        by[axis] = 1;
        self.step(at, by)
    }

    /// All positions in row-major order.
    pub fn positions(&self) -> impl Iterator<Item = [u32; D]> + use<D> {
        let domain = *self;
        (0..domain.len()).map(move |i| domain.position(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_beyond_an_axis_are_wrapped_or_its_ends() {
        let d = Domain { shape: [3, 4], periodic: [false, true] };
        assert_eq!([-5, 0, 2, 3, 9].map(|p| d.nearest(0, p)), [0, 0, 2, 2, 2]);
        assert_eq!([-5, -1, 3, 4, 9].map(|p| d.nearest(1, p)), [3, 3, 3, 0, 1]);
        assert_eq!([(0, 2), (2, 0), (1, 1)].map(|(a, b)| d.apart(0, a, b)), [2, 2, 0]);
        assert_eq!([(0, 3), (3, 0), (0, 2), (1, 2)].map(|(a, b)| d.apart(1, a, b)), [1, 1, 2, 1]);
        assert_eq!([[-5, -5], [7, 7]].map(|p| d.wrapped(p)), [[-5, 3], [7, 3]]);
    }

    #[test]
    fn index_and_position_are_inverse() {
        let d = Domain::open([3, 4, 5]);
        for i in 0..d.len() {
            assert_eq!(d.index(d.position(i)), i);
        }
        assert_eq!(d.strides(), [20, 5, 1]);
    }

    #[test]
    fn steps_wrap_on_periodic_axes_only() {
        let d = Domain { shape: [4, 6], periodic: [false, true] };
        assert_eq!(d.step([0, 5], [1, 1]), Some([1, 0]));
        assert_eq!(d.step([0, 0], [0, -13]), Some([0, 5]));
        assert_eq!(d.step([0, 0], [-1, 0]), None);
        assert_eq!(d.step([3, 0], [1, 0]), None);
        assert_eq!(d.next([3, 5], 1), Some([3, 0]));
    }

    #[test]
    fn huge_shapes_have_no_length() {
        assert_eq!(Domain::open([u32::MAX, u32::MAX, u32::MAX]).checked_len(), None);
        assert!(Domain::open([0, 7]).is_empty());
    }
}
