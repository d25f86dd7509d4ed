//! Energies of binary labels, straight into a grid's arrays.
//!
//! What [`BinaryEnergy`](crate::BinaryEnergy) does with any term takes several looks at the same node, each with its
//! checks. Here is the short way for terms of which one look shows that nothing can be wrong: no mask, no number near
//! its limit, and regular. That is nearly all of them, and the rest is refused: whoever asked goes the long way. Sums
//! are kept in registers over a run of terms, which are twice as fast in a run as one by one.

use super::GridGraph;
use super::residual::role;
use crate::energy::PairwiseTerm;
use crate::network::Role;

/// Terms of numbers from `-SMALL` to below `SMALL` make links within `MAX_LINK`. A power of two.
const SMALL: i32 = GridGraph::<1>::MAX_LINK / 8;
/// Excess from `-HIGH` to below `HIGH` is within its limits. A power of two.
const HIGH: i32 = GridGraph::<1>::MAX_TERMINAL + 1;

/// Whether all values lie from `-limit` to below `limit`, a power of two.
#[inline(always)]
fn within(limit: i32, values: &[i32]) -> bool {
    let any = values.iter().fold(0, |any, v| any | v.wrapping_add(limit) as u32);
    any < 2 * limit as u32
}

/// What was added.
#[derive(Clone, Copy, Default)]
struct Added {
    terms: usize,
    /// Paid for all labels.
    constant: i64,
    /// Capacity out of the source.
    source: i64,
}

impl<const D: usize> GridGraph<D> {
    /// Adds an energy for either label to nodes from one on, as long as they may be, and returns to how many, and the
    /// part that is paid for all labels.
    #[inline]
    pub(crate) fn add_unaries(&mut self, first: usize, energies: &[[i32; 2]]) -> (usize, i64) {
        let end = first + energies.len();
        if end > self.lattice.len {
            return (0, 0);
        }
        let slots = first + self.lattice.margin..end + self.lattice.margin;
        let mut added = Added::default();
        for ((excess, &flags), &[e0, e1]) in self.excess[slots.clone()].iter_mut().zip(&self.flags[slots]).zip(energies)
        {
            let new = excess.wrapping_add(e1.wrapping_sub(e0));
            if !within(HIGH, &[new, e0, e1]) || role(flags) == Role::Masked {
                break;
            }
            *excess = new;
            added.source += i64::from((e1 - e0).max(0));
            added.constant += i64::from(e0.min(e1));
            added.terms += 1;
        }
        self.note(added)
    }

    /// Adds terms to the nodes of slots from `v` on and of slots from `w` on, the next of those of `v` in direction
    /// `d`; else as [`add_unaries`](Self::add_unaries).
    #[inline]
    pub(crate) fn add_pairwises(&mut self, d: usize, (v, w): (usize, usize), terms: &[PairwiseTerm]) -> (usize, i64) {
        if v == w {
            return (0, 0);
        }
        let added = match self.lattice.directions {
            2 => self.add_run::<2>(d, v, w, terms),
            4 => self.add_run::<4>(d, v, w, terms),
            6 => self.add_run::<6>(d, v, w, terms),
            _ => self.add_run::<8>(d, v, w, terms),
        };
        self.note(added)
    }

    #[inline]
    fn note(&mut self, added: Added) -> (usize, i64) {
        self.touched |= added.terms > 0;
        self.source_total += added.source;
        (added.terms, added.constant)
    }

    #[inline]
    fn add_run<const K: usize>(&mut self, d: usize, v: usize, w: usize, terms: &[PairwiseTerm]) -> Added {
        let mut added = Added::default();
        let (caps, excess, flags) = (self.caps.as_chunks_mut::<K>().0, &mut self.excess[..], &self.flags[..]);
        for (i, &PairwiseTerm { e00, e01, e10, e11 }) in terms.iter().enumerate() {
            let (v, w) = (v + i, w + i);
            let masked = (role(flags[v]) == Role::Masked) | (role(flags[w]) == Role::Masked);
            if !within(SMALL, &[e00, e01, e10, e11]) | masked || e00 + e11 > e01 + e10 {
                break;
            }
            // As `energy::Parts`.
            let (both, least, most) = (e11 - e00, e11 - e01, e10 - e00);
            let of_v = (both / 2).max(least).min(most);
            let of_w = both - of_v;
            let [out, back] = [caps[v][d] + of_v - least, caps[w][d ^ 1] + most - of_v];
            let [of_v_then, of_w_then] = [excess[v].wrapping_add(of_v), excess[w].wrapping_add(of_w)];
            if !within(HIGH, &[of_v_then, of_w_then]) | (out + back > Self::MAX_LINK) {
                break;
            }
            (caps[v][d], caps[w][d ^ 1]) = (out, back);
            (excess[v], excess[w]) = (of_v_then, of_w_then);
            added.source += i64::from(of_v.max(0)) + i64::from(of_w.max(0));
            added.constant += i64::from(e00 + of_v.min(0) + of_w.min(0));
            added.terms += 1;
        }
        added
    }

    /// Runs of nodes along an axis, in node order: slot of the first, slot of its next, and how many; 0 in place of the
    /// next where there is none.
    pub(crate) fn runs(&self, axis: usize) -> impl Iterator<Item = ([usize; 2], usize)> + use<D> {
        let (side, periodic, first) = (self.lattice.shape[axis], self.lattice.periodic[axis], self.lattice.margin);
        let stride: usize = self.lattice.shape[axis + 1..].iter().product();
        let (inner, line) = (stride * (side - 1), stride * side);
        (first..first + self.lattice.len).step_by(line).flat_map(move |start| {
            let last = start + inner;
            [([start, start + stride], inner), ([last, if periodic { start } else { 0 }], stride)]
        })
    }
}
