//! What an energy is beside its graph.

use super::{Minimum, PairwiseTerm};
use crate::error::push;

/// The part that every labelling pays, and where the model pays less than the terms that were given.
#[derive(Clone, Debug, Default)]
pub(super) struct Books {
    pub(super) constant: i64,
    lowered: Vec<Lowered>,
}

/// A term whose `e00` was lowered `by` so much.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowered {
    pub(super) first: usize,
    pub(super) second: usize,
    pub(super) by: i64,
}

impl Books {
    pub(super) fn clear(&mut self) {
        self.constant = 0;
        self.lowered.clear();
    }

    /// Number of terms that were lowered.
    pub(super) fn len(&self) -> usize {
        self.lowered.len()
    }

    /// Notes a term, if it was lowered. Returns whether there was memory.
    #[must_use]
    pub(super) fn note(&mut self, term: Lowered) -> bool {
        term.by == 0 || push(&mut self.lowered, term)
    }

    /// Makes sure that one more can be noted. Returns whether there was memory.
    #[must_use]
    pub(super) fn reserve(&mut self) -> bool {
        self.lowered.try_reserve(1).is_ok()
    }

    /// What a labelling pays beside the capacity of its cut.
    pub(super) fn beside(&self, is_zero: &[bool]) -> i64 {
        let kept = self.lowered.iter().filter(|l| is_zero[l.first] && is_zero[l.second]);
        self.constant + kept.map(|l| l.by).sum::<i64>()
    }

    /// What label 0 everywhere pays beside the capacity of its cut.
    pub(super) fn beside_all_zero(&self) -> i64 {
        self.constant + self.lowered.iter().map(|l| l.by).sum::<i64>()
    }

    /// Completes a minimum whose cut has been found.
    pub(super) fn complete(&self, minimum: &mut Minimum, all_zero: i64) {
        minimum.before = all_zero + self.beside_all_zero();
        minimum.truncated = self.len();
        minimum.after = minimum.cut.flow + self.beside(&minimum.cut.in_source);
    }
}

/// A pairwise term as a constant, what label 1 adds at either node, and the capacities there and back.
///
/// By Kolmogorov and Zabih's construction, `e00 + u x + v y + a (1 - x) y + b x (1 - y)` with `u + v = e11 - e00`,
/// `a = e01 - e00 - v` and `b = e10 - e00 - u`: two unary terms and an arc each way. Where there is a choice, `u`
/// and `v` share their sum, so that a symmetric term is two equal arcs and nothing else: what goes through the
/// terminals has to be sent through the graph. If `a + b` is negative the term is not regular; then its `e00` is
/// lowered to `e01 + e10 - e11`.
pub(super) struct Parts {
    pub(super) constant: i64,
    pub(super) unaries: [i64; 2],
    pub(super) arcs: [i64; 2],
    /// By how much `e00` was lowered.
    pub(super) lowered: i64,
}

impl Parts {
    /// The parts of a term. `same`: its two nodes are one.
    #[inline]
    pub(super) fn of(term: PairwiseTerm, same: bool) -> Self {
        let [e00, e01, e10, e11] = [term.e00, term.e01, term.e10, term.e11].map(i64::from);
        if same {
            return Self { constant: e00, unaries: [0, e11 - e00], arcs: [0, 0], lowered: 0 };
        }
        let lowered = (e00 + e11 - e01 - e10).max(0);
        let constant = e00 - lowered;
        let (both, least, most) = (e11 - constant, e11 - e01, e10 - constant);
        let u = (both / 2).clamp(least, most);
        Self { constant, unaries: [u, both - u], arcs: [u - least, most - u], lowered }
    }
}
