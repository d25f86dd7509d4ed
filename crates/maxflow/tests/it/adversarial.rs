//! Graphs that one engine or another is bad at, and work that has to stay bounded on them.
//!
//! Work is told by how often an engine asks whether to stop: engine T once in 2^14 arcs and ancestors looked at, engine
//! P once in 4,096 trees. Time itself is not tested.

use std::cell::Cell;

use crate::common::Draw;
use selvedge_maxflow::{Engine, Graph, GridGraph, MinCut, Side};

const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

/// Solves and counts how often it was asked whether to stop.
fn polls<const D: usize>(graph: &mut GridGraph<D>) -> (MinCut, usize) {
    let polls = Cell::new(0);
    let cut = graph.solve_until(&|| {
        polls.set(polls.get() + 1);
        false
    });
    (cut.unwrap(), polls.get())
}

/// A clip of noise between a first frame pinned to the source and a last one pinned to the sink; costs by seed.
fn transition(shape: [usize; 3], seed: u64) -> (GridGraph<3>, Vec<(usize, usize, i32)>) {
    let (mut graph, mut draw) = (GridGraph::new(shape, [false; 3]).unwrap(), Draw(seed));
    let mut links = Vec::new();
    for v in 0..graph.len() {
        for axis in 0..3 {
            if graph.next(v, axis).is_some() {
                let cost = 1 + draw.below(900) as i32;
                graph.link(v, axis, cost, cost).unwrap();
                links.push((v, axis, cost));
            }
        }
    }
    let frame = shape[1] * shape[2];
    for v in 0..frame {
        graph.pin(v, Side::Source).unwrap();
        graph.pin(graph.len() - 1 - v, Side::Sink).unwrap();
    }
    (graph, links)
}

#[test]
fn a_transition_solved_again_is_as_if_new_and_no_trap() {
    let shape = [12, 30, 40];
    let (mut graph, links) = transition(shape, 1);
    let (_, cold) = polls(&mut graph);
    // Brush strokes in two frames, one of either side.
    let mut strokes = Vec::new();
    for (frame, side) in [(8, Side::Source), (3, Side::Sink)] {
        let at = (10..20).flat_map(|y| (5..15).map(move |x| [frame, y, x]));
        strokes.extend(at.map(|at| (graph.node(at), side)));
        let mut fresh = transition(shape, 1).0;
        for &(v, side) in &strokes {
            graph.pin(v, side).unwrap();
            fresh.pin(v, side).unwrap();
        }
        let (again, warm) = polls(&mut graph);
        assert_eq!(again, fresh.solve().unwrap());
        assert!(warm <= cold + 10, "{warm} polls, {cold} from nothing");
    }
    // Every link changed at once.
    let (mut graph, _) = transition(shape, 1);
    graph.solve().unwrap();
    let (mut other, others) = transition(shape, 2);
    for (&(v, axis, old), &(_, _, new)) in links.iter().zip(&others) {
        graph.change_link(v, axis, new - old, new - old).unwrap();
    }
    let ((again, warm), (fresh, cold)) = (polls(&mut graph), polls(&mut other));
    assert_eq!(again, fresh);
    assert!(warm <= 3 * cold + 10, "{warm} polls, {cold} from nothing");
}

#[test]
fn a_breath_of_a_terminal_everywhere_is_no_trap() {
    let shape = [12, 30, 40];
    let solve = |engine| {
        let (mut graph, _) = transition(shape, 3);
        for v in 0..graph.len() {
            graph.terminal(v, (v % 2) as i32, ((v + 1) % 2) as i32).unwrap();
        }
        graph.set_engine(engine);
        polls(&mut graph)
    };
    let ((auto, work), (named, least)) = (solve(Engine::Auto), solve(Engine::Pseudoflow));
    assert_eq!(auto, named);
    assert!(work <= 3 * least + 100, "{work} polls, {least} by engine P");
}

#[test]
fn a_star_with_many_leaves() {
    let leaves = 3000;
    let mut cuts = ENGINES.map(|engine| {
        let mut graph = Graph::new(leaves + 1).unwrap();
        graph.set_engine(engine);
        for v in 1..=leaves {
            let terminal = if v % 2 == 0 { [1 + v as i64 % 7, 0] } else { [0, 1 + v as i64 % 5] };
            graph.terminal(v, terminal[0], terminal[1]).unwrap();
            graph.arc(v, 0, 3, 3).unwrap();
        }
        graph.solve().unwrap()
    });
    // What comes in through the middle is at most 3 a leaf; so is what goes out.
    let sum = |of: &dyn Fn(i64) -> i64, parity| (1..=leaves as i64).filter(|v| v % 2 == parity).map(of).sum::<i64>();
    let (inward, outward) = (sum(&|v| (1 + v % 7).min(3), 0), sum(&|v| (1 + v % 5).min(3), 1));
    assert_eq!(cuts[0].flow, inward.min(outward));
    cuts.sort_by_key(|cut| cut.source_len());
    assert!(cuts.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn saturated_graphs_have_nothing_to_push() {
    for engine in ENGINES {
        let mut graph = GridGraph::new([9, 9], [false, true]).unwrap();
        graph.set_engine(engine);
        // All that is given to the left half has to leave through links that take just that much.
        for row in 0..9 {
            for column in 0..9 {
                let v = graph.node([row, column]);
                graph
                    .link(
                        v,
                        1,
                        if column == 4 {
                            5
                        } else if column < 8 {
                            1000
                        } else {
                            0
                        },
                        0,
                    )
                    .unwrap();
                graph.terminal(v, if column == 0 { 5 } else { 0 }, if column == 8 { 5 } else { 0 }).unwrap();
            }
        }
        let cut = graph.solve().unwrap();
        assert_eq!((cut.flow, cut.source_len()), (45, 0), "every arc of four cuts is full: the smallest side is empty");
        assert_eq!(graph.solve().unwrap(), cut);
    }
}

#[test]
fn disconnected_parts_are_cut_each_for_itself() {
    let mut draw = Draw(5);
    for engine in ENGINES {
        let (mut whole, mut flow, mut sides) = (GridGraph::new([8, 20], [false; 2]).unwrap(), 0, vec![false; 160]);
        whole.set_engine(engine);
        // Four parts of five columns, without links between them; the last has no sink, the third no source.
        for part in 0..4 {
            let mut alone = GridGraph::new([8, 5], [false; 2]).unwrap();
            for v in 0..40 {
                let there = v / 5 * 20 + 5 * part + v % 5;
                let terminal = [if part == 2 { 0 } else { draw.below(9) }, if part == 3 { 0 } else { draw.below(9) }];
                let [source, sink] = terminal.map(|t| t as i32);
                alone.terminal(v, source, sink).unwrap();
                whole.terminal(there, source, sink).unwrap();
                for axis in 0..2 {
                    let capacity = draw.below(9) as i32;
                    if alone.link(v, axis, capacity, capacity).is_ok() {
                        whole.link(there, axis, capacity, capacity).unwrap();
                    }
                }
            }
            let cut = alone.solve().unwrap();
            flow += cut.flow;
            (0..40).for_each(|v| sides[v / 5 * 20 + 5 * part + v % 5] = cut.source_side()[v]);
        }
        let cut = whole.solve().unwrap();
        assert_eq!((cut.flow, cut.source_side()), (flow, &sides[..]));
    }
}
