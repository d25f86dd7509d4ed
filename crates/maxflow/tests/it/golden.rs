//! Instances of texture synthesis with known answers.

use std::path::Path;

use crate::common::Problem;
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
    /// An instance of the developers' data. Terminals of 2^28 and more are pins.
    fn of_archive(path: &Path) -> Self {
        let arrays = crate::npz::Arrays::read(path);
        let dims: Vec<usize> = arrays.get("dims").iter().map(|&d| d as usize).collect();
        let mut problem = Problem::default();
        for (source, sink) in arrays.get("src").into_iter().zip(arrays.get("snk")) {
            let infinite = 1 << 28;
            let pin = [(source, Side::Source), (sink, Side::Sink)].into_iter().find(|&(c, _)| c >= infinite);
            problem.pins.push(pin.map(|(_, side)| side));
            problem.terminals.push([source, sink].map(|c| if c >= infinite { c - infinite } else { c }));
        }
        let [tails, heads, forward, back] = ["u", "v", "cap", "rev"].map(|name| arrays.get(name));
        let edge = |k: usize| ([tails[k] as usize, heads[k] as usize], [forward[k], back[k]]);
        Self::of(problem, [dims[2], dims[1], dims[0]], dims[3], (0..tails.len()).map(edge).collect())
    }

    fn of(mut problem: Problem, shape: [usize; 3], auxiliary: usize, edges: Vec<([usize; 2], [i64; 2])>) -> Self {
        for &([v, w], [forward, back]) in &edges {
            problem.arcs.extend([(v, w, forward), (w, v, back)]);
        }
        Self { problem, shape, auxiliary, edges }
    }

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
        Self::of(problem, [depth, height, width], auxiliary, edges)
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
fn check(golden: &Golden, flow: i64, source_side: usize, sink_side: usize) {
    let expect = |cut: &MinCut, from: &str| {
        assert_eq!((cut.flow, cut.source_len()), (flow, source_side), "{from}");
        assert_eq!(golden.problem.capacity(cut.source_side()), flow, "{from}");
    };
    let sparse = golden.graph(false).solve().unwrap();
    expect(&sparse, "sparse");
    let reversed = golden.graph(true).solve().unwrap();
    assert_eq!((reversed.flow, reversed.source_len()), (flow, sink_side), "the smallest sink side");
    for engine in [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath] {
        let solve_grid = || match golden.shape {
            [1, height, width] => {
                let mut grid = golden.grid([height, width]);
                grid.set_engine(engine);
                grid.solve().unwrap()
            }
            shape => {
                let mut grid = golden.grid(shape);
                grid.set_engine(engine);
                grid.solve().unwrap()
            }
        };
        if golden.auxiliary == 0 {
            assert_eq!(solve_grid(), sparse, "grid, {engine:?}");
        } else {
            let mut graph = golden.graph(false);
            graph.set_engine(engine);
            assert_eq!(graph.solve().unwrap(), sparse, "sparse, {engine:?}");
        }
    }
}

#[test]
fn strips() {
    check(&Golden::read(include_bytes!("golden/strip_8x32.bin")), 5728, 224, 32);
    check(&Golden::read(include_bytes!("golden/strip_32x256.bin")), 854_965, 3046, 5146);
}

#[test]
fn overlay_with_seam_nodes() {
    check(&Golden::read(include_bytes!("golden/overlay_64x64.bin")), 1_004_733, 2183, 2337);
}

#[test]
fn transition_between_clips() {
    check(&Golden::read(include_bytes!("golden/transition_40x30x12.bin")), 1_227_402, 1748, 12_652);
}

#[test]
fn expansion_of_a_label() {
    check(&Golden::read(include_bytes!("golden/expansion_128x128.bin")), 2_818_762, 15_182, 1202);
}

/// All instances of the developers' data, with the answers that stand beside them.
#[test]
fn instances_of_the_data_folder() {
    let Some(root) = std::env::var_os("SELVEDGE_DATA") else {
        eprintln!("SKIPPED: SELVEDGE_DATA is not set");
        return;
    };
    for (name, flow, source_side, sink_side) in [
        ("A_8x32_brick_eq1", 5728, 224, 32),
        ("A_32x256_ihc_eq5", 854_965, 3046, 5146),
        ("B_64_ihc_eq5", 1_004_733, 2183, 2337),
        ("B_128_brick_eq1", 155_840, 5078, 12_162),
        ("C_40x30x12_time_eq5", 1_227_402, 1748, 12_652),
        ("C_60x45x20_box_eq5", 2_615_325, 51_199, 2801),
        ("D_128_kz_exp001", 2_702_021, 5413, 10_971),
        ("D_128_kz_exp010", 2_818_762, 15_182, 1202),
        ("D_128_aux_exp020", 5_264_542, 20_238, 554),
    ] {
        let golden = Golden::of_archive(&Path::new(&root).join("maxflow").join(format!("{name}.npz")));
        check(&golden, flow, source_side, sink_side);
        eprintln!("{name}: as expected");
    }
}
