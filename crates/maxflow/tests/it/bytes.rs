//! Graphs from bytes: what the fuzzers feed, and what the corpus replays.
//!
//! Any bytes are a problem: shape, topology and kind of graph come first, then terminals, pins, masks and links as far
//! as the bytes go; missing bytes are zeros. Sizes are bounded, so every run ends soon.

use selvedge_maxflow::{ArcId, Diagonal, Engine, Graph, GridGraph, MinCut, Side, dimacs};

/// Engines by the byte that chooses them.
const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];
/// Largest number of nodes of which all cuts are looked at.
const ALL_CUTS: usize = 9;

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

/// The same problem three times: as a grid, as a sparse graph, and as plain lists.
struct Case {
    grid: GridGraph<2>,
    sparse: Graph,
    masked: Vec<bool>,
    terminals: Vec<[i64; 2]>,
    pins: Vec<Option<Side>>,
    links: Vec<Link>,
}

/// A link of the grid: its first node, axis 0 or 1 or a diagonal (2, 3), the other node, its arc, capacities.
struct Link {
    node: usize,
    along: usize,
    next: usize,
    arc: ArcId,
    capacities: [i64; 2],
}

/// Builds the problem, solves it, changes it, solves again, and checks everything against everything: engines,
/// certificates, the general solver, and where there are few nodes all cuts there are.
pub(crate) fn run(data: &[u8]) {
    let mut bytes = Bytes(data);
    let mut case = Case::of(&mut bytes);
    for _ in 0..3 {
        case.grid.set_engine(ENGINES[bytes.next() % 4]);
        case.sparse.set_engine(ENGINES[bytes.next() % 4]);
        let cut = case.agree();
        let mut again = case.grid.clone();
        again.set_engine(ENGINES[bytes.next() % 4]);
        assert_eq!(again.solve().expect("not cancelled"), cut, "solving a solved graph");
        let v = bytes.next() % case.grid.len();
        case.set_terminals(v, &mut bytes);
        let k = bytes.next();
        if k < case.links.len() {
            case.change(k, bytes.capacity() - 9, bytes.capacity() - 9);
        }
    }
}

/// Reads a DIMACS file of any bytes. What can be read is written, read again and solved.
pub(crate) fn run_dimacs(data: &[u8]) {
    let Ok(problem) = dimacs::Problem::read(data) else { return };
    let mut text = Vec::new();
    problem.write(&mut text).expect("memory");
    assert_eq!(dimacs::Problem::read(&text[..]).as_ref(), Ok(&problem));
    if problem.nodes <= 1 << 12
        && let Ok(mut graph) = problem.graph()
    {
        let cut = graph.solve().expect("not cancelled");
        assert_eq!(graph.capacity_of(cut.source_side()), Ok(cut.flow));
        assert_eq!(graph.cut_arcs(&cut).map(|arc| arc.2).sum::<i64>(), cut.flow);
    }
}

impl Case {
    fn of(bytes: &mut Bytes<'_>) -> Self {
        let shape = [1 + bytes.next() % 7, 1 + bytes.next() % 7];
        let kind = bytes.next();
        let periodic = [kind & 1 == 1, kind & 2 == 2];
        let make = if kind & 8 == 8 { GridGraph::with_diagonals } else { GridGraph::new };
        let grid = make(shape, periodic).expect("a small grid");
        let (n, sparse) = (grid.len(), Graph::new(grid.len()).expect("a small graph"));
        let (masked, terminals, pins) = (vec![false; n], vec![[0; 2]; n], vec![None; n]);
        let mut case = Self { grid, sparse, masked, terminals, pins, links: Vec::new() };
        for v in (0..n).filter(|_| kind & 4 == 4) {
            case.masked[v] = bytes.next() > 200;
            if case.masked[v] {
                case.grid.mask(v).expect("a mask before anything else");
            }
        }
        for v in 0..n {
            case.set_terminals(v, bytes);
            for along in 0..if kind & 8 == 8 { 4 } else { 2 } {
                let next = case.next(v, along);
                let capacities = [bytes.capacity(), bytes.capacity()];
                let fits = link(&mut case.grid, v, along, capacities).is_ok();
                let Some(next) = next else {
                    assert!(!fits, "a link that leaves the grid");
                    continue;
                };
                if fits && v != next && !case.masked[v] && !case.masked[next] {
                    let capacities = capacities.map(i64::from);
                    let arc = case.sparse.arc(v, next, capacities[0], capacities[1]).expect("room");
                    case.links.push(Link { node: v, along, next, arc, capacities });
                }
            }
        }
        case
    }

    /// Where a link leads, from positions.
    fn next(&self, v: usize, along: usize) -> Option<usize> {
        let [rows, columns] = self.grid.shape();
        let on =
            |at: usize, len: usize, axis: usize| (at + 1 < len || self.grid.periodic()[axis]).then_some((at + 1) % len);
        let back =
            |at: usize, len: usize, axis: usize| (at > 0 || self.grid.periodic()[axis]).then_some((at + len - 1) % len);
        let (row, column) = (v / columns, v % columns);
        let row = if along == 1 { row } else { on(row, rows, 0)? };
        let column = match along {
            0 => column,
            1 | 2 => on(column, columns, 1)?,
            _ => back(column, columns, 1)?,
        };
        Some(row * columns + column)
    }

    /// Gives a node terminals and a pin, everywhere.
    fn set_terminals(&mut self, v: usize, bytes: &mut Bytes<'_>) {
        let (source, sink) = (bytes.capacity(), bytes.capacity());
        if self.grid.terminal(v, source, sink).is_ok() && !self.masked[v] {
            self.sparse.terminal(v, source.into(), sink.into()).expect("room");
            self.terminals[v][0] += i64::from(source);
            self.terminals[v][1] += i64::from(sink);
        }
        let side = match bytes.next() {
            250.. => Side::Source,
            240.. => Side::Sink,
            _ => return,
        };
        self.grid.pin(v, side).expect("a node");
        if !self.masked[v] {
            self.sparse.pin(v, side).expect("a node");
            self.pins[v] = Some(side);
        }
    }

    /// Changes a link. The sparse graph tells whether there was so much to take back; the grid may have less headroom.
    fn change(&mut self, k: usize, forward: i32, backward: i32) {
        let link = &mut self.links[k];
        if self.sparse.change_arc(link.arc, forward.into(), backward.into()).is_err() {
            return;
        }
        let changed = match link.along {
            along @ (0 | 1) => self.grid.change_link(link.node, along, forward, backward),
            2 => self.grid.change_diagonal(link.node, Diagonal::Main, forward, backward),
            _ => self.grid.change_diagonal(link.node, Diagonal::Anti, forward, backward),
        };
        if changed.is_ok() {
            link.capacities[0] += i64::from(forward);
            link.capacities[1] += i64::from(backward);
        } else {
            self.sparse.change_arc(link.arc, -i64::from(forward), -i64::from(backward)).expect("what it had");
        }
    }

    fn agree(&mut self) -> MinCut {
        let cut = self.grid.solve().expect("not cancelled");
        assert_eq!(self.grid.capacity_of(cut.source_side()).expect("its size"), cut.flow, "the grid's books");
        assert_eq!(self.capacity(cut.source_side()), cut.flow, "flow and capacity");
        assert_eq!(self.sparse.solve().expect("not cancelled"), cut, "grid and sparse graph");
        if self.masked.len() <= ALL_CUTS {
            assert_eq!(self.least(), (cut.flow, cut.source_side().to_vec()), "all cuts");
        }
        cut
    }

    /// Capacity of a cut by definition.
    fn capacity(&self, side: &[bool]) -> i64 {
        let terminals: i64 = self.terminals.iter().zip(side).map(|(t, &s)| t[usize::from(s)]).sum();
        let halves =
            self.links.iter().flat_map(|l| [(l.node, l.next, l.capacities[0]), (l.next, l.node, l.capacities[1])]);
        terminals + halves.filter(|&(v, w, _)| side[v] && !side[w]).map(|(_, _, c)| c).sum::<i64>()
    }

    /// The least capacity of all cuts, and what their source sides have in common.
    fn least(&self) -> (i64, Vec<bool>) {
        let n = self.masked.len();
        let mut best = (i64::MAX, Vec::new());
        for bits in 0..1_u32 << n {
            let side: Vec<bool> = (0..n).map(|v| bits >> v & 1 == 1).collect();
            let allowed = |v: usize| {
                !(self.masked[v] && side[v] || self.pins[v].is_some_and(|pin| side[v] != (pin == Side::Source)))
            };
            if !(0..n).all(allowed) {
                continue;
            }
            let capacity = self.capacity(&side);
            if capacity < best.0 {
                best = (capacity, side);
            } else if capacity == best.0 {
                best.1.iter_mut().zip(side).for_each(|(common, s)| *common &= s);
            }
        }
        best
    }
}

fn link(
    grid: &mut GridGraph<2>,
    v: usize,
    along: usize,
    [forward, backward]: [i32; 2],
) -> selvedge_maxflow::Result<()> {
    match along {
        0 | 1 => grid.link(v, along, forward, backward),
        2 => grid.link_diagonal(v, Diagonal::Main, forward, backward),
        _ => grid.link_diagonal(v, Diagonal::Anti, forward, backward),
    }
}
