//! Graphs from bytes: what the fuzzer feeds, and what the corpus replays.
//!
//! Any bytes are a problem: shape, topology and kind of graph come first, then terminals, pins, masks and links as far
//! as the bytes go; missing bytes are zeros. Sizes are bounded, so every run ends soon.

use selvedge_maxflow::{Engine, Graph, GridGraph, MinCut, Side};

/// Engines by the byte that chooses them.
const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> usize {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        usize::from(first)
    }

    /// A capacity; some are huge.
    fn capacity(&mut self) -> i32 {
        let byte = self.next() as i32;
        if byte < 240 { byte / 4 } else { byte << 17 }
    }
}

/// Builds the problem as a grid and as a sparse graph, solves both, changes them, solves again, and checks everything
/// against everything: engines, certificates, and the general solver as the oracle of the grid.
pub(crate) fn run(data: &[u8]) {
    let mut bytes = Bytes(data);
    let shape = [1 + bytes.next() % 7, 1 + bytes.next() % 7];
    let kind = bytes.next();
    let periodic = [kind & 1 == 1, kind & 2 == 2];
    let mut grid = GridGraph::new(shape, periodic).expect("a small grid");
    let mut sparse = Graph::new(grid.len()).expect("a small graph");
    let mut masked = vec![false; grid.len()];
    if kind & 4 == 4 {
        for (v, masked) in masked.iter_mut().enumerate() {
            *masked = bytes.next() > 200;
            if *masked {
                grid.mask(v).expect("a mask before anything else");
            }
        }
    }
    let mut arcs = Vec::new();
    for v in 0..grid.len() {
        terminals(&mut grid, &mut sparse, v, masked[v], &mut bytes);
        for axis in 0..2 {
            let Some(w) = grid.next(v, axis) else { continue };
            let (forward, back) = (bytes.capacity(), bytes.capacity());
            let fits = grid.link(v, axis, forward, back).is_ok();
            if fits && v != w && !masked[v] && !masked[w] {
                arcs.push((v, axis, sparse.arc(v, w, forward.into(), back.into()).expect("room")));
            }
        }
    }
    for _ in 0..3 {
        grid.set_engine(ENGINES[bytes.next() % 4]);
        sparse.set_engine(ENGINES[bytes.next() % 4]);
        let cut = agree(&mut grid, &mut sparse);
        let mut fresh = grid.clone();
        fresh.set_engine(ENGINES[bytes.next() % 4]);
        assert_eq!(fresh.solve(&|| false).expect("not cancelled"), cut, "solving a solved graph");
        let v = bytes.next() % grid.len();
        terminals(&mut grid, &mut sparse, v, masked[v], &mut bytes);
        if let Some(&(v, axis, arc)) = arcs.get(bytes.next()) {
            let (forward, back) = (bytes.capacity() - 9, bytes.capacity() - 9);
            if grid.change_link(v, axis, forward, back).is_ok() {
                sparse.change_arc(arc, forward.into(), back.into()).expect("what the grid took");
            }
        }
    }
}

/// Gives a node terminals and a pin, to both graphs.
fn terminals(grid: &mut GridGraph<2>, sparse: &mut Graph, v: usize, masked: bool, bytes: &mut Bytes<'_>) {
    let (source, sink) = (bytes.capacity(), bytes.capacity());
    if grid.terminal(v, source, sink).is_ok() && !masked {
        sparse.terminal(v, source.into(), sink.into()).expect("room");
    }
    let side = match bytes.next() {
        250.. => Side::Source,
        240.. => Side::Sink,
        _ => return,
    };
    grid.pin(v, side).expect("a node");
    if !masked {
        sparse.pin(v, side).expect("a node");
    }
}

fn agree(grid: &mut GridGraph<2>, sparse: &mut Graph) -> MinCut {
    let cut = grid.solve(&|| false).expect("not cancelled");
    assert_eq!(grid.capacity_of(cut.source_side()).expect("its size"), cut.flow, "flow and capacity");
    assert_eq!(sparse.solve(&|| false).expect("not cancelled"), cut, "grid and sparse graph");
    cut
}
