//! Engine T: augmenting paths found by two search trees that are kept and mended.
//!
//! After Boykov and Kolmogorov, "An experimental comparison of min-cut/max-flow algorithms for energy minimization in
//! vision" (PAMI 2004), section 3, with the distance and time marks of Kolmogorov's thesis. A tree S grows from nodes
//! with positive excess along residual arcs, a tree T from nodes with negative excess against them. Where they meet
//! there is a path: push what it takes (*augment*). Arcs that fill up cut off subtrees, whose roots (*orphans*) look
//! for a new parent in their tree or fall off it (*adopt*). When neither tree can grow the flow is maximum.
//!
//! Good where most nodes have terminals and paths are short. Its worst case is bad, `O(n^2 m C)`, and shows where few
//! terminals are joined by long paths: the work of mending the trees is counted, and can be given a budget.

use std::collections::VecDeque;

use super::Outcome;
use super::steps::Steps;
use crate::error::refill;
use crate::network::{Capacity, Network, Role};

/// Which tree a node is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    Free,
    Source,
    Sink,
    /// Pinned, masked or not relevant: takes no part.
    Blocked,
}

/// What engine T knows of a node: 12 bytes on a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeNode<A> {
    /// When `depth` was last known to be right.
    stamp: u32,
    /// Arcs to the root, counted from 1.
    depth: u32,
    /// The arc to the parent, [`Network::ROOT`] or [`Network::ORPHAN`]; meaningless unless in a tree.
    parent: A,
    tag: Tag,
    /// In the queue of active nodes.
    queued: bool,
}

/// Memory of engine T, kept from solve to solve.
#[derive(Clone, Debug)]
pub(crate) struct TreeScratch<A> {
    nodes: Vec<TreeNode<A>>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
}

impl<A> Default for TreeScratch<A> {
    fn default() -> Self {
        Self { nodes: Vec::new(), active: VecDeque::new(), orphans: VecDeque::new() }
    }
}

/// How much work is done between two looks at `cancelled`: about a tenth of a millisecond.
const CANCEL_PERIOD: u64 = 1 << 14;

/// Runs engine T on the `relevant` nodes until their flow is maximum, mending has looked at more than `budget` arcs and
/// ancestors, or `cancelled` says stop.
pub(crate) fn solve<N: Network>(
    net: &mut N,
    scratch: &mut TreeScratch<N::Arc>,
    relevant: impl Fn(usize) -> bool,
    budget: u64,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let steps = Steps::of(net.nodes().len());
    let mut trees = Trees { net, scratch, steps, time: 1, budget, unasked: 0, stop: None, cancelled };
    if !trees.plant(relevant) {
        return Outcome::OutOfMemory;
    }
    trees.grow_all();
    trees.stop.unwrap_or(Outcome::Done)
}

struct Trees<'a, N: Network> {
    net: &'a mut N,
    scratch: &'a mut TreeScratch<N::Arc>,
    steps: Steps,
    /// Number of the current augmentation.
    time: u32,
    /// Arcs and ancestors that mending may still look at.
    budget: u64,
    /// Work done since the last look at `cancelled`.
    unasked: u64,
    stop: Option<Outcome>,
    cancelled: &'a dyn Fn() -> bool,
}

impl<N: Network> Trees<'_, N> {
    /// Every relevant node with excess becomes a root; the trees never enter the others.
    /// Returns whether there was memory.
    fn plant(&mut self, relevant: impl Fn(usize) -> bool) -> bool {
        let blank = TreeNode { stamp: 0, depth: 0, parent: N::ROOT, tag: Tag::Free, queued: false };
        let nodes = &mut self.scratch.nodes;
        if !refill(nodes, blank, self.net.slots()) {
            return false;
        }
        self.scratch.active.clear();
        self.scratch.orphans.clear();
        for v in self.net.nodes() {
            let excess = self.net.excess(v);
            let tag = match self.net.role(v) {
                Role::Free if !relevant(v) => Tag::Blocked,
                Role::Free if excess > N::Cap::ZERO => Tag::Source,
                Role::Free if excess < N::Cap::ZERO => Tag::Sink,
                Role::Free => continue,
                _ => Tag::Blocked,
            };
            nodes[v] = TreeNode { stamp: 0, depth: 1, tag, ..blank };
        }
        true
    }

    /// Grows both trees until nothing is active. The roots come first, in node order: they need no queue.
    fn grow_all(&mut self) {
        for v in self.net.nodes() {
            if self.stop.is_some() {
                return;
            }
            if !self.scratch.nodes[v].queued {
                self.grow_any(v);
            }
        }
        while self.stop.is_none()
            && let Some(v) = self.scratch.active.pop_front()
        {
            self.steps.take();
            self.scratch.nodes[v as usize].queued = false;
            self.grow_any(v as usize);
        }
    }

    #[inline]
    fn grow_any(&mut self, v: usize) {
        match self.scratch.nodes[v].tag {
            Tag::Source => self.grow::<false>(v),
            Tag::Sink => self.grow::<true>(v),
            Tag::Free | Tag::Blocked => {}
        }
    }

    /// Whether flow can move on the link of `v` by arc `a` with `w`: away from the root of tree S, toward that of T
    /// (`SINK`), where `v` is the node nearer to the root.
    #[inline]
    fn open<const SINK: bool>(&self, v: usize, a: N::Arc, w: usize) -> bool {
        let residual = if SINK { self.net.residual(w, self.net.twin(a)) } else { self.net.residual(v, a) };
        residual > N::Cap::ZERO
    }

    /// Looks from `v` along every arc: takes free nodes into the tree, augments where the trees meet.
    #[inline]
    fn grow<const SINK: bool>(&mut self, v: usize) {
        let mine = if SINK { Tag::Sink } else { Tag::Source };
        for a in self.net.arcs(v) {
            let w = self.net.head(v, a);
            while self.open::<SINK>(v, a, w) {
                self.steps.take();
                let near = self.scratch.nodes[v];
                let far = &mut self.scratch.nodes[w];
                if far.tag == Tag::Free {
                    far.tag = mine;
                    (far.parent, far.stamp, far.depth) = (self.net.twin(a), near.stamp, near.depth + 1);
                    self.activate(w);
                } else if far.tag == mine {
                    if far.stamp <= near.stamp && far.depth > near.depth {
                        // A shorter way to the root, as far as the marks know.
                        (far.parent, far.stamp, far.depth) = (self.net.twin(a), near.stamp, near.depth + 1);
                    }
                } else if far.tag != Tag::Blocked {
                    if SINK {
                        self.augment(w, self.net.twin(a), v)
                    } else {
                        self.augment(v, a, w)
                    }
                    self.adopt_all();
                    if self.stop.is_some() || self.scratch.nodes[v].tag != mine {
                        return;
                    }
                    continue;
                }
                break;
            }
        }
    }

    #[inline]
    fn activate(&mut self, v: usize) {
        if !std::mem::replace(&mut self.scratch.nodes[v].queued, true) && !enqueue(&mut self.scratch.active, v) {
            self.stop = Some(Outcome::OutOfMemory);
        }
    }

    /// Pushes the bottleneck of the path root of S ... `v` -> `w` ... root of T. `a` is the arc from `v` to `w`.
    fn augment(&mut self, v: usize, a: N::Arc, w: usize) {
        let x = self.net.residual(v, a).min(self.room::<false>(v)).min(self.room::<true>(w));
        self.net.push(v, a, w, x);
        self.push_path::<false>(v, x);
        self.push_path::<true>(w, x);
        self.tick();
    }

    /// What the tree path between `v` and its root lets through.
    fn room<const SINK: bool>(&self, mut v: usize) -> N::Cap {
        let mut room = N::Cap::MAX;
        loop {
            self.steps.take();
            let a = self.scratch.nodes[v].parent;
            if a == N::ROOT {
                let excess = self.net.excess(v);
                return room.min(if SINK { -excess } else { excess });
            }
            let u = self.net.head(v, a);
            let residual = if SINK { self.net.residual(v, a) } else { self.net.residual(u, self.net.twin(a)) };
            room = room.min(residual);
            v = u;
        }
    }

    /// Pushes `x` between `v` and its root; nodes whose way fills up become orphans.
    fn push_path<const SINK: bool>(&mut self, mut v: usize, x: N::Cap) {
        loop {
            self.steps.take();
            let a = self.scratch.nodes[v].parent;
            if a == N::ROOT {
                self.net.add_excess(v, if SINK { x } else { -x });
                if self.net.excess(v) == N::Cap::ZERO {
                    self.orphan(v);
                }
                return;
            }
            let u = self.net.head(v, a);
            let full = if SINK {
                self.net.push(v, a, u, x);
                self.net.residual(v, a) == N::Cap::ZERO
            } else {
                let down = self.net.twin(a);
                self.net.push(u, down, v, x);
                self.net.residual(u, down) == N::Cap::ZERO
            };
            if full {
                self.orphan(v);
            }
            v = u;
        }
    }

    #[inline]
    fn orphan(&mut self, v: usize) {
        self.scratch.nodes[v].parent = N::ORPHAN;
        if !enqueue(&mut self.scratch.orphans, v) {
            self.stop = Some(Outcome::OutOfMemory);
        }
    }

    /// A new time for the marks.
    fn tick(&mut self) {
        self.time += 1;
        if self.time == u32::MAX {
            // No more times: new trees have to be planted.
            self.stop = Some(Outcome::OverBudget);
        }
        self.spend(1);
    }

    /// Counts work against the budget, and now and then asks the caller's wish.
    #[inline]
    fn spend(&mut self, work: u64) {
        match self.budget.checked_sub(work) {
            Some(left) => self.budget = left,
            None => self.stop = self.stop.or(Some(Outcome::OverBudget)),
        }
        self.unasked += work;
        if self.unasked >= CANCEL_PERIOD {
            self.unasked = 0;
            if (self.cancelled)() {
                self.stop = Some(Outcome::Cancelled);
            }
        }
    }

    fn adopt_all(&mut self) {
        while self.stop.is_none()
            && let Some(v) = self.scratch.orphans.pop_front()
        {
            self.steps.take();
            match self.scratch.nodes[v as usize].tag {
                Tag::Source => self.adopt::<false>(v as usize),
                _ => self.adopt::<true>(v as usize),
            }
        }
    }

    /// Finds the orphan the parent nearest to a root, or drops it from its tree.
    fn adopt<const SINK: bool>(&mut self, v: usize) {
        let mine = self.scratch.nodes[v].tag;
        let (mut best, mut work) = ((u32::MAX, N::ORPHAN), 0);
        for a in self.net.arcs(v) {
            work += 1;
            let w = self.net.head(v, a);
            if self.scratch.nodes[w].tag == mine
                && self.open::<SINK>(w, self.net.twin(a), v)
                && let Some(depth) = self.depth(w, &mut work)
                && depth < best.0
            {
                best = (depth, a);
            }
        }
        self.spend(work);
        if best.1 == N::ORPHAN {
            self.drop_from_tree::<SINK>(v, mine);
        } else {
            let node = &mut self.scratch.nodes[v];
            (node.parent, node.stamp, node.depth) = (best.1, self.time, best.0 + 1);
        }
    }

    /// The orphan becomes free; its children become orphans; neighbours that could take it back become active.
    fn drop_from_tree<const SINK: bool>(&mut self, v: usize, mine: Tag) {
        self.scratch.nodes[v].tag = Tag::Free;
        for a in self.net.arcs(v) {
            let w = self.net.head(v, a);
            if self.scratch.nodes[w].tag == mine {
                if self.open::<SINK>(w, self.net.twin(a), v) {
                    self.activate(w);
                }
                if self.scratch.nodes[w].parent == self.net.twin(a) {
                    self.orphan(w);
                }
            }
        }
    }

    /// Depth of `v` if its path leads to a root, `None` if it ends at an orphan. Marks the path as known.
    fn depth(&mut self, v: usize, work: &mut u64) -> Option<u32> {
        let nodes = &mut self.scratch.nodes;
        let (mut u, mut steps) = (v, 0);
        let depth = loop {
            self.steps.take();
            *work += 1;
            let node = nodes[u];
            if node.stamp == self.time {
                break steps + node.depth;
            }
            if node.parent == N::ROOT {
                (nodes[u].stamp, nodes[u].depth) = (self.time, 1);
                break steps + 1;
            }
            if node.parent == N::ORPHAN {
                return None;
            }
            steps += 1;
            u = self.net.head(u, node.parent);
        };
        let (mut u, mut left) = (v, depth);
        while nodes[u].stamp != self.time {
            self.steps.take();
            (nodes[u].stamp, nodes[u].depth) = (self.time, left);
            left -= 1;
            u = self.net.head(u, nodes[u].parent);
        }
        Some(depth)
    }
}

/// Adds a node to a queue. Returns whether there was memory.
#[inline]
#[must_use]
fn enqueue(queue: &mut VecDeque<u32>, v: usize) -> bool {
    let fits = queue.len() < queue.capacity() || queue.try_reserve(1).is_ok();
    if fits {
        queue.push_back(v as u32);
    }
    fits
}
