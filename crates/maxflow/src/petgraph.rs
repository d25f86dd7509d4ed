//! Graphs from the petgraph crate.

use petgraph::EdgeType;
use petgraph::graph::IndexType;
use petgraph::visit::EdgeRef;

use crate::error::Result;
use crate::sparse::Graph;

impl<N, E: Copy + Into<i64>, Ty: EdgeType, Ix: IndexType> From<&petgraph::Graph<N, E, Ty, Ix>> for Graph {
    /// Nodes and edges keep their indices; weights are capacities, both ways in an undirected graph. Source and sink are
    /// still to be chosen: [`Graph::pin`] or [`Graph::terminal`].
    ///
    /// ```
    /// use selvedge_maxflow::{Graph, Side};
    ///
    /// let roads = petgraph::Graph::<(), u32>::from_edges([(0, 1, 4), (1, 2, 3)]);
    /// let mut graph = Graph::from(&roads);
    /// graph.pin(0, Side::Source)?;
    /// graph.pin(2, Side::Sink)?;
    /// assert_eq!(graph.solve(&|| false)?.flow, 3);
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    ///
    /// # Panics
    ///
    /// With a negative weight, weights that sum to more than [`Graph::MAX_TOTAL`], too many edges, or without memory;
    /// [`Graph::try_from_petgraph`] returns these as errors.
    fn from(graph: &petgraph::Graph<N, E, Ty, Ix>) -> Self {
        Self::try_from_petgraph(graph, |&weight| weight.into()).expect("a graph within the limits")
    }
}

impl Graph {
    /// As `From`, with capacities from any weight.
    ///
    /// # Errors
    ///
    /// As [`Graph::new`] and [`Graph::arc`].
    pub fn try_from_petgraph<N, E, Ty: EdgeType, Ix: IndexType>(
        graph: &petgraph::Graph<N, E, Ty, Ix>,
        capacity: impl Fn(&E) -> i64,
    ) -> Result<Self> {
        let mut flow = Self::new(graph.node_count())?;
        for edge in graph.edge_references() {
            let forward = capacity(edge.weight());
            let back = if graph.is_directed() { 0 } else { forward };
            flow.arc(edge.source().index(), edge.target().index(), forward, back)?;
        }
        Ok(flow)
    }
}
