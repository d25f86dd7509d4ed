//! Graphs from petgraph, directed and not.

use petgraph::Undirected;
use selvedge_maxflow::{Graph, MaxflowError, Side};

/// Flow from the first node to the last.
fn flow(mut graph: Graph) -> i64 {
    graph.pin(0, Side::Source).unwrap();
    graph.pin(graph.len() - 1, Side::Sink).unwrap();
    graph.solve().unwrap().flow
}

#[test]
fn edges_of_an_undirected_graph_go_both_ways() {
    // 0 - 1 - 3 with 2 beside: the way over 2 runs against how two of its edges were written.
    let edges = [(0, 1, 9_i64), (1, 3, 2), (2, 1, 4), (3, 2, 3)];
    assert_eq!(flow(Graph::try_from(&petgraph::Graph::<(), i64>::from_edges(edges)).unwrap()), 2);
    assert_eq!(flow(Graph::try_from(&petgraph::Graph::<(), i64, Undirected>::from_edges(edges)).unwrap()), 5);
}

#[test]
fn weights_of_any_kind_and_wrong_ones() {
    let floats = petgraph::Graph::<(), f64>::from_edges([(0, 1, 0.75), (1, 2, 0.5)]);
    let scaled = |&weight: &f64| (weight * 1000.0) as i64;
    assert_eq!(flow(Graph::try_from_petgraph(&floats, scaled).unwrap()), 500);
    let wide = petgraph::Graph::<(), u64>::from_edges([(0, 1, 1 << 60), (1, 2, 1 << 40)]);
    let checked = |&weight: &u64| i64::try_from(weight).unwrap_or(-1);
    assert_eq!(flow(Graph::try_from_petgraph(&wide, checked).unwrap()), 1 << 40);
    let negative = petgraph::Graph::<(), i32>::from_edges([(0, 1, -1)]);
    let refused = Graph::try_from(&negative).unwrap_err();
    assert_eq!(refused, MaxflowError::NegativeCapacity { node: 0, value: -1 });
}

#[test]
fn a_graph_without_edges() {
    let mut lone = petgraph::Graph::<(), u32>::new();
    lone.add_node(());
    lone.add_node(());
    assert_eq!(flow(Graph::try_from(&lone).unwrap()), 0);
}

#[test]
fn graphs_of_other_forms() {
    let mut stable =
        petgraph::stable_graph::StableGraph::<(), i64>::from_edges([(0, 1, 5), (1, 2, 9), (0, 3, 2), (3, 2, 1)]);
    stable.remove_node(1.into());
    let graph = Graph::try_from_petgraph(&stable, |&weight| weight).unwrap();
    assert_eq!((graph.len(), graph.arc_count()), (4, 2));
    let csr = petgraph::csr::Csr::<(), i64>::from_sorted_edges(&[(0, 1, 6), (1, 2, 2)]).unwrap();
    assert_eq!(flow(Graph::try_from_petgraph(&csr, |&weight| weight).unwrap()), 2);
}
