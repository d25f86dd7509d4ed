//! Reading off the smallest source side.

use crate::cut::MinCut;
use crate::error::{MaxflowError, Result, push, refill};
use crate::network::{Capacity, Network, Role, delivered};

/// The cut of a maximum flow, or [`MaxflowError::OutOfMemory`]. `stack` is scratch.
pub(crate) fn read_off<N: Network>(net: &N, source_total: i64, cut: &mut MinCut, stack: &mut Vec<u32>) -> Result<()> {
    let nodes = net.nodes().len();
    cut.flow = delivered(net, source_total);
    if refill(&mut cut.in_source, false, nodes) && source_side(net, &mut cut.in_source, stack) {
        Ok(())
    } else {
        Err(MaxflowError::OutOfMemory { nodes, links: 0 })
    }
}

/// Marks what positive excess and source pins reach in the residual network: the smallest source side of all minimum
/// cuts, if the flow is maximum.
///
/// Returns whether there was memory. `in_source` is indexed by node, from 0. `stack` is scratch. Time `O(arcs)` of the
/// source side, or where most nodes start there, of the others: where all have terminals these are the few.
fn source_side<N: Network>(net: &N, in_source: &mut [bool], stack: &mut Vec<u32>) -> bool {
    let first = net.nodes().start;
    let mut count = 0;
    for (v, side) in net.nodes().zip(&mut *in_source) {
        *side = starts(net, v);
        count += usize::from(*side);
    }
    let mut fits = true;
    stack.clear();
    if 2 * count <= in_source.len() {
        for v in net.nodes().filter(|&v| starts(net, v)) {
            fits &= push(stack, v as u32);
            fits &= spread(net, in_source, stack);
        }
        return fits;
    }
    for v in net.nodes() {
        let reached = !in_source[v - first]
            && net.role(v) != Role::Masked
            && net.arcs(v).any(|a| {
                let w = net.head(v, a);
                // Without a link, `w` may be no node.
                in_source.get(w.wrapping_sub(first)) == Some(&true) && net.residual(w, net.twin(a)) > N::Cap::ZERO
            });
        if reached {
            in_source[v - first] = true;
            fits &= push(stack, v as u32);
            fits &= spread(net, in_source, stack);
        }
    }
    fits
}

/// Whether the source is at a node.
#[inline]
fn starts<N: Network>(net: &N, v: usize) -> bool {
    match net.role(v) {
        Role::Free => net.excess(v) > N::Cap::ZERO,
        Role::PinnedSource => true,
        Role::PinnedSink | Role::Masked => false,
    }
}

/// Marks what the nodes on the stack, which are marked, reach. Returns whether there was memory.
fn spread<N: Network>(net: &N, in_source: &mut [bool], stack: &mut Vec<u32>) -> bool {
    let (first, mut fits) = (net.nodes().start, true);
    while let Some(v) = stack.pop() {
        let v = v as usize;
        for a in net.arcs(v) {
            let w = net.head(v, a);
            // Sides are a byte a node, and mostly in cache: they come first.
            let Some(side) = in_source.get_mut(w.wrapping_sub(first)).filter(|side| !**side) else { continue };
            if net.residual(v, a) > N::Cap::ZERO && net.role(w) != Role::Masked {
                *side = true;
                fits &= push(stack, w as u32);
            }
        }
    }
    fits
}
