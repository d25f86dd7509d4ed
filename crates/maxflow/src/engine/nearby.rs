//! What is decided nearby, where nearly every node has a terminal.
//!
//! There most nodes are on the side that their own terminal wants, and what one has too much its neighbours lack. So
//! the nodes with excess are looked at once each, before any engine (which sees the network turned around where those
//! are the many):
//!
//! - One that has more than its arcs can carry away is on the source's side, whatever else happens. It fills them all,
//!   and takes no part from then on. Its neighbours have too much for that, mostly, and may follow at once.
//! - Another gives its neighbours what they lack.
//!
//! No arc with residual leads from a node that is *done* to one that is not, and none ever will: only a push into it
//! could open one. So the engine may leave such nodes out. Nodes that lack something are not looked at unless somebody
//! comes with it: of an expansion's nodes half to nine in ten never are.

use crate::error::{push, refill};
use crate::network::{Capacity, Network, Role};

/// Which nodes take part, and which are to be looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct NearbyScratch {
    /// By slot.
    open: Vec<bool>,
    /// Nodes that came to have more excess when a neighbour was done.
    rich: Vec<u32>,
}

impl NearbyScratch {
    /// Whether there is anything left to decide at a slot.
    #[inline]
    pub(super) fn open(&self, v: usize) -> bool {
        self.open[v]
    }
}

/// Decides what is decided nearby among the `relevant` nodes. Returns whether some may still have excess and not be
/// done, `None` without memory. Time `O(arcs)`.
pub(super) fn decide<N: Network>(
    net: &mut N,
    scratch: &mut NearbyScratch,
    relevant: impl Fn(usize) -> bool,
) -> Option<bool> {
    let NearbyScratch { open, rich } = scratch;
    if !refill(open, false, net.slots()) {
        return None;
    }
    for v in net.nodes() {
        open[v] = (net.role(v) == Role::Free) & relevant(v);
    }
    rich.clear();
    let mut left = false;
    for v in net.nodes() {
        if net.excess(v) > N::Cap::ZERO {
            left |= give(net, open, rich, v)?;
            while let Some(w) = rich.pop() {
                left |= give(net, open, rich, w as usize)?;
            }
        }
    }
    Some(left)
}

/// Gives a node's neighbours what they lack, or all that the arcs can carry if that is too little. Returns whether the
/// node has excess still and is not done, `None` without memory.
#[inline]
fn give<N: Network>(net: &mut N, open: &mut [bool], rich: &mut Vec<u32>, v: usize) -> Option<bool> {
    if !open[v] {
        return Some(false);
    }
    let mut most = 0;
    for a in net.arcs(v) {
        if open[net.head(v, a)] {
            most += net.residual(v, a).into();
        }
    }
    let done = net.excess(v).into() > most;
    open[v] = !done;
    for a in net.arcs(v) {
        let w = net.head(v, a);
        let (residual, lack) = (net.residual(v, a), -net.excess(w));
        let x = if done { residual } else { residual.min(lack).min(net.excess(v)) };
        if x > N::Cap::ZERO && open[w] {
            net.push(v, a, w, x);
            net.add_excess(v, -x);
            net.add_excess(w, x);
            if done && net.excess(w) > N::Cap::ZERO && (w < v || lack >= N::Cap::ZERO) {
                // One with excess that comes later is asked anyway.
                push(rich, w as u32).then_some(())?;
            }
        }
    }
    Some(!done && net.excess(v) > N::Cap::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::GridGraph;

    /// What is left to decide in a row of nodes with links of 5, by their net capacity from the source.
    fn left<const N: usize>(excess: [i32; N]) -> (bool, Vec<bool>) {
        let mut graph = GridGraph::new([N], [false]).unwrap();
        excess.iter().enumerate().for_each(|(v, e)| graph.terminal(v, (*e).max(0), (-e).max(0)).unwrap());
        (1..N).for_each(|v| graph.link(v - 1, 0, 5, 5).unwrap());
        let (mut net, mut scratch) = (graph.net::<2, false>(), NearbyScratch::default());
        let left = decide(&mut net, &mut scratch, |_| true).unwrap();
        (left, net.nodes().map(|v| scratch.open(v)).collect())
    }

    #[test]
    fn nodes_that_cannot_get_rid_of_what_they_have_are_done_and_their_neighbours_follow() {
        assert_eq!(left([6, -9, -9]), (false, vec![false, true, true]));
        assert_eq!(left([5, -9, -9]), (false, vec![true, true, true]), "all of it goes to the neighbour");
        assert_eq!(left([6, 1, -9]), (false, vec![false, false, true]), "5 come to the second, which can pass on 5");
        assert_eq!(left([3, 1, 3, -9]), (true, vec![true; 4]), "some are too far from what the last lacks");
        assert_eq!(left([-9, 1, 6, 9]), (true, vec![true, false, false, false]), "and back along the row");
        assert_eq!(left([-1, -1]), (false, vec![true; 2]));
    }
}
