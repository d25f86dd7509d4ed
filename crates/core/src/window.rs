//! Boxes in a domain: "wrap around, end here" for all who look at a part of an output.

use crate::{Domain, Error};

/// A box of positions of a domain. On periodic axes it may start before 0 or reach beyond the side: positions wrap. On
/// open axes it may stick out of the domain, where it has no places.
///
/// Sides and distances are below 2^31. Buffers over a window are row-major over its own shape, whatever of it lies
/// outside.
///
/// ```
/// use selvedge_core::{Domain, Window};
///
/// let output = Domain { shape: [4, 5], periodic: [false, true] };
/// let window = Window { start: [3, 4], shape: [2, 2] };
/// let places: Vec<Option<usize>> = window.places(output).collect();
/// assert_eq!(places, [Some(19), Some(15), None, None]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window<const D: usize> {
    /// The first position, not wrapped.
    pub start: [i32; D],
    /// Samples along each axis.
    pub shape: [u32; D],
}

impl<const D: usize> Window<D> {
    /// All of a domain.
    pub fn all(domain: Domain<D>) -> Self {
        Self { start: [0; D], shape: domain.shape }
    }

    /// Number of samples.
    ///
    /// # Panics
    /// If it does not fit `usize`.
    pub fn len(&self) -> usize {
        self.local().len()
    }

    /// True if any side is 0.
    pub fn is_empty(&self) -> bool {
        self.local().is_empty()
    }

    /// The window's own coordinates.
    pub fn local(&self) -> Domain<D> {
        Domain::open(self.shape)
    }

    /// One past the last position along an axis, not wrapped.
    #[inline]
    pub fn end(&self, axis: usize) -> i32 {
        self.start[axis] + self.shape[axis] as i32
    }

    /// The same window, so much further.
    #[must_use]
    pub fn moved(&self, by: [i32; D]) -> Self {
        Self { start: std::array::from_fn(|a| self.start[a] + by[a]), shape: self.shape }
    }

    /// `before` more samples on the low sides, `after` more on the high ones, as far as the domain reaches: open axes
    /// end, and around periodic ones no position comes twice.
    #[must_use]
    pub fn grown(&self, domain: Domain<D>, before: [u32; D], after: [u32; D]) -> Self {
        let mut grown = *self;
        for axis in 0..D {
            let side = domain.shape[axis];
            let spare = if domain.periodic[axis] { side.saturating_sub(self.shape[axis]) } else { u32::MAX };
            let before = before[axis].min(spare);
            let after = after[axis].min(spare - before);
            let mut start = i64::from(self.start[axis]) - i64::from(before);
            let mut end = i64::from(self.end(axis)) + i64::from(after);
            if !domain.periodic[axis] {
                (start, end) = (start.max(0), end.min(side.into()));
            }
            grown.start[axis] = start as i32;
            grown.shape[axis] = (end - start).max(0) as u32;
        }
        grown
    }

    /// As far as it lies in the domain: cut off at the ends of open axes. Empty where it does not.
    #[must_use]
    pub fn inside(&self, domain: Domain<D>) -> Self {
        let mut inside = *self;
        for axis in (0..D).filter(|&a| !domain.periodic[a]) {
            let end = self.end(axis).min(domain.shape[axis] as i32);
            inside.start[axis] = self.start[axis].max(0);
            inside.shape[axis] = (end - inside.start[axis]).max(0) as u32;
        }
        inside
    }

    /// What two windows share; positions are compared unwrapped. `None` if nothing.
    pub fn shared(&self, other: &Self) -> Option<Self> {
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

    /// True if the windows share a position of the domain, wrapped or not.
    pub fn meets(&self, other: &Self, domain: Domain<D>) -> bool {
        (0..D).all(|axis| {
            let gap = i64::from(other.start[axis]) - i64::from(self.start[axis]);
            let (mine, theirs, side) =
                (i64::from(self.shape[axis]), i64::from(other.shape[axis]), i64::from(domain.shape[axis]));
            if domain.periodic[axis] {
                let gap = gap.rem_euclid(side);
                gap < mine || side - gap < theirs
            } else {
                -theirs < gap && gap < mine
            }
        })
    }

    /// The position of the domain under one of the window's own; `None` outside of an open axis.
    #[inline]
    pub fn position(&self, domain: Domain<D>, local: [u32; D]) -> Option<[u32; D]> {
        domain.step([0; D], std::array::from_fn(|a| self.start[a] + local[a] as i32))
    }

    /// A position of the domain in the turn of its periodic axes in which the window is.
    pub fn unwrapped(&self, domain: Domain<D>, at: [u32; D]) -> [i32; D] {
        std::array::from_fn(|a| {
            let (p, side) = (at[a] as i32, domain.shape[a] as i32);
            if domain.periodic[a] { self.start[a] + (p - self.start[a]).rem_euclid(side) } else { p }
        })
    }

    /// Place in the domain's buffer of each coordinate along an axis, times its stride; `None` outside of an open axis.
    pub fn along(&self, domain: Domain<D>, axis: usize) -> impl Iterator<Item = Option<u32>> + use<D> {
        let (stride, side) = (domain.strides()[axis] as u32, domain.shape[axis] as i32);
        let (periodic, start) = (domain.periodic[axis], self.start[axis]);
        (0..self.shape[axis] as i32).map(move |l| {
            let p = start + l;
            let p = if periodic { p.rem_euclid(side) } else { p };
            (0 <= p && p < side).then(|| p as u32 * stride)
        })
    }

    /// Place in the domain's buffer of each of the window's positions, row-major; `None` outside of open axes.
    pub fn places(&self, domain: Domain<D>) -> impl ExactSizeIterator<Item = Option<usize>> + use<D> {
        Places::<D>::new(std::array::from_fn(|axis| self.along(domain, axis).collect()))
    }

    /// Place in the domain's buffer of each position that has one, row-major, in a vector that is used again.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn indices(&self, domain: Domain<D>, to: &mut Vec<u32>) -> Result<(), Error> {
        emptied(to, self.local().checked_len())?;
        to.extend(self.places(domain).flatten().map(|place| place as u32));
        Ok(())
    }
}

/// Places of a box's positions, row-major, from those of its coordinates along each axis, times its stride.
#[derive(Debug)]
struct Places<const D: usize> {
    along: [Vec<Option<u32>>; D],
    /// The next position.
    at: [usize; D],
    /// What all axes but the last add up to there.
    row: Option<u32>,
    /// Positions left.
    left: usize,
}

impl<const D: usize> Places<D> {
    fn new(along: [Vec<Option<u32>>; D]) -> Self {
        let left = along.iter().map(Vec::len).product();
        let mut places = Self { along, at: [0; D], row: None, left };
        if 0 < left {
            places.row = places.row();
        }
        places
    }

    fn row(&self) -> Option<u32> {
        self.along[..D - 1].iter().zip(self.at).try_fold(0, |sum, (along, at)| Some(sum + along[at]?))
    }

    /// Goes on at the beginning of the next row.
    fn next_row(&mut self) {
        for axis in (0..D).rev() {
            if self.at[axis] < self.along[axis].len() {
                break;
            }
            self.at[axis] = 0;
            if 0 < axis {
                self.at[axis - 1] += 1;
            }
        }
        self.row = self.row();
    }
}

impl<const D: usize> Iterator for Places<D> {
    type Item = Option<usize>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        self.left = self.left.checked_sub(1)?;
        let (last, x) = (&self.along[D - 1], self.at[D - 1]);
        let place = self.row.and_then(|row| last[x].map(|last| (row + last) as usize));
        self.at[D - 1] += 1;
        if self.at[D - 1] == last.len() {
            self.next_row();
        }
        Some(place)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl<const D: usize> ExactSizeIterator for Places<D> {}

/// A vector without items and with room for `len` of them.
///
/// # Errors
/// [`Error::Allocation`].
pub(crate) fn emptied<T>(to: &mut Vec<T>, len: Option<usize>) -> Result<(), Error> {
    to.clear();
    let bytes = len.map_or(u64::MAX, |n| (n as u64).saturating_mul(size_of::<T>() as u64));
    to.try_reserve_exact(len.unwrap_or(usize::MAX)).map_err(|_| Error::Allocation { bytes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    #[test]
    fn windows_wrap_on_periodic_axes_and_end_on_open_ones() {
        let output = Domain { shape: [4, 5], periodic: [false, true] };
        let w = Window { start: [2, 3], shape: [2, 3] };
        let mut indices = vec![7; 40];
        w.indices(output, &mut indices).unwrap();
        assert_eq!(indices, [13, 14, 10, 18, 19, 15]);
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

    /// A small domain and windows that stick out of it, go around it, or miss it.
    fn cases() -> impl Iterator<Item = (Domain<3>, [Window<3>; 2])> {
        (0..300).map(|case| {
            let mut rng = Seed(case).rng();
            let shape = std::array::from_fn(|_| 2 + rng.below(4));
            let output = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 1) };
            let windows = [0; 2].map(|_: u8| {
                // No position twice.
                let shape = std::array::from_fn(|a| rng.below(1 + if output.periodic[a] { shape[a] } else { 6 }));
                Window { start: std::array::from_fn(|_| rng.below(7) as i32 - 3), shape }
            });
            (output, windows)
        })
    }

    /// The definition: a step from the first position of all.
    fn places(window: &Window<3>, output: Domain<3>) -> Vec<Option<usize>> {
        let at = |local: [u32; 3]| std::array::from_fn(|a| window.start[a] + local[a] as i32);
        window.local().positions().map(|local| output.step([0; 3], at(local)).map(|at| output.index(at))).collect()
    }

    #[test]
    fn places_are_steps_from_the_first_position() {
        let mut outside = 0;
        for (output, [window, _]) in cases() {
            let expected = places(&window, output);
            assert_eq!(window.places(output).len(), expected.len());
            assert_eq!(window.places(output).collect::<Vec<_>>(), expected, "{window:?} in {output:?}");
            let of = |local| window.position(output, local).map(|at| output.index(at));
            assert_eq!(window.local().positions().map(of).collect::<Vec<_>>(), expected);
            for at in window.local().positions().filter_map(|local| window.position(output, local)) {
                let back = window.unwrapped(output, at);
                let local = std::array::from_fn(|a| (back[a] - window.start[a]) as u32);
                assert_eq!(window.position(output, local), Some(at));
            }
            outside += expected.iter().filter(|p| p.is_none()).count();
        }
        assert!(0 < outside);
    }

    #[test]
    fn windows_meet_where_they_share_a_place_and_grow_no_further_than_the_domain() {
        let mut met = 0;
        for (output, [a, b]) in cases() {
            let [of_a, of_b] = [&a, &b].map(|w| places(w, output));
            let share = of_a.iter().flatten().any(|place| of_b.contains(&Some(*place)));
            let inside = |w: &Window<3>| w.inside(output);
            assert_eq!(
                !inside(&a).is_empty() && !inside(&b).is_empty() && inside(&a).meets(&inside(&b), output),
                share
            );
            assert_eq!(places(&inside(&a), output).len(), of_a.iter().flatten().count());
            met += u32::from(share);
            let grown = inside(&a).grown(output, [2, 0, u32::MAX], [1, 3, 0]);
            let mut of_grown: Vec<_> = places(&grown, output);
            assert!(inside(&a).is_empty() || of_a.iter().flatten().all(|p| of_grown.contains(&Some(*p))));
            assert!(inside(&a).is_empty() || of_grown.iter().all(Option::is_some));
            of_grown.sort_unstable();
            assert!(of_grown.windows(2).all(|pair| pair[0] != pair[1]), "each once");
        }
        assert!(20 < met && met < 280, "{met}");
    }

    #[test]
    fn no_memory_is_an_error() {
        let huge = Window { start: [0; 3], shape: [1 << 30; 3] };
        let found = huge.indices(Domain::open([2; 3]), &mut Vec::new());
        assert_eq!(found, Err(Error::Allocation { bytes: u64::MAX }));
    }
}
