//! Instances of texture synthesis with known answers.

mod common;

use common::Problem;
use selvedge_maxflow::{Engine, Graph, GridGraph, MinCut, Side};

struct Golden {
    problem: Problem,
    /// Depth, height, width.
    shape: [usize; 3],
    /// Auxiliary nodes, after the cells.
    auxiliary: usize,
    /// Edges: ends, capacity forward and back.
    edges: Vec<([usize; 2], [i64; 2])>,
}

impl Golden {
    /// The format is told in `golden/README.md`.
    fn read(bytes: &[u8]) -> Self {
        let mut bytes = bytes.iter();
        let mut next = || {
            let (mut value, mut shift) = (0_u64, 0);
            loop {
                let byte = *bytes.next().expect("a whole file");
                value |= u64::from(byte & 127) << shift;
                shift += 7;
                if byte < 128 {
                    return value as i64;
                }
            }
        };
        let [width, height, depth, auxiliary, edge_count] = std::array::from_fn(|_| next() as usize);
        let mut problem = Problem::default();
        for _ in 0..width * height * depth + auxiliary {
            let kind = next();
            problem.pins.push([None, Some(Side::Source), Some(Side::Sink), None][kind as usize]);
            problem.terminals.push(if kind == 3 { [next(), next()] } else { [0, 0] });
        }
        let signed = |x: i64| if x & 1 == 0 { x >> 1 } else { -(x >> 1) - 1 };
        let (mut edges, mut tail) = (Vec::new(), 0);
        for _ in 0..edge_count {
            tail += signed(next());
            let head = tail + signed(next());
            let packed = next();
            let capacities = [packed >> 1, if packed & 1 == 0 { packed >> 1 } else { next() }];
            edges.push(([tail as usize, head as usize], capacities));
        }
        for &([v, w], [forward, back]) in &edges {
            problem.arcs.extend([(v, w, forward), (w, v, back)]);
        }
        Self { problem, shape: [depth, height, width], auxiliary, edges }
    }

    /// As a sparse graph; `reversed`: source and sink exchanged, arcs turned around.
    fn graph(&self, reversed: bool) -> Graph {
        let mut graph = Graph::new(self.problem.terminals.len()).unwrap();
        let turn = |side| if reversed == (side == Side::Source) { Side::Sink } else { Side::Source };
        for (v, (&[s, t], &pin)) in self.problem.terminals.iter().zip(&self.problem.pins).enumerate() {
            if reversed {
                graph.terminal(v, t, s).unwrap()
            } else {
                graph.terminal(v, s, t).unwrap()
            }
            if let Some(side) = pin {
                graph.pin(v, turn(side)).unwrap();
            }
        }
        for &([v, w], [forward, back]) in &self.edges {
            if reversed { graph.arc(v, w, back, forward) } else { graph.arc(v, w, forward, back) }.unwrap();
        }
        graph
    }

    /// As a grid, for instances without auxiliary nodes.
    fn grid<const D: usize>(&self, shape: [usize; D]) -> GridGraph<D> {
        let mut graph = GridGraph::new(shape, [false; D]).unwrap();
        for (v, (t, &pin)) in self.problem.terminals.iter().zip(&self.problem.pins).enumerate() {
            graph.terminal(v, t[0] as i32, t[1] as i32).unwrap();
            if let Some(side) = pin {
                graph.pin(v, side).unwrap();
            }
        }
        for &([v, w], [forward, back]) in &self.edges {
            let axis = (0..D).find(|&a| graph.next(v.min(w), a) == Some(v.max(w))).unwrap();
            let (forward, back) = if v < w { (forward, back) } else { (back, forward) };
            graph.link(v.min(w), axis, forward as i32, back as i32).unwrap();
        }
        graph
    }
}

/// The answer from every engine, through a grid where there are no auxiliary nodes.
#[track_caller]
fn check(bytes: &[u8], flow: i64, source_side: usize, sink_side: usize) {
    let golden = Golden::read(bytes);
    let expect = |cut: &MinCut, from: &str| {
        assert_eq!((cut.flow, cut.source_len()), (flow, source_side), "{from}");
        assert_eq!(golden.problem.capacity(cut.source_side()), flow, "{from}");
    };
    let sparse = golden.graph(false).solve(&|| false).unwrap();
    expect(&sparse, "sparse");
    let reversed = golden.graph(true).solve(&|| false).unwrap();
    assert_eq!((reversed.flow, reversed.source_len()), (flow, sink_side), "the smallest sink side");
    for engine in [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath] {
        let solve_grid = || match golden.shape {
            [1, height, width] => {
                let mut grid = golden.grid([height, width]);
                grid.set_engine(engine);
                grid.solve(&|| false).unwrap()
            }
            shape => {
                let mut grid = golden.grid(shape);
                grid.set_engine(engine);
                grid.solve(&|| false).unwrap()
            }
        };
        if golden.auxiliary == 0 {
            assert_eq!(solve_grid(), sparse, "grid, {engine:?}");
        } else {
            let mut graph = golden.graph(false);
            graph.set_engine(engine);
            assert_eq!(graph.solve(&|| false).unwrap(), sparse, "sparse, {engine:?}");
        }
    }
}

#[test]
fn strips() {
    check(include_bytes!("golden/strip_8x32.bin"), 5728, 224, 32);
    check(include_bytes!("golden/strip_32x256.bin"), 854_965, 3046, 5146);
}

#[test]
fn overlay_with_seam_nodes() {
    check(include_bytes!("golden/overlay_64x64.bin"), 1_004_733, 2183, 2337);
}

#[test]
fn transition_between_clips() {
    check(include_bytes!("golden/transition_40x30x12.bin"), 1_227_402, 1748, 12_652);
}

#[test]
fn expansion_of_a_label() {
    check(include_bytes!("golden/expansion_128x128.bin"), 2_818_762, 15_182, 1202);
}
