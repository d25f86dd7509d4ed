//! Engine P: pseudoflow, highest label first.
//!
//! After Hochbaum, "The pseudoflow algorithm: a new algorithm for the maximum-flow problem" (Operations Research 2008),
//! and Chandran and Hochbaum's study of its variants (2009). The nodes form trees; only a root may have excess. A tree
//! whose root has positive excess is *strong*. It looks for an arc with residual from one of its nodes to a node nearer
//! to the sink (its label is one less), hangs itself there, and sends its root's excess up the new tree. Where an arc on the
//! way is too narrow the tree splits, and the lower part is strong again. A strong tree that finds no such arc is
//! relabelled: its nodes are farther from the sink than was thought.
//!
//! A whole tree moves at once, so long paths cost little, and the bound is strongly polynomial. What costs is excess that
//! never gets through: its trees are relabelled step by step until a label has no node (a *gap*). So it is run from the
//! side with less to give, see [`super::run`].
//!
//! Labels start at 0 and 1, as in the paper. Exact distances are a valid start too, but took twice as long on overlays
//! (excess travels far before it has gathered in large trees), and restarting from exact distances now and then two to
//! three times as long. Each property of a node has an array of its own: a visit reads labels and parents of
//! all neighbours, and these arrays are small enough to stay in cache.

use super::Outcome;
use crate::error::refill;
use crate::network::{Capacity, Network, Role};

/// Label of nodes that cannot reach negative excess, and of those that take no part.
const DEAD: u32 = u32::MAX;
/// End of a list.
const NIL: u32 = u32::MAX;
/// How many trees are processed between two looks at `cancelled`.
const CANCEL_PERIOD: u64 = 4096;

/// What engine P knows of the nodes, by slot: 11 bytes a node on a grid.
#[derive(Clone, Debug)]
struct PseudoNodes<A> {
    /// A lower bound of the distance to negative excess. Children's labels are at least their parent's.
    label: Vec<u32>,
    /// The next strong root in the bucket.
    next: Vec<u32>,
    /// The arc to the parent, or [`Network::ROOT`].
    parent: Vec<A>,
    /// Arcs before this one do not lead to a child with the label that is being processed.
    child: Vec<A>,
    /// Arcs before this one do not lead to a label one less.
    arc: Vec<A>,
}

impl<A: Copy> PseudoNodes<A> {
    /// Every node a dead tree of its own. Returns whether there was memory.
    fn reset(&mut self, slots: usize, root: A) -> bool {
        refill(&mut self.label, DEAD, slots)
            && refill(&mut self.next, NIL, slots)
            && [&mut self.parent, &mut self.child, &mut self.arc].into_iter().all(|arcs| refill(arcs, root, slots))
    }
}

/// A first-in, first-out list of strong roots with the same label.
#[derive(Clone, Copy, Debug)]
struct Bucket {
    first: u32,
    last: u32,
    /// Number of nodes with this label, in any tree.
    nodes: u32,
}

const EMPTY: Bucket = Bucket { first: NIL, last: NIL, nodes: 0 };

/// Memory of engine P, kept from solve to solve.
#[derive(Clone, Debug)]
pub(crate) struct PseudoScratch<A> {
    nodes: PseudoNodes<A>,
    /// By label.
    buckets: Vec<Bucket>,
}

impl<A> Default for PseudoScratch<A> {
    fn default() -> Self {
        let (label, next, parent, child, arc) = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { nodes: PseudoNodes { label, next, parent, child, arc }, buckets: Vec::new() }
    }
}

/// Runs engine P until the flow is maximum or `cancelled` says stop.
pub(crate) fn solve<N: Network>(
    net: &mut N,
    scratch: &mut PseudoScratch<N::Arc>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let mut forest = Forest { net, nodes: &mut scratch.nodes, buckets: &mut scratch.buckets, highest: 0 };
    if !forest.plant() {
        return Outcome::OutOfMemory;
    }
    let mut processed = 0_u64;
    while let Some(root) = forest.pop_highest() {
        forest.process(root);
        processed += 1;
        if processed.is_multiple_of(CANCEL_PERIOD) && cancelled() {
            return Outcome::Cancelled;
        }
    }
    Outcome::Done
}

struct Forest<'a, N: Network> {
    net: &'a mut N,
    nodes: &'a mut PseudoNodes<N::Arc>,
    buckets: &'a mut Vec<Bucket>,
    /// No strong root has a higher label.
    highest: usize,
}

impl<N: Network> Forest<'_, N> {
    /// Every node is a tree; those with positive excess are at least one away from negative excess.
    /// Returns whether there was memory.
    fn plant(&mut self) -> bool {
        if !self.nodes.reset(self.net.slots(), N::ROOT) {
            return false;
        }
        self.buckets.clear();
        for v in self.net.nodes() {
            if self.net.role(v) != Role::Free {
                continue;
            }
            let strong = self.net.excess(v) > N::Cap::ZERO;
            self.nodes.label[v] = u32::from(strong);
            self.nodes.arc[v] = self.net.first_arc(v);
            self.bucket(usize::from(strong)).nodes += 1;
            if strong {
                self.add_strong(v);
            }
        }
        true
    }

    #[inline]
    fn bucket(&mut self, label: usize) -> &mut Bucket {
        if label >= self.buckets.len() {
            self.buckets.resize(label + 1, EMPTY);
        }
        &mut self.buckets[label]
    }

    fn add_strong(&mut self, v: usize) {
        let label = self.nodes.label[v] as usize;
        self.nodes.next[v] = NIL;
        self.highest = self.highest.max(label);
        let bucket = self.bucket(label);
        let last = std::mem::replace(&mut bucket.last, v as u32);
        if bucket.first == NIL {
            bucket.first = v as u32;
        } else {
            self.nodes.next[last as usize] = v as u32;
        }
    }

    fn pop(&mut self, label: usize) -> Option<usize> {
        let bucket = &mut self.buckets[label];
        let v = bucket.first;
        if v == NIL {
            return None;
        }
        bucket.first = self.nodes.next[v as usize];
        Some(v as usize)
    }

    /// The next strong root that may still reach negative excess, of the highest label.
    fn pop_highest(&mut self) -> Option<usize> {
        if self.buckets.is_empty() {
            return None;
        }
        loop {
            while self.highest > 0 {
                let Some(root) = self.pop(self.highest) else {
                    self.highest -= 1;
                    continue;
                };
                if self.buckets[self.highest - 1].nodes > 0 {
                    return Some(root);
                }
                // No node is one nearer: none of this tree can ever get there.
                self.bury(root);
            }
            // What was the goal has been filled up: it is at least one away from the rest.
            let root = self.pop(0)?;
            self.raise(root);
            self.add_strong(root);
            while let Some(root) = self.pop(0) {
                self.raise(root);
                self.add_strong(root);
            }
        }
    }

    /// Adds one to a node's label.
    #[inline]
    fn raise(&mut self, v: usize) {
        let label = self.nodes.label[v] as usize;
        self.nodes.label[v] += 1;
        self.nodes.arc[v] = self.net.first_arc(v);
        self.buckets[label].nodes -= 1;
        self.bucket(label + 1).nodes += 1;
    }

    /// Merges a strong tree if one of its nodes with the root's label has an arc to the label below, else relabels
    /// those nodes. Depth first; a node's label rises once its children's have.
    fn process(&mut self, root: usize) {
        let label = self.nodes.label[root];
        let mut v = root;
        self.nodes.child[v] = self.net.first_arc(v);
        loop {
            if let Some(a) = self.arc_down(v, label) {
                self.hang(v, a);
                self.send_excess(root);
                return;
            }
            loop {
                if let Some(child) = self.next_child(v, label) {
                    v = child;
                    self.nodes.child[v] = self.net.first_arc(v);
                    break;
                }
                self.raise(v);
                if v == root {
                    self.add_strong(root);
                    return;
                }
                v = self.net.head(v, self.nodes.parent[v]);
            }
        }
    }

    /// An arc with residual from `v` to a node one nearer to the sink.
    #[inline]
    fn arc_down(&mut self, v: usize, label: u32) -> Option<N::Arc> {
        let labels = &self.nodes.label;
        let found = self
            .net
            .find(v, self.nodes.arc[v], |net, a, w| (labels[w] == label - 1) & (net.residual(v, a) > N::Cap::ZERO));
        self.nodes.arc[v] = found.unwrap_or(self.net.end_arc(v));
        found
    }

    /// The next child of `v` with the given label that was not visited yet.
    #[inline]
    fn next_child(&mut self, v: usize, label: u32) -> Option<usize> {
        let (labels, parents) = (&self.nodes.label, &self.nodes.parent);
        let found =
            self.net.find(v, self.nodes.child[v], |net, a, w| (labels[w] == label) & (parents[w] == net.twin(a)));
        self.nodes.child[v] = found.map_or(self.net.end_arc(v), N::next_arc);
        found.map(|a| self.net.head(v, a))
    }

    /// Turns the tree of `v` over so that `v` is its root, and hangs it at the other end of arc `a`.
    fn hang(&mut self, v: usize, a: N::Arc) {
        let (mut v, mut a) = (v, a);
        loop {
            let old = std::mem::replace(&mut self.nodes.parent[v], a);
            if old == N::ROOT {
                return;
            }
            v = self.net.head(v, old);
            a = self.net.twin(old);
        }
    }

    /// Sends the excess of `v` up its tree; where it does not fit the tree splits.
    fn send_excess(&mut self, v: usize) {
        let (mut v, mut before) = (v, N::Cap::ZERO);
        loop {
            let a = self.nodes.parent[v];
            let excess = self.net.excess(v);
            if a == N::ROOT || excess == N::Cap::ZERO {
                break;
            }
            let w = self.net.head(v, a);
            let x = excess.min(self.net.residual(v, a));
            self.net.push(v, a, w, x);
            self.net.add_excess(v, -x);
            before = self.net.excess(w);
            self.net.add_excess(w, x);
            if x < excess {
                self.nodes.parent[v] = N::ROOT;
                self.add_strong(v);
            }
            v = w;
        }
        if before <= N::Cap::ZERO && self.net.excess(v) > N::Cap::ZERO {
            self.add_strong(v);
        }
    }

    /// Declares a whole tree dead.
    fn bury(&mut self, root: usize) {
        let mut v = root;
        self.mark_dead(v);
        loop {
            let (labels, parents) = (&self.nodes.label, &self.nodes.parent);
            let child =
                self.net.find(v, self.nodes.child[v], |net, a, w| (labels[w] != DEAD) & (parents[w] == net.twin(a)));
            if let Some(a) = child {
                self.nodes.child[v] = N::next_arc(a);
                v = self.net.head(v, a);
                self.mark_dead(v);
            } else if v == root {
                return;
            } else {
                v = self.net.head(v, self.nodes.parent[v]);
            }
        }
    }

    fn mark_dead(&mut self, v: usize) {
        let label = std::mem::replace(&mut self.nodes.label[v], DEAD);
        self.buckets[label as usize].nodes -= 1;
        self.nodes.child[v] = self.net.first_arc(v);
    }
}
