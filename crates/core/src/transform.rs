//! Orientations of an exemplar, and the way back to its own samples.

use crate::Domain;
use crate::resampling::Resampling;

/// How a source was made from its exemplar.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Transform {
    /// Mirrored left to right or not, then turned clockwise, over the last two axes: no sample changes.
    Exact {
        /// Clockwise quarter turns, 0..4.
        quarter_turns: u8,
        /// Mirrored left to right before turning.
        mirror: bool,
    },
    /// Mirrored left to right or not, then turned about its centre by any angle and magnified, over the last two axes:
    /// samples are interpolated (Catmull-Rom, averaged over several spots where it shrinks), and the corners that the
    /// turned exemplar does not reach are not valid.
    Resampled {
        /// Clockwise angle in degrees.
        degrees: f64,
        /// Magnification, `1/16` to 16.
        scale: f64,
        /// Mirrored left to right before turning.
        mirror: bool,
    },
}

impl Transform {
    /// The exemplar as it is.
    pub const IDENTITY: Self = Self::Exact { quarter_turns: 0, mirror: false };

    /// Mirrored left to right or not, turned clockwise by `degrees` and magnified: exact wherever that copies samples.
    pub fn new(degrees: f64, scale: f64, mirror: bool) -> Self {
        let degrees = degrees.rem_euclid(360.0);
        if scale == 1.0 && degrees % 90.0 == 0.0 {
            // A full turn is what a tiny negative angle is rounded to.
            Self::Exact { quarter_turns: (degrees / 90.0) as u8 % 4, mirror }
        } else {
            Self::Resampled { degrees, scale, mirror }
        }
    }

    /// True if angle and magnification are numbers in their range.
    pub fn is_valid(self) -> bool {
        match self {
            Self::Exact { .. } => true,
            Self::Resampled { degrees, scale, .. } => degrees.is_finite() && (1.0 / 16.0..=16.0).contains(&scale),
        }
    }

    /// How a resampled source is made; `None` for an exact one.
    pub(crate) fn resampling(self) -> Option<Resampling> {
        match self {
            Self::Exact { .. } => None,
            Self::Resampled { degrees, scale, mirror } => Some(Resampling::new(degrees, scale, mirror)),
        }
    }

    /// The shape of a source made from an exemplar of this domain.
    pub fn domain<const D: usize>(self, mut exemplar: Domain<D>) -> Domain<D> {
        let quarter_turns = match self {
            Self::Exact { quarter_turns, .. } => quarter_turns,
            Self::Resampled { degrees, scale, mirror } => {
                return Resampling::new(degrees, scale, mirror).domain(exemplar);
            }
        };
        if quarter_turns % 2 == 1 {
            exemplar.shape.swap(D - 2, D - 1);
            exemplar.periodic.swap(D - 2, D - 1);
        }
        exemplar
    }

    /// The exemplar's position whose sample stands at `at` in the source; `source` is the source's domain.
    ///
    /// # Panics
    /// For resampled sources, whose samples stand between those of the exemplar.
    pub fn origin<const D: usize>(self, source: Domain<D>, at: [u32; D]) -> [u32; D] {
        let Self::Exact { quarter_turns, mirror } = self else { panic!("{self:?} copies no samples") };
        let (mut h, mut w) = (source.shape[D - 2], source.shape[D - 1]);
        let (mut y, mut x) = (at[D - 2], at[D - 1]);
        for _ in 0..quarter_turns % 4 {
            // A clockwise turn moves the exemplar's (y, x) to (x, height - 1 - y).
            (y, x) = (w - 1 - x, y);
            (h, w) = (w, h);
        }
        if mirror {
            x = w - 1 - x;
        }
        debug_assert!(y < h && x < w);
        let mut from = at;
        (from[D - 2], from[D - 1]) = (y, x);
        from
    }

    /// Clockwise degrees from 0 to 360, and whether it mirrors before it turns: what is left of it without its scale.
    pub fn orientation(self) -> (f64, bool) {
        match self {
            Self::Exact { quarter_turns, mirror } => (90.0 * f64::from(quarter_turns % 4), mirror),
            Self::Resampled { degrees, mirror, .. } => (degrees.rem_euclid(360.0), mirror),
        }
    }

    /// Where a place of a source lies in its exemplar: samples down and right of the centre, on the last two axes, in
    /// both.
    pub fn from_centre(self, at: [f64; 2]) -> [f64; 2] {
        let (degrees, mirror) = self.orientation();
        let scale = if let Self::Resampled { scale, .. } = self { scale } else { 1.0 };
        Resampling::new(degrees, scale, mirror).undo(at)
    }

    /// Where a vector of the exemplar (x right, y up) points in the source: for each of x and y, which
    /// component it takes (0 = x, 1 = y) and whether it is negated.
    pub(crate) fn vector(self) -> [(usize, bool); 2] {
        let Self::Exact { quarter_turns, mirror } = self else { return [(0, false), (1, false)] };
        let mut v = [(0, mirror), (1, false)];
        for _ in 0..quarter_turns % 4 {
            v = [v[1], (v[0].0, !v[0].1)];
        }
        v
    }
}

/// Which exemplar a source was made from, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// The exemplar's number, from 0, in the order given.
    pub exemplar: u16,
    /// How it was turned.
    pub transform: Transform,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_from_the_centre_agree_with_origins() {
        for quarter_turns in 0..4 {
            for mirror in [false, true] {
                let transform = Transform::Exact { quarter_turns, mirror };
                let (exemplar, source) = (Domain::open([4, 7]), transform.domain(Domain::open([4, 7])));
                let centred = |domain: Domain<2>, at: [u32; 2]| {
                    [0, 1].map(|a| f64::from(at[a]) - (f64::from(domain.shape[a]) - 1.0) / 2.0)
                };
                for at in source.positions() {
                    let (found, expected) =
                        (transform.from_centre(centred(source, at)), centred(exemplar, transform.origin(source, at)));
                    assert!((0..2).all(|a| (found[a] - expected[a]).abs() < 1e-9), "{transform:?} {at:?}");
                }
            }
        }
    }

    #[test]
    fn a_clockwise_turn_moves_the_top_row_to_the_right() {
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let source = turn.domain(Domain::open([2, 3]));
        assert_eq!(source.shape, [3, 2]);
        assert_eq!(turn.origin(source, [0, 1]), [0, 0], "the top left sample stands at the top right");
        assert_eq!(turn.origin(source, [0, 0]), [1, 0]);
        assert_eq!(turn.origin(source, [2, 1]), [0, 2]);
    }

    #[test]
    fn only_quarter_turns_at_full_size_are_exact() {
        let exact = |quarter_turns, mirror| Transform::Exact { quarter_turns, mirror };
        assert_eq!(Transform::new(0.0, 1.0, true), exact(0, true));
        assert_eq!(Transform::new(-90.0, 1.0, false), exact(3, false));
        assert_eq!(Transform::new(720.0 + 180.0, 1.0, true), exact(2, true));
        assert_eq!(Transform::new(-1e-30, 1.0, false), exact(0, false));
        let half = Transform::Resampled { degrees: 90.0, scale: 0.5, mirror: false };
        assert_eq!(Transform::new(-270.0, 0.5, false), half);
        assert!(!Transform::new(f64::NAN, 1.0, false).is_valid());
    }

    #[test]
    fn every_orientation_is_a_permutation() {
        for quarter_turns in 0..4 {
            for mirror in [false, true] {
                let t = Transform::Exact { quarter_turns, mirror };
                let exemplar = Domain::open([2, 3, 5]);
                let source = t.domain(exemplar);
                let mut seen: Vec<_> = source.positions().map(|p| exemplar.index(t.origin(source, p))).collect();
                seen.sort_unstable();
                assert_eq!(seen, (0..30).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn vectors_turn_with_the_picture() {
        let turn = |quarter_turns| Transform::Exact { quarter_turns, mirror: false }.vector();
        // What pointed up (0, 1) points right (1, 0) after a clockwise turn: x takes y, y takes -x.
        assert_eq!(turn(1), [(1, false), (0, true)]);
        assert_eq!(turn(2), [(0, true), (1, true)]);
        assert_eq!(Transform::Exact { quarter_turns: 0, mirror: true }.vector(), [(0, true), (1, false)]);
    }
}
