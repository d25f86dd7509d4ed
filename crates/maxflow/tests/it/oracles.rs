//! Ten thousand random graphs a run, half of them grids, against every cut or an independent solver.

use crate::common::{Draw, GridCase, Problem, diagonal, no_diagonal};
use petgraph::algo::ford_fulkerson;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;
use selvedge_maxflow::{Diagonal, Engine, GridGraph, Side};

const ENGINES: [Engine; 3] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow];

/// Flow and smallest source side by petgraph.
fn by_petgraph(problem: &Problem) -> (i64, Vec<bool>) {
    let n = problem.terminals.len();
    let endless = 1 + problem.terminals.iter().flatten().sum::<i64>() + problem.arcs.iter().map(|a| a.2).sum::<i64>();
    let mut graph = petgraph::Graph::<(), u64>::new();
    let nodes: Vec<NodeIndex> = (0..n + 2).map(|_| graph.add_node(())).collect();
    let (source, sink) = (nodes[n], nodes[n + 1]);
    for (&node, (&[mut s, mut t], pin)) in nodes.iter().zip(problem.terminals.iter().zip(&problem.pins)) {
        match pin {
            Some(Side::Source) => s += endless,
            Some(Side::Sink) => t += endless,
            None => {}
        }
        graph.add_edge(source, node, s as u64);
        graph.add_edge(node, sink, t as u64);
    }
    for &(v, w, c) in &problem.arcs {
        graph.add_edge(nodes[v], nodes[w], c as u64);
    }
    let (flow, flows) = ford_fulkerson(&graph, source, sink);
    let mut reached = vec![false; n + 2];
    reached[n] = true;
    let mut stack = vec![source];
    while let Some(v) = stack.pop() {
        let out = graph.edges_directed(v, petgraph::Outgoing).filter(|e| flows[e.id().index()] < *e.weight());
        let back = graph.edges_directed(v, petgraph::Incoming).filter(|e| flows[e.id().index()] > 0);
        for w in out.map(|e| e.target()).chain(back.map(|e| e.source())) {
            if !std::mem::replace(&mut reached[w.index()], true) {
                stack.push(w);
            }
        }
    }
    reached.truncate(n);
    (flow as i64, reached)
}

fn expected(problem: &Problem) -> (i64, Vec<bool>) {
    if problem.terminals.len() <= 16 { problem.by_enumeration() } else { by_petgraph(problem) }
}

#[track_caller]
fn check_sparse(problem: &Problem, expected: &(i64, Vec<bool>)) {
    for engine in ENGINES {
        let mut graph = problem.graph();
        graph.set_engine(engine);
        problem.check(&graph.solve().unwrap(), expected);
    }
}

fn grids<const D: usize>(
    seed: u64,
    cases: usize,
    make: fn(&GridCase<D>) -> GridGraph<D>,
    link: fn(&mut GridGraph<D>, usize, Diagonal, i32, i32),
) {
    let mut draw = Draw(seed);
    for round in 0..cases {
        let nodes = if round % 10 == 0 { 120 } else { 2 + draw.below(15) };
        let case = GridCase::<D>::random(&mut draw, nodes, [3, 20, 1000][round % 3]);
        let problem = case.problem();
        let expected = expected(&problem);
        for engine in ENGINES {
            let mut graph = make(&case);
            graph.set_engine(engine);
            case.fill(&mut graph, link);
            problem.check(&graph.solve().unwrap(), &expected);
        }
        check_sparse(&problem, &expected);
    }
}

#[test]
fn one_thousand_lines() {
    grids::<1>(21, 1000, |case| GridGraph::new(case.shape, case.periodic).unwrap(), no_diagonal);
}

#[test]
fn two_thousand_planes() {
    let make = |case: &GridCase<2>| {
        let make = if case.diagonals { GridGraph::with_diagonals } else { GridGraph::new };
        make(case.shape, case.periodic).unwrap()
    };
    grids::<2>(22, 2000, make, diagonal);
}

#[test]
fn two_thousand_volumes() {
    grids::<3>(23, 2000, |case| GridGraph::new(case.shape, case.periodic).unwrap(), no_diagonal);
}

#[test]
fn five_thousand_graphs_of_any_form() {
    let mut draw = Draw(24);
    for round in 0..5000 {
        let nodes = if round % 10 == 0 { 20 + draw.below(100) } else { 1 + draw.below(16) };
        let problem = Problem::random(&mut draw, nodes, [3, 20, 1 << 40][round % 3]);
        check_sparse(&problem, &expected(&problem));
    }
}

#[test]
fn the_two_oracles_agree() {
    let mut draw = Draw(25);
    for _ in 0..200 {
        let nodes = 1 + draw.below(10);
        let problem = Problem::random(&mut draw, nodes, 9);
        assert_eq!(problem.by_enumeration(), by_petgraph(&problem), "{problem:?}");
    }
}
