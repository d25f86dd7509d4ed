//! Solving again: after changes, after cancelling, with any engine at any time.

use std::cell::Cell;

use crate::common::{Draw, GridCase, Problem, diagonal};
use selvedge_maxflow::{ArcId, Engine, GridGraph, MaxflowError, Side};

const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

fn graph_of(case: &GridCase<2>) -> GridGraph<2> {
    let make = if case.diagonals { GridGraph::with_diagonals } else { GridGraph::new };
    let mut graph = make(case.shape, case.periodic).unwrap();
    case.fill(&mut graph, diagonal);
    graph
}

/// A random side, or none.
fn any_pin(draw: &mut Draw) -> Option<Side> {
    [None, Some(Side::Source), Some(Side::Sink)][draw.below(3)]
}

/// Changes a few capacities and pins of both.
fn edit(case: &mut GridCase<2>, graph: &mut GridGraph<2>, draw: &mut Draw) {
    for _ in 0..1 + draw.below(4) {
        let v = draw.below(case.len());
        let (new, old) = ([draw.below(9) as i32, draw.below(9) as i32], case.terminals[v]);
        graph.change_terminal(v, new[0] - old[0], new[1] - old[1]).unwrap();
        case.terminals[v] = new;
    }
    for _ in 0..draw.below(4) {
        let v = draw.below(case.len());
        case.pins[v] = any_pin(draw);
        match case.pins[v] {
            Some(side) => graph.pin(v, side).unwrap(),
            None => graph.unpin(v).unwrap(),
        }
    }
    for _ in 0..if case.links.is_empty() { 0 } else { draw.below(6) } {
        let k = draw.below(case.links.len());
        let (v, along, forward, backward) = case.links[k];
        let (f, b) = (draw.below(9) as i32, draw.below(9) as i32);
        match along {
            0 | 1 => graph.change_link(v, along, f - forward, b - backward).unwrap(),
            2 => graph.change_diagonal(v, selvedge_maxflow::Diagonal::Main, f - forward, b - backward).unwrap(),
            _ => graph.change_diagonal(v, selvedge_maxflow::Diagonal::Anti, f - forward, b - backward).unwrap(),
        }
        case.links[k] = (v, along, f, b);
    }
}

#[test]
fn a_grid_solved_again_after_changes_is_as_if_new() {
    let mut draw = Draw(31);
    for _ in 0..400 {
        let mut case = GridCase::<2>::random(&mut draw, 60, 9);
        let mut graph = graph_of(&case);
        for _ in 0..6 {
            graph.set_engine(ENGINES[draw.below(4)]);
            let again = graph.solve().unwrap();
            assert_eq!(again, graph_of(&case).solve().unwrap(), "{case:?}");
            assert_eq!(again.flow, case.problem().capacity(again.source_side()));
            edit(&mut case, &mut graph, &mut draw);
        }
    }
}

#[test]
fn a_graph_solved_again_after_changes_is_as_if_new() {
    let mut draw = Draw(32);
    for _ in 0..400 {
        let nodes = 1 + draw.below(30);
        let mut problem = Problem::random(&mut draw, nodes, 9);
        let mut graph = problem.graph();
        let mut ids: Vec<ArcId> = Vec::new();
        for _ in 0..6 {
            graph.set_engine(ENGINES[draw.below(4)]);
            assert_eq!(graph.solve().unwrap(), problem.graph().solve().unwrap(), "{problem:?}");
            let v = draw.below(nodes);
            let (new, old) = ([draw.below(9) as i64, draw.below(9) as i64], problem.terminals[v]);
            graph.change_terminal(v, new[0] - old[0], new[1] - old[1]).unwrap();
            problem.terminals[v] = new;
            problem.pins[v] = any_pin(&mut draw);
            match problem.pins[v] {
                Some(side) => graph.pin(v, side).unwrap(),
                None => graph.unpin(v).unwrap(),
            }
            let (v, w, c) = (draw.below(nodes), draw.below(nodes), draw.below(9) as i64);
            ids.push(graph.arc(v, w, c, 0).unwrap());
            problem.arcs.push((v, w, c));
            let k = draw.below(ids.len());
            let at = problem.arcs.len() - ids.len() + k;
            let c = draw.below(9) as i64;
            graph.change_arc(ids[k], c - problem.arcs[at].2, 0).unwrap();
            problem.arcs[at].2 = c;
        }
    }
}

#[test]
fn a_cancelled_solve_keeps_its_flow() {
    let mut draw = Draw(33);
    let mut cancelled = 0;
    for engine in [Engine::Trees, Engine::Pseudoflow, Engine::Auto] {
        for patience in [0, 1, 3, 10] {
            let mut case = GridCase::<2>::blank([90, 80]);
            for v in 0..case.len() {
                case.terminals[v] = [draw.below(40) as i32, draw.below(40) as i32];
                for axis in 0..2 {
                    if case.neighbour(v, axis).is_some() {
                        case.links.push((v, axis, draw.below(30) as i32, draw.below(30) as i32));
                    }
                }
            }
            let mut graph = graph_of(&case);
            graph.set_engine(engine);
            let asked = Cell::new(0);
            let stop = || asked.replace(asked.get() + 1) >= patience;
            if let Err(error) = graph.solve_until(&stop) {
                assert_eq!(error, MaxflowError::Cancelled);
                cancelled += 1;
            }
            let cut = graph.solve().unwrap();
            assert_eq!(cut, graph_of(&case).solve().unwrap());
            assert_eq!(cut.flow, case.problem().capacity(cut.source_side()));
        }
    }
    assert!(cancelled >= 6, "only {cancelled} solves were long enough to be cancelled");
}

#[test]
fn changes_that_take_too_much_are_refused_and_change_nothing() {
    let mut graph = GridGraph::new([1, 2], [false, false]).unwrap();
    graph.pin(0, Side::Source).unwrap();
    graph.pin(1, Side::Sink).unwrap();
    graph.link(0, 1, 5, 2).unwrap();
    assert_eq!(graph.solve().unwrap().flow, 5);
    assert!(matches!(graph.change_link(0, 1, -8, 0), Err(MaxflowError::NegativeCapacity { node: 0, value: -1 })));
    assert_eq!(graph.solve().unwrap().flow, 5);
    graph.change_link(0, 1, -4, 0).unwrap();
    assert_eq!(graph.solve().unwrap().flow, 1);
}
