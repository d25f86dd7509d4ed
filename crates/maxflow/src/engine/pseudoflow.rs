//! Engine P: pseudoflow, highest label first.
//!
//! After Hochbaum, "The pseudoflow algorithm: a new algorithm for the maximum-flow problem" (Operations Research 2008),
//! and Chandran and Hochbaum's study of its variants (2009). The nodes form trees; only a root may have excess. A tree
//! whose root has positive excess is *strong*. It looks for an arc with residual from one of its nodes to a node nearer
//! to the sink (its label is one less), hangs itself there, and sends its root's excess up the new tree. Where an arc
//! on the way is too narrow the tree splits, and the lower part is strong again. A strong tree that finds no such arc
//! is relabelled: its nodes are farther from the sink than was thought.
//!
//! A whole tree moves at once, so long paths cost little, and the bound is strongly polynomial. What costs is excess
//! that never gets through: its trees are relabelled step by step until a label has no node (a *gap*). So it is run
//! from the side with less to give, see [`super::run`].
//!
//! Labels start at 0 and 1, as in the paper. Exact distances are a valid start too, but took twice as long on overlays
//! (excess travels far before it has gathered in large trees), and restarting from exact distances now and then two to
//! three times as long. Of the strong trees with the highest label the one that became strong last goes first: its
//! nodes are still in cache. Each property of a node has an array of its own: a visit reads the labels of all
//! neighbours, and that array is small enough to stay in cache.

use super::Outcome;
use super::steps::Steps;
use super::strong::{Bucket, Strong};
use crate::error::refill;
use crate::network::{ArcNotes, Capacity, Network, Role};

/// Label of nodes that cannot reach negative excess, and of those that take no part.
const DEAD: u32 = u32::MAX;
/// How many trees are processed between two looks at `cancelled`: a look costs nothing beside so many.
const CANCEL_PERIOD: u64 = 4096;

/// Memory of engine P, kept from solve to solve: by slot, 10 bytes a node on a grid, and by label.
#[derive(Clone, Debug)]
pub(crate) struct PseudoScratch<A, S> {
    label: Vec<u32>,
    next: Vec<u32>,
    parent: Vec<A>,
    notes: Vec<S>,
    buckets: Vec<Bucket>,
}

impl<A, S> Default for PseudoScratch<A, S> {
    fn default() -> Self {
        let (label, next, parent, notes, buckets) = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { label, next, parent, notes, buckets }
    }
}

/// Runs engine P on the `relevant` nodes until their flow is maximum or `cancelled` says stop; on what has excess among
/// `together` nodes first, then on that among the next. The rest of the graph is there all the time.
pub(crate) fn solve<N: Network>(
    net: &mut N,
    scratch: &mut PseudoScratch<N::Arc, N::Notes>,
    relevant: impl Fn(usize) -> bool,
    together: usize,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let Some(mut forest) = Forest::plant(net, scratch, relevant) else { return Outcome::OutOfMemory };
    let nodes = forest.net.nodes();
    for first in nodes.clone().step_by(together.min(nodes.len().max(1))) {
        for v in first..nodes.end.min(first.saturating_add(together)) {
            if forest.net.excess(v) > N::Cap::ZERO && forest.label[v] != DEAD {
                forest.add_strong(v);
            }
        }
        let outcome = forest.process_all(cancelled);
        if outcome != Outcome::Done {
            return outcome;
        }
    }
    Outcome::Done
}

/// The state of a run; slices, by slot, of the memory that is kept.
struct Forest<'a, N: Network> {
    net: &'a mut N,
    /// A lower bound of the distance to negative excess. Children's labels are at least their parent's.
    label: &'a mut [u32],
    /// The arc to the parent, or [`Network::ROOT`].
    parent: &'a mut [N::Arc],
    notes: &'a mut [N::Notes],
    strong: Strong<'a>,
    steps: Steps,
}

impl<'a, N: Network> Forest<'a, N> {
    /// Every relevant node a tree; those with positive excess are at least one away from negative excess. `None`
    /// without memory.
    fn plant(
        net: &'a mut N,
        scratch: &'a mut PseudoScratch<N::Arc, N::Notes>,
        relevant: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let slots = net.slots();
        let fits = refill(&mut scratch.label, DEAD, slots)
            && refill(&mut scratch.next, 0, slots)
            && refill(&mut scratch.parent, N::ROOT, slots)
            && refill(&mut scratch.notes, N::Notes::default(), slots);
        let strong = Strong::new(&mut scratch.next, &mut scratch.buckets);
        let (label, parent, notes) = (&mut scratch.label[..], &mut scratch.parent[..], &mut scratch.notes[..]);
        let steps = Steps::of(net.nodes().len());
        let mut forest = Self { net, label, parent, notes, strong, steps };
        if !fits || !forest.strong.reach(0) || !forest.strong.reach(1) {
            return None;
        }
        let mut count = [0; 2];
        for v in forest.net.nodes() {
            if forest.net.role(v) == Role::Free && relevant(v) {
                let label = u32::from(forest.net.excess(v) > N::Cap::ZERO);
                forest.label[v] = label;
                count[label as usize] += 1;
            }
        }
        forest.strong.start(count);
        Some(forest)
    }

    /// Processes strong trees until there are none.
    fn process_all(&mut self, cancelled: &dyn Fn() -> bool) -> Outcome {
        let mut processed = 0_u64;
        while let Some(root) = self.pop_highest() {
            if !self.strong.reach(self.label[root] + 1) {
                return Outcome::OutOfMemory;
            }
            self.process(root);
            processed += 1;
            if processed.is_multiple_of(CANCEL_PERIOD) && cancelled() {
                return Outcome::Cancelled;
            }
        }
        Outcome::Done
    }

    #[inline]
    fn add_strong(&mut self, v: usize) {
        self.strong.add(v, self.label[v]);
    }

    /// The next strong root that may still reach negative excess, of the highest label.
    fn pop_highest(&mut self) -> Option<usize> {
        loop {
            self.steps.take();
            while let Some(root) = self.strong.pop_highest() {
                if self.strong.nodes(self.label[root] - 1) > 0 {
                    return Some(root);
                }
                // No node is one nearer: none of this tree can ever get there.
                self.bury(root);
            }
            // What was the goal has been filled up: it is at least one away from the rest.
            let mut filled = self.strong.pop_lowest()?;
            loop {
                self.steps.take();
                self.raise(filled);
                self.add_strong(filled);
                match self.strong.pop_lowest() {
                    Some(root) => filled = root,
                    None => break,
                }
            }
        }
    }

    /// Adds one to a node's label.
    #[inline]
    fn raise(&mut self, v: usize) {
        let label = self.label[v];
        self.label[v] = label + 1;
        self.notes[v].rewind_down();
        self.strong.discount(label);
        self.strong.count(label + 1);
    }

    /// Merges a strong tree if one of its nodes with the root's label has an arc to the label below, else relabels
    /// those nodes. Depth first; a node's label rises once its children's have.
    fn process(&mut self, root: usize) {
        let label = self.label[root];
        let mut v = root;
        self.notes[v].rewind_children();
        loop {
            self.steps.take();
            if let Some(a) = self.arc_down(v, label) {
                self.hang(v, a);
                self.send_excess(root);
                return;
            }
            loop {
                self.steps.take();
                if let Some(child) = self.next_child(v, |l| l == label) {
                    v = child;
                    self.notes[v].rewind_children();
                    break;
                }
                self.raise(v);
                if v == root {
                    self.add_strong(root);
                    return;
                }
                v = self.net.head(v, self.parent[v]);
            }
        }
    }

    /// An arc with residual from `v` to a node one nearer to the sink.
    #[inline]
    fn arc_down(&mut self, v: usize, label: u32) -> Option<N::Arc> {
        let labels = &*self.label;
        let down = |net: &N, a, w: usize| (labels[w] == label - 1) & (net.residual(v, a) > N::Cap::ZERO);
        self.net.find_down(v, &mut self.notes[v], down)
    }

    /// The next child of `v` with a wanted label. One that was returned must no longer be wanted when it is asked for
    /// the next, since its label has changed.
    #[inline]
    fn next_child(&mut self, v: usize, wanted: impl Fn(u32) -> bool) -> Option<usize> {
        let labels = &*self.label;
        self.net.find_child(v, &mut self.notes[v], self.parent, |w| wanted(labels[w]))
    }

    /// Turns the tree of `v` over so that `v` is its root, and hangs it at the other end of arc `a`.
    fn hang(&mut self, v: usize, a: N::Arc) {
        let (mut v, mut a, mut w) = (v, a, self.net.head(v, a));
        loop {
            self.steps.take();
            self.notes[w].gain_child(self.net.twin(a));
            let old = std::mem::replace(&mut self.parent[v], a);
            if old == N::ROOT {
                return;
            }
            (w, a) = (v, self.net.twin(old));
            v = self.net.head(v, old);
            self.notes[v].lose_child(a);
        }
    }

    /// Sends the excess of `v` up its tree; where it does not fit the tree splits.
    fn send_excess(&mut self, v: usize) {
        let (mut v, mut before) = (v, N::Cap::ZERO);
        loop {
            self.steps.take();
            let a = self.parent[v];
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
                self.parent[v] = N::ROOT;
                self.notes[w].lose_child(self.net.twin(a));
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
            self.steps.take();
            if let Some(child) = self.next_child(v, |l| l != DEAD) {
                v = child;
                self.mark_dead(v);
            } else if v == root {
                return;
            } else {
                v = self.net.head(v, self.parent[v]);
            }
        }
    }

    fn mark_dead(&mut self, v: usize) {
        let label = std::mem::replace(&mut self.label[v], DEAD);
        self.strong.discount(label);
        self.notes[v].rewind_children();
    }
}
