//! Graphs from the petgraph crate.

use petgraph::EdgeType;
use petgraph::graph::IndexType;
use petgraph::visit::{EdgeRef, GraphProp, IntoEdgeReferences, NodeIndexable};

use crate::error::{MaxflowError, Result};
use crate::sparse::Graph;

impl<N, E: Copy + Into<i64>, Ty: EdgeType, Ix: IndexType> TryFrom<&petgraph::Graph<N, E, Ty, Ix>> for Graph {
    type Error = MaxflowError;

    /// Nodes and edges keep their indices; weights are capacities, both ways in an undirected graph. Source and sink
    /// are still to be chosen: [`Graph::pin`] or [`Graph::terminal`].
    ///
    /// ```
    /// use selvedge_maxflow::{Graph, Side};
    ///
    /// let roads = petgraph::Graph::<(), u32>::from_edges([(0, 1, 4), (1, 2, 3)]);
    /// let mut graph = Graph::try_from(&roads)?;
    /// graph.pin(0, Side::Source)?;
    /// graph.pin(2, Side::Sink)?;
    /// assert_eq!(graph.solve()?.flow, 3);
    /// for edge in roads.edge_indices() {
    ///     let arc = graph.arc_id(edge.index()).expect("an arc an edge");
    ///     assert_eq!(graph.flow(arc)?, 3);
    /// }
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Graph::try_from_petgraph`].
    fn try_from(graph: &petgraph::Graph<N, E, Ty, Ix>) -> Result<Self> {
        Self::try_from_petgraph(graph, |&weight| weight.into())
    }
}

impl Graph {
    /// Any graph that tells its edges by reference (`&Graph`, `&StableGraph`, `&GraphMap`, `&MatrixGraph`, `&Csr`),
    /// with capacities from any weight. Nodes have the numbers that petgraph gives them
    /// ([`NodeIndexable::to_index`]); of numbers that are not used there are nodes without arcs. Arcs come in the order
    /// in which the graph tells its edges: [`Graph::arc_ids`] beside `edge_references` gives each its name.
    ///
    /// # Errors
    ///
    /// As [`Graph::new`] and [`Graph::arc`]: negative capacities, those that sum to more than [`Graph::MAX_TOTAL`], too
    /// many nodes or edges.
    pub fn try_from_petgraph<G>(graph: G, capacity: impl Fn(&G::EdgeWeight) -> i64) -> Result<Self>
    where
        G: IntoEdgeReferences + NodeIndexable + GraphProp,
    {
        let mut flow = Self::new(graph.node_bound())?;
        for edge in graph.edge_references() {
            let forward = capacity(edge.weight());
            let back = if graph.is_directed() { 0 } else { forward };
            flow.arc(graph.to_index(edge.source()), graph.to_index(edge.target()), forward, back)?;
        }
        Ok(flow)
    }
}
