//! What neighbours and samples cost.

use selvedge_core::{SampleId, SeamCosts};

/// Prices of the four ways to decide two neighbours `s` and `t`: who takes the offer is in the name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quad {
    /// Both keep what they have.
    pub neither: i32,
    /// `t` alone takes the offer.
    pub t: i32,
    /// `s` alone takes the offer.
    pub s: i32,
    /// Both take it.
    pub both: i32,
}

/// What a move asks: an energy of neighbours and, if need be, of single samples, in integers on one scale.
///
/// Prices of pairs lie from 0 to [`SeamCosts::MAX`], those of single samples within ±2^28.
pub trait Prices<const D: usize> {
    /// The price of `here` and `there` as neighbours along an axis. Either may be unassigned: with
    /// [`Holes::Free`](crate::Holes) beside a hole that stays one.
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32;

    /// The price of a sample at a place of the output. With [`Holes::Free`](crate::Holes) the unassigned sample has one
    /// as well. Default: 0.
    #[inline]
    fn unary(&self, _place: usize, _sample: SampleId) -> i32 {
        0
    }

    /// How much an offer differs from what is there, asked once a sample and handed to [`quad`](Self::quad). Default:
    /// 0.
    #[inline]
    fn difference(&self, _old: SampleId, _new: SampleId) -> u32 {
        0
    }

    /// All four prices of two neighbours that both have a choice. Default: [`pair`](Self::pair), four times; worth more
    /// where they have parts in common.
    #[inline]
    fn quad(&self, axis: usize, old: [SampleId; 2], new: [SampleId; 2], _differences: [u32; 2]) -> Quad {
        Quad {
            neither: self.pair(axis, old[0], old[1]),
            t: self.pair(axis, old[0], new[1]),
            s: self.pair(axis, new[0], old[1]),
            both: self.pair(axis, new[0], new[1]),
        }
    }
}

/// Seams, and nothing else; beside a hole there is none.
impl<const D: usize> Prices<D> for SeamCosts<D> {
    #[inline]
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        if here.is_assigned() && there.is_assigned() { self.between(axis, here, there) } else { 0 }
    }

    #[inline]
    fn difference(&self, old: SampleId, new: SampleId) -> u32 {
        if old.is_assigned() && new.is_assigned() { self.norm(old, new) } else { 0 }
    }

    #[inline]
    fn quad(&self, axis: usize, old: [SampleId; 2], new: [SampleId; 2], differences: [u32; 2]) -> Quad {
        let goes_on = |[s, t]: [SampleId; 2]| s.is_assigned() && self.continued(s, 2 * axis) == Some(t);
        if goes_on(old) && goes_on(new) {
            // No seam on either side: one between them costs the same whichever takes the patch.
            let price = self.weigh(axis, differences[0] + differences[1], [old[0], new[0], old[1], new[1]]);
            return Quad { neither: 0, t: price, s: price, both: 0 };
        }
        let pair = |here, there| Prices::pair(self, axis, here, there);
        Quad {
            neither: pair(old[0], old[1]),
            t: pair(old[0], new[1]),
            s: pair(new[0], old[1]),
            both: pair(new[0], new[1]),
        }
    }
}
