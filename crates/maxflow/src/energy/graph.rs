//! Energies over graphs of any form.

use super::books::{Books, Lowered, Parts};
use super::{Minimum, PairwiseTerm};
use crate::error::{MaxflowError, Result};
use crate::forms::minimizes;
use crate::sparse::Graph;

/// [`BinaryEnergy`](super::BinaryEnergy) over a [`Graph`]: any two nodes may have a term.
///
/// ```
/// use selvedge_maxflow::{GraphEnergy, PairwiseTerm};
///
/// // Four regions, their likeness, and whether they are said to be of label 1.
/// let mut energy = GraphEnergy::new(4)?;
/// energy.unary(0, 0, 9)?; // label 0, or pay 9
/// energy.unary(3, 9, 0)?;
/// for (a, b, likeness) in [(0, 1, 7), (0, 2, 2), (1, 2, 1), (1, 3, 3), (2, 3, 4)] {
///     energy.pairwise(a, b, PairwiseTerm { e00: 0, e01: likeness, e10: likeness, e11: 0 })?;
/// }
/// let minimum = energy.minimize()?;
/// assert_eq!(minimum.cut.source_side(), [true, true, false, false]);
/// assert_eq!(minimum.after, 2 + 1 + 3);
/// # Ok::<(), selvedge_maxflow::MaxflowError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GraphEnergy {
    graph: Graph,
    books: Books,
}

impl GraphEnergy {
    /// An energy without terms.
    ///
    /// # Errors
    ///
    /// As [`Graph::new`].
    pub fn new(nodes: usize) -> Result<Self> {
        Ok(Graph::new(nodes)?.into())
    }

    /// The graph: for pins.
    pub fn graph_mut(&mut self) -> &mut Graph {
        &mut self.graph
    }

    /// The graph.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Adds `e0` for label 0 at a node, `e1` for label 1; both may be negative.
    ///
    /// # Errors
    ///
    /// As [`Graph::terminal`].
    pub fn unary(&mut self, node: usize, e0: i64, e1: i64) -> Result<()> {
        let least = e0.min(e1);
        // Made only where it is needed: making one costs as much as the rest.
        let too_large = || MaxflowError::CapacityTooLarge { node, value: e0.max(e1), max: Graph::MAX_TOTAL };
        let constant = self.books.constant.checked_add(least).ok_or_else(too_large)?;
        let [from_source, to_sink] = [e1.checked_sub(least), e0.checked_sub(least)];
        // Half of the nodes of pairwise terms are given nothing.
        if e0 != e1 || self.graph.len() <= node {
            self.graph.terminal(node, from_source.ok_or_else(too_large)?, to_sink.ok_or_else(too_large)?)?;
        }
        self.books.constant = constant;
        Ok(())
    }

    /// Adds a term of two nodes, as [`BinaryEnergy::pairwise`](super::BinaryEnergy::pairwise) does.
    ///
    /// # Errors
    ///
    /// As [`Graph::terminal`] and [`Graph::arc`]. The energy is then unchanged.
    pub fn pairwise(&mut self, first: usize, second: usize, term: PairwiseTerm) -> Result<()> {
        let parts = Parts::of(term, first == second);
        if parts.lowered > 0 && !self.books.reserve() {
            return Err(MaxflowError::OutOfMemory { nodes: self.graph.len(), links: self.graph.arc_count() });
        }
        let [u, v] = parts.unaries;
        self.unary(first, parts.constant, parts.constant + u)?;
        if let Err(error) = self.unary(second, 0, v) {
            self.take_back(first, parts.constant, parts.constant + u);
            return Err(error);
        }
        if parts.arcs != [0, 0]
            && let Err(error) = self.graph.arc(first, second, parts.arcs[0], parts.arcs[1])
        {
            self.take_back(second, 0, v);
            self.take_back(first, parts.constant, parts.constant + u);
            return Err(error);
        }
        let noted = self.books.note(Lowered { first, second, by: parts.lowered });
        debug_assert!(noted, "its place was reserved");
        Ok(())
    }

    /// Takes back what was just added.
    #[cold]
    fn take_back(&mut self, node: usize, e0: i64, e1: i64) {
        let least = e0.min(e1);
        let undone = self.graph.change_terminal(node, least - e1, least - e0);
        undone.expect("the terminal was within its headroom before");
        self.books.constant -= least;
    }

    minimizes!();
}

impl From<Graph> for GraphEnergy {
    /// An energy over a graph that may already have pins, and capacities as a first part of the energy.
    fn from(graph: Graph) -> Self {
        Self { graph, books: Books::default() }
    }
}
