//! What every engine works on: the residual network.
//!
//! One idea carries the crate. The state of a half-solved problem is a *pseudoflow*: residual capacities, plus one
//! signed number a node, its *excess*. Positive excess is flow that the source can still deliver there (or that has
//! arrived and not yet left), negative excess is what the sink can still take. A push along an arc moves excess from
//! its tail to its head. Terminal arcs need no storage of their own, and every network is again a valid problem with
//! the same cuts:
//!
//! `capacity(cut X) = const + sum of positive excess outside X + sum of negative excess inside X + residuals leaving X`
//!
//! for whatever flow has been pushed. So engines may stop anywhere and hand over to another, an edit after a solve is
//! an addition to the same numbers, and the answer is read off in one way: once no positive excess reaches a negative
//! one, what positive excess still reaches *is* the smallest source side.

use std::fmt::Debug;
use std::ops::{AddAssign, Neg, Range, SubAssign};

/// A capacity: a signed integer with headroom.
pub(crate) trait Capacity:
    Copy + Ord + Debug + Default + AddAssign + SubAssign + Neg<Output = Self> + Into<i64>
{
    /// Larger than any capacity.
    const MAX: Self;
    /// No capacity.
    const ZERO: Self;
}

impl Capacity for i32 {
    const MAX: Self = i32::MAX;
    const ZERO: Self = 0;
}

impl Capacity for i64 {
    const MAX: Self = i64::MAX;
    const ZERO: Self = 0;
}

/// What a node is to the engines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Role {
    /// An ordinary node.
    Free = 0,
    /// Must be on the source's side.
    PinnedSource = 1,
    /// Must be on the sink's side.
    PinnedSink = 2,
    /// Not there.
    Masked = 3,
}

/// What engine P notes of a node's arcs, so as not to look at all of them each time: a grid node keeps the set of its
/// children, a node with any number of arcs the places where two searches stopped.
pub(crate) trait ArcNotes<A>: Copy + Default + Debug {
    /// The arc leads to a new child.
    #[inline]
    fn gain_child(&mut self, _: A) {}
    /// The arc leads to a child no more.
    #[inline]
    fn lose_child(&mut self, _: A) {}
    /// The node's label rose: any arc may lead down.
    #[inline]
    fn rewind_down(&mut self) {}
    /// The children are gone through again, from the first.
    #[inline]
    fn rewind_children(&mut self) {}
}

/// A residual network. Nodes are slots `nodes()`; arcs are named relative to their tail.
pub(crate) trait Network {
    /// Type of capacities and excesses.
    type Cap: Capacity;
    /// Names an arc among those that leave a node. Engines store it as the way to a node's parent.
    type Arc: Copy + Eq + Debug;
    /// Goes through the arcs of a node.
    type Arcs: Iterator<Item = Self::Arc>;
    /// What engine P notes of a node's arcs.
    type Notes: ArcNotes<Self::Arc>;
    /// Not an arc: the node is the root of its tree.
    const ROOT: Self::Arc;
    /// Not an arc: the node has just lost its parent.
    const ORPHAN: Self::Arc;

    /// Length that arrays indexed by slot must have; at least `nodes().end`.
    fn slots(&self) -> usize;
    /// The slots that hold nodes.
    fn nodes(&self) -> Range<usize>;
    /// All arcs that leave a node, in order.
    fn arcs(&self, v: usize) -> Self::Arcs;
    /// The node that arc `a` of `v` leads to.
    fn head(&self, v: usize, a: Self::Arc) -> usize;
    /// The name, at its head, of the arc that leads back.
    fn twin(&self, a: Self::Arc) -> Self::Arc;
    /// What can still be pushed from `v` along `a`.
    fn residual(&self, v: usize, a: Self::Arc) -> Self::Cap;
    /// Moves `x` along arc `a` from `v` to `w`, its head: residuals only.
    fn push(&mut self, v: usize, a: Self::Arc, w: usize, x: Self::Cap);
    /// The excess of a node.
    fn excess(&self, v: usize) -> Self::Cap;
    /// Adds to the excess of a node.
    fn add_excess(&mut self, v: usize, x: Self::Cap);
    /// What the node is to the engines.
    fn role(&self, v: usize) -> Role;
    /// Makes it something else.
    fn set_role(&mut self, v: usize, role: Role);

    /// The first arc of `v` for which `wanted(network, arc, head)` holds. Arcs that `notes` know to have been refused
    /// since they were rewound need not be asked about again.
    fn find_down(
        &self,
        v: usize,
        notes: &mut Self::Notes,
        wanted: impl Fn(&Self, Self::Arc, usize) -> bool,
    ) -> Option<Self::Arc>;

    /// The first child of `v` that is `wanted` and was not returned since `notes` were rewound, unless `wanted` itself
    /// tells those apart. `parents` holds the arc to the parent, by slot.
    fn find_child(
        &self,
        v: usize,
        notes: &mut Self::Notes,
        parents: &[Self::Arc],
        wanted: impl Fn(usize) -> bool,
    ) -> Option<usize>;
}

/// A network with every arc turned around and source and sink exchanged.
///
/// Its maximum flows are those of the original, read backward: an engine may work on either.
pub(crate) struct Reversed<'a, N>(pub(crate) &'a mut N);

impl<N: Network> Network for Reversed<'_, N> {
    type Cap = N::Cap;
    type Arc = N::Arc;
    type Arcs = N::Arcs;
    type Notes = N::Notes;
    const ROOT: N::Arc = N::ROOT;
    const ORPHAN: N::Arc = N::ORPHAN;

    fn slots(&self) -> usize {
        self.0.slots()
    }

    fn nodes(&self) -> Range<usize> {
        self.0.nodes()
    }

    #[inline]
    fn arcs(&self, v: usize) -> N::Arcs {
        self.0.arcs(v)
    }

    #[inline]
    fn head(&self, v: usize, a: N::Arc) -> usize {
        self.0.head(v, a)
    }

    #[inline]
    fn twin(&self, a: N::Arc) -> N::Arc {
        self.0.twin(a)
    }

    #[inline]
    fn residual(&self, v: usize, a: N::Arc) -> N::Cap {
        self.0.residual(self.0.head(v, a), self.0.twin(a))
    }

    #[inline]
    fn push(&mut self, v: usize, a: N::Arc, w: usize, x: N::Cap) {
        let twin = self.0.twin(a);
        self.0.push(w, twin, v, x);
    }

    #[inline]
    fn excess(&self, v: usize) -> N::Cap {
        -self.0.excess(v)
    }

    #[inline]
    fn add_excess(&mut self, v: usize, x: N::Cap) {
        self.0.add_excess(v, -x);
    }

    #[inline]
    fn role(&self, v: usize) -> Role {
        self.0.role(v)
    }

    fn set_role(&mut self, v: usize, role: Role) {
        self.0.set_role(v, role);
    }

    #[inline]
    fn find_down(
        &self,
        v: usize,
        notes: &mut N::Notes,
        wanted: impl Fn(&Self, N::Arc, usize) -> bool,
    ) -> Option<N::Arc> {
        self.0.find_down(v, notes, |_, a, w| wanted(self, a, w))
    }

    #[inline]
    fn find_child(
        &self,
        v: usize,
        notes: &mut N::Notes,
        parents: &[N::Arc],
        wanted: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        self.0.find_child(v, notes, parents, wanted)
    }
}

/// Pushes along every arc that a pin makes worthless to keep: all out of nodes pinned to the source, all into nodes
/// pinned to the sink. Afterwards a pinned node takes no part: no engine needs to know of infinite capacities.
pub(crate) fn saturate_pins<N: Network>(net: &mut N) {
    for v in net.nodes() {
        match net.role(v) {
            Role::PinnedSource => saturate::<N, false>(net, v),
            Role::PinnedSink => saturate::<N, true>(net, v),
            Role::Free | Role::Masked => {}
        }
    }
}

/// Saturates all arcs out of (`INTO`: into) a node.
fn saturate<N: Network, const INTO: bool>(net: &mut N, v: usize) {
    for a in net.arcs(v) {
        let w = net.head(v, a);
        let (tail, arc, head) = if INTO { (w, net.twin(a), v) } else { (v, a, w) };
        let x = net.residual(tail, arc);
        if x > N::Cap::ZERO {
            net.push(tail, arc, head, x);
            net.add_excess(tail, -x);
            net.add_excess(head, x);
        }
    }
}

/// What the pseudoflow has delivered, given the sum of all capacities out of the source.
///
/// The constant of the equation above, plus what pinned nodes owe. Equal to the minimum cut once an engine is done.
pub(crate) fn delivered<N: Network>(net: &N, source_total: i64) -> i64 {
    let left: i64 = net
        .nodes()
        .map(|v| match (net.role(v), net.excess(v).into()) {
            (Role::Free, excess) if excess > 0 => excess,
            (Role::PinnedSource, excess) => excess,
            _ => 0,
        })
        .sum();
    source_total - left
}
