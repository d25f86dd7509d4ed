//! The move: an energy of one binary label a sample, and the cut that makes it least. `[Kwatra03 3]`

use selvedge_core::{SampleId, SourceMap, Window, try_vec};
use selvedge_maxflow::{BinaryEnergy, Minimum, PairwiseTerm, Side};

use crate::choice::Choice;
use crate::error::Error;
use crate::frame::Frame;
use crate::prices::Prices;
use crate::prune::prune;
use crate::span::span;

/// What a move would change.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// Samples of the frame that take the offer.
    pub taken: Vec<bool>,
    /// How much the price of the output falls, exactly and whatever the model lowered, unless [`Choice::New`] fills
    /// holes or follows a pin: of what these cost no matter what else is decided nothing counts.
    pub gain: i64,
    /// Samples that had nothing and take the offer.
    pub filled: usize,
    /// Samples that had a choice.
    pub free: usize,
    /// Pairs whose price of keeping both was lowered in the model: 0 for prices that are a metric.
    pub truncated: usize,
}

impl Proposal {
    /// Lays it: the map shows what was offered where it is taken.
    pub fn lay<const D: usize>(&self, frame: &Frame<D>, map: &mut SourceMap<D>) {
        let ids = map.ids.plane_mut(0);
        for (i, _) in self.taken.iter().enumerate().filter(|(_, taken)| **taken) {
            ids[frame.places[i] as usize] = frame.new[i];
        }
    }
}

/// Memory of moves, used again while what has a choice keeps its shape.
#[derive(Debug, Default)]
pub struct Scratch<const D: usize> {
    energy: Option<BinaryEnergy<D>>,
    minimum: Minimum,
    /// By place in the frame, the node of a free sample.
    nodes: Vec<u32>,
    differences: Vec<u32>,
}

/// Decides a frame: of all decisions that the choices leave the one of least price, by [`Frame::choices`] and `prices`.
///
/// Samples whose own prices rule a change out are decided without the cut, which changes nothing but the time. See the
/// crate's first page for what is exact and what is a promise.
///
/// # Errors
/// [`Error::Cut`]: no memory, a price out of range, or `cancelled`, which is polled before and while the cut is made;
/// [`Error::Core`]: no memory.
///
/// # Panics
/// If there is not one choice for each sample of the frame.
///
/// # Complexity
/// Time: one maximum flow over the box around the free samples, and `O(frame)`. Space `O(frame)`, about 80 bytes a
/// sample.
pub fn expand<const D: usize>(
    frame: &Frame<D>,
    choices: &[Choice],
    prices: &impl Prices<D>,
    scratch: &mut Scratch<D>,
    cancelled: &dyn Fn() -> bool,
) -> Result<Proposal, Error> {
    decide(frame, choices, prices, scratch, true, cancelled)
}

/// [`expand`], with pruning or without.
fn decide<const D: usize>(
    frame: &Frame<D>,
    choices: &[Choice],
    prices: &impl Prices<D>,
    scratch: &mut Scratch<D>,
    pruning: bool,
    cancelled: &dyn Fn() -> bool,
) -> Result<Proposal, Error> {
    assert_eq!(choices.len(), frame.old.len(), "one choice a sample");
    if cancelled() {
        // Small cuts are made before they would ask.
        return Err(selvedge_maxflow::MaxflowError::Cancelled.into());
    }
    let free = choices.iter().filter(|&&c| c == Choice::Free).count();
    let mut taken = try_vec(choices.len(), false)?;
    taken.iter_mut().zip(choices).for_each(|(taken, &c)| *taken = c == Choice::New);
    let mut proposal = Proposal { taken, gain: 0, filled: 0, free, truncated: 0 };
    scratch.measure(frame, choices, prices)?;
    let pruned = if pruning { prune(frame, choices, prices, &scratch.differences)? } else { None };
    solve(frame, pruned.as_deref().unwrap_or(choices), prices, scratch, cancelled, &mut proposal)?;
    let holes = proposal.taken.iter().zip(&frame.old).filter(|(taken, old)| **taken && !old.is_assigned());
    proposal.filled = holes.count();
    Ok(proposal)
}

/// Cuts, and notes what is taken and what that gains.
fn solve<const D: usize>(
    frame: &Frame<D>,
    choices: &[Choice],
    prices: &impl Prices<D>,
    scratch: &mut Scratch<D>,
    cancelled: &dyn Fn() -> bool,
    proposal: &mut Proposal,
) -> Result<(), Error> {
    let Some(span) = span(frame.domain.shape, choices) else { return Ok(()) };
    scratch.number(frame, choices, &span)?;
    let energy = scratch.take(frame, &span)?;
    let mut problem = Problem { frame, choices, prices, energy, scratch };
    problem.fill(&span)?;
    let mut energy = problem.energy;
    energy.minimize_into(&mut scratch.minimum, cancelled)?;
    for (place, _) in choices.iter().enumerate().filter(|(_, c)| **c == Choice::Free) {
        proposal.taken[place] = scratch.minimum.cut.side(scratch.nodes[place] as usize) == Side::Sink;
    }
    scratch.energy = Some(energy);
    let minimum = &scratch.minimum;
    (proposal.gain, proposal.truncated) = (minimum.before - minimum.after, minimum.truncated);
    Ok(())
}

impl<const D: usize> Scratch<D> {
    /// How much offers differ from what is there, where there is a choice.
    fn measure(&mut self, frame: &Frame<D>, choices: &[Choice], prices: &impl Prices<D>) -> Result<(), Error> {
        resized(&mut self.differences, frame.old.len())?;
        let both = frame.old.iter().zip(&frame.new).zip(choices);
        for (to, ((&old, &new), _)) in self.differences.iter_mut().zip(both).filter(|(_, (_, c))| **c == Choice::Free) {
            *to = prices.difference(old, new);
        }
        Ok(())
    }

    /// Numbers the samples of the span.
    fn number(&mut self, frame: &Frame<D>, choices: &[Choice], span: &Window<D>) -> Result<(), Error> {
        resized(&mut self.nodes, choices.len())?;
        let places = span.places(selvedge_core::Domain::open(frame.domain.shape)).flatten();
        places.zip(0..).for_each(|(place, node)| self.nodes[place] = node);
        Ok(())
    }

    /// An energy without terms: around an axis where the frame goes around and all of it has a choice.
    fn take(&mut self, frame: &Frame<D>, span: &Window<D>) -> Result<BinaryEnergy<D>, Error> {
        let shape = span.shape.map(|n| n as usize);
        let around = |a: usize| frame.domain.periodic[a] && span.shape[a] == frame.domain.shape[a];
        let periodic = std::array::from_fn(around);
        let fits = |e: &BinaryEnergy<D>| (e.graph().shape(), e.graph().periodic()) == (shape, periodic);
        match self.energy.take().filter(fits) {
            Some(mut energy) => {
                energy.clear();
                Ok(energy)
            }
            None => Ok(BinaryEnergy::new(shape, periodic)?),
        }
    }
}

/// A vector of this length, whatever it holds.
fn resized(to: &mut Vec<u32>, len: usize) -> Result<(), Error> {
    if to.len() < len {
        *to = try_vec(len, 0)?;
    }
    to.truncate(len);
    Ok(())
}

/// The energy over the span of the free samples.
struct Problem<'a, P, const D: usize> {
    frame: &'a Frame<D>,
    choices: &'a [Choice],
    prices: &'a P,
    energy: BinaryEnergy<D>,
    scratch: &'a Scratch<D>,
}

impl<P: Prices<D>, const D: usize> Problem<'_, P, D> {
    /// Terms of all free samples, and of all neighbours of which at least one is free.
    fn fill(&mut self, span: &Window<D>) -> Result<(), Error> {
        let places = || span.places(selvedge_core::Domain::open(self.frame.domain.shape)).flatten().enumerate();
        // Masks come before all terms.
        for (node, _) in places().filter(|&(_, place)| self.choices[place] != Choice::Free) {
            self.energy.graph_mut().mask(node)?;
        }
        for place in (0..self.choices.len()).filter(|&place| self.choices[place] == Choice::Free) {
            let at = self.frame.places[place] as usize;
            self.pay(place, |id| self.prices.unary(at, id))?;
        }
        for axis in 0..D {
            for (s, t) in self.frame.pairs(axis) {
                match (self.choices[s], self.choices[t]) {
                    (Choice::Free, Choice::Free) => {
                        let term = self.term(axis, s, t);
                        self.energy.pairwise(self.scratch.nodes[s] as usize, axis, term)?;
                    }
                    (Choice::Free, Choice::Old | Choice::New) => {
                        let there = self.frame.decided(self.choices, t);
                        self.pay(s, |here| self.prices.pair(axis, here, there))?;
                    }
                    (Choice::Old | Choice::New, Choice::Free) => {
                        let here = self.frame.decided(self.choices, s);
                        self.pay(t, |there| self.prices.pair(axis, here, there))?;
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// What a free sample pays whatever its free neighbours do.
    #[inline]
    fn pay(&mut self, place: usize, price: impl Fn(SampleId) -> i32) -> Result<(), Error> {
        let [old, new] = [self.frame.old[place], self.frame.new[place]].map(price);
        if (old, new) == (0, 0) {
            return Ok(());
        }
        Ok(self.energy.unary(self.scratch.nodes[place] as usize, old, new)?)
    }

    /// The term of two free neighbours. `[Kwatra03 3.1]`
    #[inline]
    fn term(&self, axis: usize, s: usize, t: usize) -> PairwiseTerm {
        let pair = |of: &[SampleId]| [of[s], of[t]];
        let differences = [self.scratch.differences[s], self.scratch.differences[t]];
        let quad = self.prices.quad(axis, pair(&self.frame.old), pair(&self.frame.new), differences);
        PairwiseTerm { e00: quad.neither, e01: quad.t, e10: quad.s, e11: quad.both }
    }
}

#[cfg(test)]
mod own_prices;
#[cfg(test)]
mod tests;
