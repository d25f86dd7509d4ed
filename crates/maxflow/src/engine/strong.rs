//! The strong roots of engine P by label, and how many nodes have each label.

use crate::error::push;

/// End of a list.
const NIL: u32 = u32::MAX;

/// One label.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bucket {
    /// The strong root added last; each knows the one before it.
    first: u32,
    /// Number of nodes with this label, in any tree.
    nodes: u32,
}

/// Strong roots, last in, first out, and counts of labels.
pub(super) struct Strong<'a> {
    /// By slot: the strong root with the same label that was added before.
    next: &'a mut [u32],
    /// By label.
    buckets: &'a mut Vec<Bucket>,
    /// No strong root has a higher label.
    highest: usize,
}

impl<'a> Strong<'a> {
    /// No roots, and no label yet.
    pub(super) fn new(next: &'a mut [u32], buckets: &'a mut Vec<Bucket>) -> Self {
        buckets.clear();
        Self { next, buckets, highest: 0 }
    }

    /// Makes sure of a place for a label, given that those below have one. Returns whether there was memory.
    #[inline]
    #[must_use]
    pub(super) fn reach(&mut self, label: u32) -> bool {
        (label as usize) < self.buckets.len() || push(self.buckets, Bucket { first: NIL, nodes: 0 })
    }

    /// How many nodes have label 0 and label 1, for which there are places.
    pub(super) fn start(&mut self, nodes: [u32; 2]) {
        self.buckets.iter_mut().zip(nodes).for_each(|(bucket, nodes)| bucket.nodes = nodes);
    }

    /// Number of nodes with a label.
    #[inline]
    pub(super) fn nodes(&self, label: u32) -> u32 {
        self.buckets[label as usize].nodes
    }

    /// Counts one more node with a label.
    #[inline]
    pub(super) fn count(&mut self, label: u32) {
        self.buckets[label as usize].nodes += 1;
    }

    /// Counts one node less with a label.
    #[inline]
    pub(super) fn discount(&mut self, label: u32) {
        self.buckets[label as usize].nodes -= 1;
    }

    /// Adds a strong root.
    #[inline]
    pub(super) fn add(&mut self, v: usize, label: u32) {
        self.highest = self.highest.max(label as usize);
        let first = &mut self.buckets[label as usize].first;
        self.next[v] = std::mem::replace(first, v as u32);
    }

    /// Takes a strong root of label 0 out.
    pub(super) fn pop_lowest(&mut self) -> Option<usize> {
        self.pop(0)
    }

    /// Takes a strong root of the highest label above 0 out.
    #[inline]
    pub(super) fn pop_highest(&mut self) -> Option<usize> {
        while self.highest > 0 {
            if let Some(root) = self.pop(self.highest) {
                return Some(root);
            }
            self.highest -= 1;
        }
        None
    }

    #[inline]
    fn pop(&mut self, label: usize) -> Option<usize> {
        let first = &mut self.buckets.get_mut(label)?.first;
        let root = *first as usize;
        if *first == NIL {
            return None;
        }
        *first = self.next[root];
        Some(root)
    }
}
