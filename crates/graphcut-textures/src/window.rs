//! Boxes in the output: error regions and the windows of patches.

use selvedge_core::Domain;

/// A box of output positions. On periodic axes it may start before 0 or reach beyond the side: positions wrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window<const D: usize> {
    /// The first position, not wrapped.
    pub(crate) start: [i32; D],
    /// Samples along each axis.
    pub(crate) shape: [u32; D],
}

impl<const D: usize> Window<D> {
    /// The whole output.
    pub(crate) fn all(output: Domain<D>) -> Self {
        Self { start: [0; D], shape: output.shape }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().map(|&n| n as usize).product()
    }

    /// One past the last position along an axis.
    pub(crate) fn end(&self, axis: usize) -> i32 {
        self.start[axis] + self.shape[axis] as i32
    }

    /// `before` more samples on the low sides, `after` more on the high ones, as far as the output reaches.
    pub(crate) fn grown(&self, output: Domain<D>, before: [u32; D], after: [u32; D]) -> Self {
        let mut grown = *self;
        for axis in 0..D {
            let side = output.shape[axis];
            // Around a periodic axis there is only so much more: positions must not come twice.
            let spare = if output.periodic[axis] { side.saturating_sub(self.shape[axis]) } else { u32::MAX };
            let before = before[axis].min(spare);
            let after = after[axis].min(spare - before);
            let (mut start, mut end) = (self.start[axis] - before as i32, self.end(axis) + after as i32);
            if !output.periodic[axis] {
                (start, end) = (start.max(0), end.min(side as i32));
            }
            grown.start[axis] = start;
            grown.shape[axis] = (end - start) as u32;
        }
        grown
    }

    /// As far as it lies in the output: cut off at the ends of open axes. It must meet the output.
    pub(crate) fn inside(&self, output: Domain<D>) -> Self {
        let mut inside = *self;
        for axis in (0..D).filter(|&a| !output.periodic[a]) {
            let end = self.end(axis).min(output.shape[axis] as i32);
            inside.start[axis] = self.start[axis].max(0);
            inside.shape[axis] = (end - inside.start[axis]) as u32;
        }
        inside
    }

    /// What two windows share; positions are compared unwrapped. `None` if nothing.
    pub(crate) fn shared(&self, other: &Self) -> Option<Self> {
        let mut shared = *self;
        for axis in 0..D {
            let start = self.start[axis].max(other.start[axis]);
            let end = self.end(axis).min(other.end(axis));
            if end <= start {
                return None;
            }
            (shared.start[axis], shared.shape[axis]) = (start, (end - start) as u32);
        }
        Some(shared)
    }

    /// True if the windows share a position of the output, wrapped or not.
    pub(crate) fn meets(&self, other: &Self, output: Domain<D>) -> bool {
        (0..D).all(|axis| {
            let gap = i64::from(other.start[axis]) - i64::from(self.start[axis]);
            let (mine, theirs, side) =
                (i64::from(self.shape[axis]), i64::from(other.shape[axis]), i64::from(output.shape[axis]));
            if output.periodic[axis] {
                let gap = gap.rem_euclid(side);
                gap < mine || side - gap < theirs
            } else {
                -theirs < gap && gap < mine
            }
        })
    }

    /// Place in the output's buffer of each coordinate along an axis, times its stride; `None` outside of an open axis.
    pub(crate) fn places(&self, output: Domain<D>, axis: usize) -> impl Iterator<Item = Option<u32>> + use<D> {
        let (stride, side) = (output.strides()[axis] as u32, output.shape[axis] as i32);
        let (periodic, start) = (output.periodic[axis], self.start[axis]);
        (0..self.shape[axis] as i32).map(move |l| {
            let p = start + l;
            let p = if periodic { p.rem_euclid(side) } else { p };
            (0 <= p && p < side).then(|| p as u32 * stride)
        })
    }

    /// Place in the output's buffer of each position, row-major. Positions outside of open axes are left out.
    pub(crate) fn indices(&self, output: Domain<D>) -> Vec<u32> {
        over_axes::<D>(|axis| self.places(output, axis).collect()).into_iter().flatten().collect()
    }
}

/// Places of a box's positions, row-major, from those of its coordinates along each axis, times its stride; `None` where a
/// coordinate has none.
pub(crate) fn over_axes<const D: usize>(along: impl Fn(usize) -> Vec<Option<u32>>) -> Vec<Option<u32>> {
    (0..D).fold(vec![Some(0)], |places, axis| {
        let along = along(axis);
        places.iter().flat_map(|p| along.iter().map(move |a| Some((*p)? + (*a)?))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_wrap_on_periodic_axes_and_end_on_open_ones() {
        let output = Domain { shape: [4, 5], periodic: [false, true] };
        let w = Window { start: [2, 3], shape: [2, 3] };
        assert_eq!(w.indices(output), [13, 14, 10, 18, 19, 15]);
        let grown = w.grown(output, [1, 1], [1, 1]);
        assert_eq!(grown, Window { start: [1, 2], shape: [3, 5] });
        let all = Window { start: [0, 3], shape: [4, 5] };
        assert_eq!(all.grown(output, [1, 1], [1, 1]), all);
        assert!(w.meets(&Window { start: [3, 0], shape: [1, 1] }, output));
        assert!(!w.meets(&Window { start: [3, 1], shape: [1, 1] }, output));
        assert!(!w.meets(&Window { start: [0, 3], shape: [2, 1] }, output));
    }

    #[test]
    fn shared_parts_are_intersections() {
        let a = Window { start: [-1, 2], shape: [4, 4] };
        let b = Window { start: [1, 0], shape: [9, 3] };
        assert_eq!(a.shared(&b), Some(Window { start: [1, 2], shape: [2, 1] }));
        assert_eq!(a.shared(&Window { start: [3, 0], shape: [1, 9] }), None);
    }
}
