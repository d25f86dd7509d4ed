//! What lies between positive and negative excess: all that a nearly maximum flow has left to change.

use crate::error::{push, refill};
use crate::network::{Capacity, Network, Role};

/// The source's excess gets here.
const REACHED: u8 = 1;
/// ... and from here to the sink.
const BETWEEN: u8 = 2;

/// Finds the nodes on residual walks from positive to negative excess, marked so that [`is_between`] holds. Returns
/// their number: if there are none, the flow is maximum. `None` without memory.
///
/// No augmenting path will ever leave these nodes: residual capacity that pushes open up leads back among them. After
/// a small change that leaves the engines a small part of the graph, or none. `marks` and `stack` are scratch.
pub(crate) fn mark<N: Network>(net: &N, marks: &mut Vec<u8>, stack: &mut Vec<u32>) -> Option<usize> {
    if !refill(marks, 0, net.slots()) {
        return None;
    }
    for v in net.nodes() {
        if net.role(v) == Role::Free && net.excess(v) > N::Cap::ZERO && marks[v] == 0 {
            spread(net, v, marks, stack, [0, REACHED], |a, v, _| net.residual(v, a) > N::Cap::ZERO)?;
        }
    }
    let mut between = 0;
    for v in net.nodes() {
        if marks[v] == REACHED && net.excess(v) < N::Cap::ZERO {
            let into = |a, _, w: usize| net.residual(w, net.twin(a)) > N::Cap::ZERO;
            between += spread(net, v, marks, stack, [REACHED, BETWEEN], into)?;
        }
    }
    Some(between)
}

/// Whether a slot was marked as lying between.
#[inline]
pub(crate) fn is_between(marks: &[u8], v: usize) -> bool {
    marks[v] == BETWEEN
}

/// Turns the mark `from` into `to` at `v` and wherever open arcs lead from there. Returns the number of nodes, `None`
/// without memory.
fn spread<N: Network>(
    net: &N,
    v: usize,
    marks: &mut [u8],
    stack: &mut Vec<u32>,
    [from, to]: [u8; 2],
    open: impl Fn(N::Arc, usize, usize) -> bool,
) -> Option<usize> {
    marks[v] = to;
    stack.clear();
    let (mut fits, mut spread) = (push(stack, v as u32), 1);
    while let Some(v) = stack.pop() {
        let v = v as usize;
        for a in net.arcs(v) {
            let w = net.head(v, a);
            if marks[w] == from && open(a, v, w) && net.role(w) == Role::Free {
                marks[w] = to;
                spread += 1;
                fits &= push(stack, w as u32);
            }
        }
    }
    fits.then_some(spread)
}
