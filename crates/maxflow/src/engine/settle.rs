//! Nodes whose side is plain before any flow is sent.
//!
//! A node with more excess than its arcs can carry away is on the source's side of every minimum cut: on the other side
//! it would cost more. It is as good as pinned, and is, while an engine runs. The same holds of lack and the sink. So a
//! terminal that is meant as a pin is one.
//!
//! Its neighbours are not asked again, though they have more excess then, and may follow: few do where few have
//! terminals.

use crate::error::push;
use crate::network::{Capacity, Network, Role};

/// Pins what is plain, and lists it in `settled` for [`release`]. Returns whether there was memory. Time `O(arcs)`.
///
/// Where most nodes have terminals it does nothing: [`nearby`](super::nearby) decides there.
#[must_use]
pub(crate) fn settle<N: Network>(net: &mut N, settled: &mut Vec<u32>) -> bool {
    settled.clear();
    let terminals = net.nodes().filter(|&v| net.excess(v) != N::Cap::ZERO).count();
    if 2 * terminals > net.nodes().len() {
        return true;
    }
    let mut fits = true;
    for v in net.nodes() {
        if let Some(side) = plain_side(net, v) {
            fits &= push(settled, v as u32);
            net.set_role(v, side);
        }
    }
    fits
}

/// Takes the pins off again.
pub(crate) fn release<N: Network>(net: &mut N, settled: &[u32]) {
    settled.iter().for_each(|&v| net.set_role(v as usize, Role::Free));
}

/// Which side a free node is on whatever the rest of the graph does, if that is plain.
#[inline]
pub(crate) fn plain_side<N: Network>(net: &N, v: usize) -> Option<Role> {
    let excess: i64 = net.excess(v).into();
    if excess == 0 || net.role(v) != Role::Free {
        return None;
    }
    let mut carried = 0;
    for a in net.arcs(v) {
        carried += if excess > 0 { net.residual(v, a) } else { net.residual(net.head(v, a), net.twin(a)) }.into();
    }
    match excess.abs() > carried {
        false => None,
        true if excess > 0 => Some(Role::PinnedSource),
        true => Some(Role::PinnedSink),
    }
}

/// Saturates a node's arcs to (on the sink's side: from) all that are not held on its side.
pub(super) fn saturate<N: Network>(net: &mut N, v: usize, side: Role) {
    for a in net.arcs(v) {
        let w = net.head(v, a);
        if net.role(w) == side {
            continue;
        }
        let (tail, arc, head) = if side == Role::PinnedSource { (v, a, w) } else { (w, net.twin(a), v) };
        let x = net.residual(tail, arc);
        if x > N::Cap::ZERO {
            net.push(tail, arc, head, x);
            net.add_excess(tail, -x);
            net.add_excess(head, x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Side;
    use crate::grid::GridGraph;

    /// A row of links of 5, with terminals at both ends.
    fn settled(terminal: i32) -> usize {
        let mut graph = GridGraph::new([2, 9], [false; 2]).unwrap();
        for v in (0..18).filter(|v| v % 9 < 8) {
            graph.link(v, 1, 5, 5).unwrap();
        }
        graph.terminal(0, terminal, 0).unwrap();
        graph.terminal(17, 0, terminal).unwrap();
        graph.pin(3, Side::Sink).unwrap();
        let (mut net, mut settled) = (graph.net::<4, false>(), Vec::new());
        assert!(settle(&mut net, &mut settled));
        release(&mut net, &settled);
        assert!(
            net.nodes().all(|v| net.role(v) == if v == net.nodes().start + 3 { Role::PinnedSink } else { Role::Free })
        );
        settled.len()
    }

    #[test]
    fn what_links_cannot_carry_is_settled_and_no_more() {
        assert_eq!([0, 4, 5, 6, 1 << 28].map(settled), [0, 0, 0, 2, 2]);
    }
}
