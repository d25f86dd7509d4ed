//! Where a patch shows: the cut of least cost through a window of the output. `[Kwatra03 3]`
//!
//! One binary label a sample: keep what is there, or take the patch. A seam's cost follows from the two samples that
//! meet, so that old seams need no nodes of their own: between `s` and `t` the pairwise term is the price of the seam
//! that each of the four choices would leave. Under eq. 1 that is the paper's seam node; under eq. 5, which is no
//! metric, only the price of keeping both can be under-estimated, and the true cost of all seams never rises.

use selvedge_core::{SampleId, SeamCosts, Window};
use selvedge_maxflow::{BinaryEnergy, Minimum, PairwiseTerm, Side};

use crate::error::Error;
use crate::frame::Frame;

/// The choice that a position has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Nothing is there and nothing is offered.
    None,
    /// It keeps what is there.
    Old,
    /// It takes the patch.
    New,
    /// The cut decides.
    Free,
}

/// A decided frame.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    /// Frame positions that take the patch.
    pub(crate) taken: Vec<bool>,
    /// Cost of the seams at free positions if all of them keep what is there.
    pub(crate) before: i64,
    /// Cost of the seams there after the cut.
    pub(crate) after: i64,
    /// Positions that had nothing and take the patch.
    pub(crate) filled: usize,
    /// Positions that the cut decided.
    pub(crate) nodes: usize,
}

/// Memory of cuts, used again while windows keep their shape.
#[derive(Debug, Default)]
pub(crate) struct CutScratch<const D: usize> {
    energy: Option<BinaryEnergy<D>>,
    minimum: Minimum,
}

/// The choices of a frame's positions.
///
/// At every seam both patches should be defined on both sides. Hence positions next to one that can only keep what is
/// there (the ring, and where the source ends) keep it as well, and positions next to one that can only take the patch
/// take it. At the ends of an overlap, next to both, costs decide. Of a patch surrounded by what is there nothing is
/// forced to show. `[Kwatra03 3.2]`
pub(crate) fn choices<const D: usize>(frame: &Frame<D>, fixed: Option<&[bool]>) -> Vec<Choice> {
    let is_fixed = |i: usize| fixed.is_some_and(|f| f[frame.places[i] as usize]);
    let mut choices: Vec<Choice> = (0..frame.old.len())
        .map(|i| match (frame.old[i].is_assigned(), frame.new[i].is_assigned()) {
            (false, false) => Choice::None,
            (true, false) => Choice::Old,
            (false, true) => Choice::New,
            (true, true) if is_fixed(i) => Choice::Old,
            (true, true) => Choice::Free,
        })
        .collect();
    let mut near_old = vec![false; choices.len()];
    let mut near_new = vec![false; choices.len()];
    for axis in 0..D {
        for (s, t) in pairs(frame.window.shape, axis) {
            for (a, b) in [(s, t), (t, s)] {
                near_old[a] |= choices[b] == Choice::Old && !frame.new[b].is_assigned();
                near_new[a] |= choices[b] == Choice::New;
            }
        }
    }
    for (i, choice) in choices.iter_mut().enumerate().filter(|(_, c)| **c == Choice::Free) {
        *choice = match (near_old[i], near_new[i]) {
            (true, false) => Choice::Old,
            (false, true) => Choice::New,
            _ => Choice::Free,
        };
    }
    choices
}

/// Each position `s` of a box and the next one `t` along an axis, as places in the box's buffer.
pub(crate) fn pairs<const D: usize>(shape: [u32; D], axis: usize) -> impl Iterator<Item = (usize, usize)> {
    let stride = selvedge_core::Domain::open(shape).strides()[axis];
    let side = shape[axis] as usize;
    let blocks: usize = shape[..axis].iter().map(|&n| n as usize).product();
    (0..blocks).flat_map(move |block| {
        let first = block * side * stride;
        (first..first + side.saturating_sub(1) * stride).map(move |s| (s, s + stride))
    })
}

/// Finds the cut of least cost.
///
/// # Errors
/// [`Error::Cut`]: no memory, or cancelled.
///
/// Time: one maximum flow over the free positions; space `O(frame)`.
pub(crate) fn cut<const D: usize>(
    frame: &Frame<D>,
    choices: &[Choice],
    costs: &SeamCosts<D>,
    scratch: &mut CutScratch<D>,
    cancelled: &dyn Fn() -> bool,
) -> Result<Cut, Error> {
    let mut taken: Vec<bool> = choices.iter().map(|&c| c == Choice::New).collect();
    let filled = taken.iter().zip(&frame.old).filter(|(t, old)| **t && !old.is_assigned()).count();
    let nodes = choices.iter().filter(|&&c| c == Choice::Free).count();
    let Some(span) = span(frame.window.shape, choices) else {
        return Ok(Cut { taken, before: 0, after: 0, filled, nodes });
    };
    let places: Vec<usize> = places(frame, &span);
    let mut problem = Problem { frame, choices, costs, energy: scratch.take(span.shape)? };
    problem.fill(&places)?;
    problem.energy.minimize_into(&mut scratch.minimum, cancelled)?;
    for (node, &place) in places.iter().enumerate().filter(|&(_, &p)| choices[p] == Choice::Free) {
        taken[place] = scratch.minimum.cut.side(node) == Side::Sink;
    }
    scratch.energy = Some(problem.energy);
    Ok(Cut { taken, before: scratch.minimum.before, after: scratch.minimum.after, filled, nodes })
}

/// Place in the frame of each node of the span.
fn places<const D: usize>(frame: &Frame<D>, span: &Window<D>) -> Vec<usize> {
    let domain = selvedge_core::Domain::open(frame.window.shape);
    span.places(domain).flatten().collect()
}

/// The box that holds all free positions, in the frame's own coordinates.
fn span<const D: usize>(shape: [u32; D], choices: &[Choice]) -> Option<Window<D>> {
    let (mut low, mut high) = ([u32::MAX; D], [0; D]);
    let domain = selvedge_core::Domain::open(shape);
    let row = shape[D - 1] as usize;
    for (r, cells) in choices.chunks(row).enumerate() {
        let Some(first) = cells.iter().position(|&c| c == Choice::Free) else { continue };
        let last = cells.iter().rposition(|&c| c == Choice::Free).unwrap_or(first);
        let mut at = domain.position(r * row);
        for x in [first, last] {
            at[D - 1] = x as u32;
            low = std::array::from_fn(|a| low[a].min(at[a]));
            high = std::array::from_fn(|a| high[a].max(at[a]));
        }
    }
    let shape = std::array::from_fn(|a| (high[a] + 1).saturating_sub(low[a]));
    (low[0] != u32::MAX).then(|| Window { start: low.map(|l| l as i32), shape })
}

impl<const D: usize> CutScratch<D> {
    /// An energy without terms.
    fn take(&mut self, shape: [u32; D]) -> Result<BinaryEnergy<D>, Error> {
        let shape = shape.map(|n| n as usize);
        match self.energy.take().filter(|e| e.graph().shape() == shape) {
            Some(mut energy) => {
                energy.clear();
                Ok(energy)
            }
            None => Ok(BinaryEnergy::new(shape, [false; D])?),
        }
    }
}

/// The energy over the span of the free positions.
struct Problem<'a, const D: usize> {
    frame: &'a Frame<D>,
    choices: &'a [Choice],
    costs: &'a SeamCosts<D>,
    energy: BinaryEnergy<D>,
}

impl<const D: usize> Problem<'_, D> {
    /// Terms of all neighbours of which at least one is free.
    fn fill(&mut self, places: &[usize]) -> Result<(), Error> {
        let mut nodes = vec![usize::MAX; self.choices.len()];
        for (node, &place) in places.iter().enumerate() {
            nodes[place] = node;
            if self.choices[place] != Choice::Free {
                self.energy.graph_mut().mask(node)?;
            }
        }
        let norms = self.norms();
        for axis in 0..D {
            for (s, t) in pairs(self.frame.window.shape, axis) {
                match (self.choices[s], self.choices[t]) {
                    (Choice::Free, Choice::Free) => {
                        let term = self.term(axis, s, t, &norms);
                        self.energy.pairwise(nodes[s], axis, term)?;
                    }
                    (Choice::Free, Choice::Old | Choice::New) => {
                        let there = self.decided(t);
                        self.unary(nodes[s], s, |here| self.costs.between(axis, here, there))?;
                    }
                    (Choice::Old | Choice::New, Choice::Free) => {
                        let here = self.decided(s);
                        self.unary(nodes[t], t, |there| self.costs.between(axis, here, there))?;
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// How much the patch differs from what is there.
    fn norms(&self) -> Vec<u32> {
        let both = self.frame.old.iter().zip(&self.frame.new);
        both.map(|(&a, &b)| if a.is_assigned() && b.is_assigned() { self.costs.norm(a, b) } else { 0 }).collect()
    }

    /// The sample that a position has whatever the cut says.
    fn decided(&self, place: usize) -> SampleId {
        if self.choices[place] == Choice::New { self.frame.new[place] } else { self.frame.old[place] }
    }

    /// The term of a free position next to a decided one.
    fn unary(&mut self, node: usize, place: usize, price: impl Fn(SampleId) -> i32) -> Result<(), Error> {
        Ok(self.energy.unary(node, price(self.frame.old[place]), price(self.frame.new[place]))?)
    }

    /// The term of two free neighbours. `[Kwatra03 3.1]`
    #[inline]
    fn term(&self, axis: usize, s: usize, t: usize, norms: &[u32]) -> PairwiseTerm {
        let [old_s, old_t, new_s, new_t] = [self.frame.old[s], self.frame.old[t], self.frame.new[s], self.frame.new[t]];
        if self.costs.continued(old_s, 2 * axis) == Some(old_t) {
            // No old seam: a new one costs the same whichever side takes the patch.
            let price = self.costs.weigh(axis, norms[s] + norms[t], [old_s, new_s, old_t, new_t]);
            return PairwiseTerm { e00: 0, e01: price, e10: price, e11: 0 };
        }
        let price = |here, there| self.costs.between(axis, here, there);
        PairwiseTerm { e00: price(old_s, old_t), e01: price(old_s, new_t), e10: price(new_s, old_t), e11: 0 }
    }
}

#[cfg(test)]
mod tests;
