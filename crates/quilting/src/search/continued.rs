//! Verbatim continuations, and what is near them.

/// How far from a continuation a block is one itself, in samples on each axis: one or two samples beside it, most of
/// the structures that go on are still nearly in line. Chosen by reason, not by trial; a larger one takes candidates
/// from small exemplars, `(2 n + 1)^2` for each neighbour.
const NEAR: i64 = 2;

/// Where a block next to one would go on in its source: the top left sample, which may lie outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Successor {
    /// The source.
    pub source: usize,
    /// The top left sample.
    pub at: [i64; 2],
}

impl Successor {
    /// True for places within two samples of it.
    pub fn is_near(&self, source: usize, at: [u32; 2]) -> bool {
        source == self.source && at.iter().zip(self.at).all(|(&a, b)| (i64::from(a) - b).abs() <= NEAR)
    }

    /// All places near it, by source and top left sample.
    pub(crate) fn around(&self) -> impl Iterator<Item = (usize, [i64; 2])> + use<> {
        let Self { source, at: [y, x] } = *self;
        (y - NEAR..=y + NEAR).flat_map(move |y| (x - NEAR..=x + NEAR).map(move |x| (source, [y, x])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_two_samples_on_both_axes() {
        let to = Successor { source: 3, at: [4, 4] };
        let mut found = 0;
        for (y, x) in (0..9_u32).flat_map(|y| (0..9_u32).map(move |x| (y, x))) {
            let is_near = to.is_near(3, [y, x]);
            assert_eq!(is_near, y.abs_diff(4) <= 2 && x.abs_diff(4) <= 2);
            assert!(!to.is_near(2, [y, x]));
            found += u32::from(is_near);
        }
        assert_eq!(found, 25);
        assert!(to.around().all(|(source, at)| to.is_near(source, at.map(|v| v as u32))));
        assert_eq!(to.around().count(), 25);
    }
}
