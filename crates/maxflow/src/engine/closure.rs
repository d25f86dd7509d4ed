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
/// Returns whether there was memory. `in_source` is indexed by node, from 0. `stack` is scratch. Time
/// `O(arcs of the source side)`.
fn source_side<N: Network>(net: &N, in_source: &mut [bool], stack: &mut Vec<u32>) -> bool {
    let first = net.nodes().start;
    let mut fits = true;
    stack.clear();
    for v in net.nodes() {
        let starts = match net.role(v) {
            Role::Free => net.excess(v) > N::Cap::ZERO,
            Role::PinnedSource => true,
            Role::PinnedSink | Role::Masked => false,
        };
        if !starts || std::mem::replace(&mut in_source[v - first], true) {
            continue;
        }
        fits &= push(stack, v as u32);
        while let Some(v) = stack.pop() {
            let v = v as usize;
            for a in net.arcs(v) {
                if net.residual(v, a) > N::Cap::ZERO {
                    let w = net.head(v, a);
                    if net.role(w) != Role::Masked && !std::mem::replace(&mut in_source[w - first], true) {
                        fits &= push(stack, w as u32);
                    }
                }
            }
        }
    }
    fits
}
