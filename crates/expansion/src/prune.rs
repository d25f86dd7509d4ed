//! Samples that keep what they have because nothing could pay for the change.
//!
//! Taking the offer costs a sample the difference of its own prices, and saves at most, over each neighbour, the most
//! that either decision of that neighbour lets it save. Where the cost is greater than all savings together, every best
//! decision keeps the sample. (Where both are equal, the cut decides: of equal cuts that with most takers is made.)
//! Once it is decided its neighbours can save less: so it goes on outward until nothing more follows.

use selvedge_core::try_vec;

use crate::choice::Choice;
use crate::error::Error;
use crate::frame::Frame;
use crate::prices::Prices;

/// The choices with those samples decided; `None` where own prices speak against no offer.
///
/// # Errors
/// [`Error::Core`] if memory is short.
///
/// # Complexity
/// `O(frame)`: a sample is decided once, and looked at again once for each neighbour that is.
pub(crate) fn prune<const D: usize>(
    frame: &Frame<D>,
    choices: &[Choice],
    prices: &impl Prices<D>,
    differences: &[u32],
) -> Result<Option<Vec<Choice>>, Error> {
    let free = || choices.iter().enumerate().filter(|(_, c)| **c == Choice::Free).map(|(i, _)| i);
    let excess = |i: usize| {
        let [old, new] = [frame.old[i], frame.new[i]].map(|id| i64::from(prices.unary(frame.places[i] as usize, id)));
        new - old
    };
    if free().all(|i| excess(i) <= 0) {
        return Ok(None);
    }
    let mut pruning = Pruning { frame, prices, differences, choices: try_vec(choices.len(), Choice::Empty)? };
    pruning.choices.copy_from_slice(choices);
    let mut margins = try_vec(choices.len(), 0_i64)?;
    free().for_each(|i| margins[i] = excess(i));
    for axis in 0..D {
        for (s, t) in frame.pairs(axis) {
            let [of_s, of_t] = pruning.savings(axis, s, t);
            margins[s] -= of_s;
            margins[t] -= if s == t { 0 } else { of_t };
        }
    }
    let mut decided: Vec<usize> = free().filter(|&i| 0 < margins[i]).collect();
    while let Some(i) = decided.pop() {
        for (axis, s, t) in pruning.neighbours(i) {
            let j = if s == i { t } else { s };
            let of = |savings: [i64; 2]| savings[usize::from(j == t)];
            if pruning.choices[j] == Choice::Free && margins[j] <= 0 {
                let could = of(pruning.savings(axis, s, t));
                pruning.choices[i] = Choice::Old;
                margins[j] += could - of(pruning.savings(axis, s, t));
                pruning.choices[i] = Choice::Free;
                if 0 < margins[j] {
                    decided.push(j);
                }
            }
        }
        pruning.choices[i] = Choice::Old;
    }
    Ok(Some(pruning.choices))
}

struct Pruning<'a, P, const D: usize> {
    frame: &'a Frame<D>,
    prices: &'a P,
    differences: &'a [u32],
    choices: Vec<Choice>,
}

impl<P: Prices<D>, const D: usize> Pruning<'_, P, D> {
    /// The most that `s` and `t` may each save between them by taking the offer; 0 for one that has no choice.
    fn savings(&self, axis: usize, s: usize, t: usize) -> [i64; 2] {
        let (old, new) = (&self.frame.old, &self.frame.new);
        let price = |here, there| i64::from(self.prices.pair(axis, here, there));
        match (self.choices[s], self.choices[t]) {
            (Choice::Free, Choice::Free) => {
                let differences = [self.differences[s], self.differences[t]];
                let quad = self.prices.quad(axis, [old[s], old[t]], [new[s], new[t]], differences);
                let [neither, of_t, of_s, both] = [quad.neither, quad.t, quad.s, quad.both].map(i64::from);
                if s == t {
                    return [neither - both; 2];
                }
                [(neither - of_s).max(of_t - both), (neither - of_t).max(of_s - both)]
            }
            (Choice::Free, Choice::Old | Choice::New) => {
                let there = self.frame.decided(&self.choices, t);
                [price(old[s], there) - price(new[s], there), 0]
            }
            (Choice::Old | Choice::New, Choice::Free) => {
                let here = self.frame.decided(&self.choices, s);
                [0, price(here, old[t]) - price(here, new[t])]
            }
            _ => [0, 0],
        }
    }

    /// The pairs of a sample: axis, first and second.
    fn neighbours(&self, i: usize) -> impl Iterator<Item = (usize, usize, usize)> + use<P, D> {
        let domain = self.frame.domain;
        let at = domain.position(i);
        (0..2 * D).filter_map(move |direction| {
            let (axis, ahead) = (direction / 2, direction % 2 == 0);
            let mut by = [0; D];
            by[axis] = if ahead { 1 } else { -1 };
            let j = domain.index(domain.step(at, by)?);
            if ahead { Some((axis, i, j)) } else { Some((axis, j, i)) }
        })
    }
}
