//! Random problems in a form of their own, the slow definition of a cut, and an independent solver.

use selvedge_maxflow::{Diagonal, Graph, GridGraph, MinCut, Side};

/// SplitMix64: small, and enough for drawing test cases.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Uniform in `0..n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub(crate) fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }
}

/// A problem on a grid, kept apart from the solver under test.
#[derive(Clone, Debug)]
pub(crate) struct GridCase<const D: usize> {
    pub(crate) shape: [usize; D],
    pub(crate) periodic: [bool; D],
    pub(crate) diagonals: bool,
    pub(crate) masked: Vec<bool>,
    pub(crate) pins: Vec<Option<Side>>,
    /// From the source, to the sink.
    pub(crate) terminals: Vec<[i32; 2]>,
    /// Node, axis (`D`, `D + 1`: main and anti diagonal), forward, backward.
    pub(crate) links: Vec<(usize, usize, i32, i32)>,
}

impl<const D: usize> GridCase<D> {
    /// A case with open axes and no capacities.
    pub(crate) fn blank(shape: [usize; D]) -> Self {
        let n = shape.iter().product();
        let (masked, pins, terminals) = (vec![false; n], vec![None; n], vec![[0; 2]; n]);
        Self { shape, periodic: [false; D], diagonals: false, masked, pins, terminals, links: Vec::new() }
    }

    /// A random case of about `nodes` nodes at most, with capacities up to about `max`.
    pub(crate) fn random(draw: &mut Draw, nodes: usize, max: usize) -> Self {
        let mut shape = [1; D];
        for _ in 0..64 {
            let axis = draw.below(D);
            if shape.iter().product::<usize>() / shape[axis] * (shape[axis] + 1) <= nodes {
                shape[axis] += 1;
            }
        }
        let periodic = std::array::from_fn(|_| draw.chance(25));
        let diagonals = D == 2 && draw.chance(30);
        let n = shape.iter().product();
        let (masks, pins, terms) = (draw.below(3) * 10, draw.below(3) * 10, draw.below(4) * 33);
        let (dense, equal) = (40 + draw.below(61), draw.chance(15));
        let cap = |draw: &mut Draw| if equal { 3 } else { draw.below(max + 1) as i32 };
        let masked = (0..n).map(|_| draw.chance(masks)).collect();
        let side = |draw: &mut Draw| if draw.chance(50) { Side::Source } else { Side::Sink };
        let pins = (0..n).map(|_| draw.chance(pins).then(|| side(draw))).collect();
        let terminal = |draw: &mut Draw| if draw.chance(terms) { 2 * cap(draw) } else { 0 };
        let terminals = (0..n).map(|_| [terminal(draw), terminal(draw)]).collect();
        let mut case = Self { shape, periodic, diagonals, masked, pins, terminals, links: Vec::new() };
        for v in 0..n {
            for along in 0..if diagonals { D + 2 } else { D } {
                if case.neighbour(v, along).is_some() && draw.chance(dense) {
                    case.links.push((v, along, cap(draw), if draw.chance(30) { 0 } else { cap(draw) }));
                }
            }
        }
        case
    }

    pub(crate) fn len(&self) -> usize {
        self.terminals.len()
    }

    /// The other end of a link, worked out from positions.
    pub(crate) fn neighbour(&self, v: usize, along: usize) -> Option<usize> {
        let mut step = [0_i64; D];
        match along {
            a if a < D => step[a] = 1,
            a => (step[0], step[D - 1]) = (1, if a == D { 1 } else { -1 }),
        }
        let mut rest = v;
        let mut at = [0; D];
        for a in (0..D).rev() {
            (at[a], rest) = (rest % self.shape[a], rest / self.shape[a]);
        }
        let mut w = 0;
        for a in 0..D {
            let (to, side) = (at[a] as i64 + step[a], self.shape[a] as i64);
            if !(0..side).contains(&to) && !self.periodic[a] {
                return None;
            }
            w = w * self.shape[a] + to.rem_euclid(side) as usize;
        }
        Some(w)
    }

    /// Gives the case to a graph, which must be fresh or cleared.
    pub(crate) fn fill(
        &self,
        graph: &mut GridGraph<D>,
        link_diagonal: fn(&mut GridGraph<D>, usize, Diagonal, i32, i32),
    ) {
        for v in (0..self.len()).filter(|&v| self.masked[v]) {
            graph.mask(v).unwrap();
        }
        for v in 0..self.len() {
            graph.terminal(v, self.terminals[v][0], self.terminals[v][1]).unwrap();
            if let Some(side) = self.pins[v] {
                graph.pin(v, side).unwrap();
            }
        }
        for &(v, along, forward, backward) in &self.links {
            match along {
                a if a < D => graph.link(v, a, forward, backward).unwrap(),
                a if a == D => link_diagonal(graph, v, Diagonal::Main, forward, backward),
                _ => link_diagonal(graph, v, Diagonal::Anti, forward, backward),
            }
        }
    }

    /// The problem as plain lists, masked nodes out.
    pub(crate) fn problem(&self) -> Problem {
        let present = |v: usize| !self.masked[v];
        let terminals = (0..self.len()).map(|v| if present(v) { self.terminals[v].map(i64::from) } else { [0; 2] });
        let pins = (0..self.len()).map(|v| self.pins[v].filter(|_| present(v))).collect();
        let mut arcs = Vec::new();
        for &(v, along, forward, backward) in &self.links {
            let w = self.neighbour(v, along).unwrap();
            if present(v) && present(w) && v != w {
                arcs.extend([(v, w, i64::from(forward)), (w, v, i64::from(backward))]);
            }
        }
        Problem { terminals: terminals.collect(), pins, arcs }
    }
}

/// Links along a diagonal.
pub(crate) fn diagonal(graph: &mut GridGraph<2>, v: usize, diagonal: Diagonal, forward: i32, backward: i32) {
    graph.link_diagonal(v, diagonal, forward, backward).unwrap();
}

/// For cases without diagonals.
pub(crate) fn no_diagonal<const D: usize>(_: &mut GridGraph<D>, _: usize, _: Diagonal, _: i32, _: i32) {
    unreachable!("the case has no diagonals");
}

/// A min-cut problem as plain lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct Problem {
    /// From the source, to the sink.
    pub(crate) terminals: Vec<[i64; 2]>,
    pub(crate) pins: Vec<Option<Side>>,
    /// Tail, head, capacity.
    pub(crate) arcs: Vec<(usize, usize, i64)>,
}

impl Problem {
    /// A random problem with arcs between any nodes, parallel arcs and loops included.
    pub(crate) fn random(draw: &mut Draw, nodes: usize, max: usize) -> Self {
        let (pins, terms) = (draw.below(3) * 10, draw.below(4) * 33);
        let side = |draw: &mut Draw| if draw.chance(50) { Side::Source } else { Side::Sink };
        let cap = |draw: &mut Draw| draw.below(max + 1) as i64;
        let pins = (0..nodes).map(|_| draw.chance(pins).then(|| side(draw))).collect();
        let terminal = |draw: &mut Draw| if draw.chance(terms) { cap(draw) } else { 0 };
        let terminals = (0..nodes).map(|_| [terminal(draw), terminal(draw)]).collect();
        let count = nodes * (1 + draw.below(4));
        let arcs = (0..count).map(|_| (draw.below(nodes), draw.below(nodes), cap(draw))).collect();
        Self { terminals, pins, arcs }
    }

    /// The problem as a graph of any form.
    pub(crate) fn graph(&self) -> Graph {
        let mut graph = Graph::new(self.terminals.len()).unwrap();
        for (v, (t, &pin)) in self.terminals.iter().zip(&self.pins).enumerate() {
            graph.terminal(v, t[0], t[1]).unwrap();
            if let Some(side) = pin {
                graph.pin(v, side).unwrap();
            }
        }
        for &(v, w, c) in &self.arcs {
            graph.arc(v, w, c, 0).unwrap();
        }
        graph
    }

    /// Capacity of a cut by definition, pins not counted.
    pub(crate) fn capacity(&self, in_source: &[bool]) -> i64 {
        let terminals: i64 = self.terminals.iter().zip(in_source).map(|(t, &s)| t[usize::from(s)]).sum();
        let cut = self.arcs.iter().filter(|&&(v, w, _)| in_source[v] && !in_source[w]);
        terminals + cut.map(|&(_, _, c)| c).sum::<i64>()
    }

    /// Least capacity over all 2^n cuts that respect the pins, and the least of these sets: the intersection.
    pub(crate) fn by_enumeration(&self) -> (i64, Vec<bool>) {
        let n = self.terminals.len();
        let pinned = |side| (0..n).filter(|&v| self.pins[v] == Some(side)).fold(0_u32, |bits, v| bits | 1 << v);
        let (inside, outside) = (pinned(Side::Source), pinned(Side::Sink));
        // The other ends of a node's arcs, with the capacity out to them and in from them.
        let mut around = vec![Vec::new(); n];
        for &(v, w, c) in self.arcs.iter().filter(|a| a.0 != a.1) {
            around[v].push((w, c, 0));
            around[w].push((v, 0, c));
        }
        let mut best = (i64::MAX, 0);
        let (mut set, mut capacity) = (0_u32, self.terminals.iter().map(|t| t[0]).sum::<i64>());
        // In the order of a Gray code: one node changes sides at a time.
        for step in 1..=1_u32 << n {
            if set & inside == inside && set & outside == 0 {
                if capacity < best.0 {
                    best = (capacity, set);
                } else if capacity == best.0 {
                    best.1 &= set;
                }
            }
            let v = step.trailing_zeros() as usize;
            if v < n {
                let terminals = self.terminals[v][1] - self.terminals[v][0];
                let arcs = around[v].iter().map(|&(w, out, into)| if set >> w & 1 == 1 { -into } else { out });
                let entering = terminals + arcs.sum::<i64>();
                capacity += if set >> v & 1 == 1 { -entering } else { entering };
                set ^= 1 << v;
            }
        }
        (best.0, (0..n).map(|v| best.1 >> v & 1 == 1).collect())
    }

    /// Asserts that a cut of this problem is least and has the smallest source side.
    #[track_caller]
    pub(crate) fn check(&self, cut: &MinCut, expected: &(i64, Vec<bool>)) {
        assert_eq!(cut.flow, self.capacity(cut.source_side()), "flow and capacity of the returned side: {self:?}");
        assert_eq!(cut.flow, expected.0, "flow: {self:?}");
        assert_eq!(cut.source_side(), expected.1, "side: {self:?}");
    }
}
