//! In debug builds, an endless loop fails instead of hanging.

use std::cell::Cell;

/// Steps a node. Adversarial graphs take a few thousand, and what loops for ever on a graph of a test is found within
/// seconds. The theory allows more, on graphs that nobody has: a panic here is either a loop or a discovery.
const A_NODE: u64 = 1 << 16;

/// Counts the steps of a run; nothing at all in release.
#[derive(Debug)]
pub(crate) struct Steps {
    left: Cell<u64>,
}

impl Steps {
    /// For a network of so many nodes.
    pub(crate) fn of(nodes: usize) -> Self {
        Self { left: Cell::new((nodes as u64 + 16).saturating_mul(A_NODE)) }
    }

    /// One more.
    #[inline]
    pub(crate) fn take(&self) {
        if cfg!(debug_assertions) {
            let left = self.left.get().checked_sub(1);
            self.left.set(left.expect("an engine comes to its end within 65,536 steps a node"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(debug_assertions, should_panic(expected = "comes to its end"))]
    fn what_never_ends_fails() {
        let steps = Steps::of(1);
        (0..=17 * A_NODE).for_each(|_| steps.take());
    }
}
