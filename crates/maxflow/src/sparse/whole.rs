//! A flow out of what engines leave behind.
//!
//! Engines stop as soon as the cut is known. Then nodes hold excess that cannot reach the sink, or lack what they have
//! sent: a pseudoflow. What is wanted on an arc is a flow, and excess can always go back where it came from: every flow
//! into a node that holds some began at a terminal. It is walked back arc by arc; a walk that meets itself has found a
//! circle, whose flow helps nobody and is taken away. Every step that ends empties an arc or a terminal.

use super::Graph;
use crate::error::{MaxflowError, Result, filled};
use crate::network::Role;

impl Graph {
    /// The flow along an arc of the maximum flow, from tail to head less what flows back. What flows into a node flows
    /// out of it, but for pinned ones and what its terminals give and take; of several maximum flows it is one of them,
    /// the same in every run, but not from every engine.
    ///
    /// The first call after a solve makes a flow of what was left where the cut was found: time at worst
    /// `O(nodes arcs)`, mostly about that of reading all arcs once.
    ///
    /// ```
    /// use selvedge_maxflow::{Graph, Side};
    ///
    /// let mut graph = Graph::new(3)?;
    /// graph.pin(0, Side::Source)?;
    /// graph.pin(2, Side::Sink)?;
    /// let (wide, narrow) = (graph.arc(0, 1, 9, 0)?, graph.arc(1, 2, 4, 0)?);
    /// assert_eq!(graph.solve()?.flow, 4);
    /// assert_eq!((graph.flow(wide)?, graph.flow(narrow)?), (4, 4));
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NotSolved`] if anything was changed since; those of [`change_arc`](Self::change_arc) for arcs
    /// that are not of this graph; [`MaxflowError::OutOfMemory`].
    pub fn flow(&mut self, arc: super::ArcId) -> Result<i64> {
        if !self.current {
            return Err(MaxflowError::NotSolved);
        }
        let out = self.place_of(arc)?;
        if !self.whole {
            let mut walk = Walk::new(self)?;
            walk.return_all(self, 1);
            walk.return_all(self, -1);
            self.whole = true;
        }
        Ok(self.rows.forward[arc.number as usize] - self.rows.arcs[out].residual)
    }
}

/// What walks note.
struct Walk {
    /// By arc, what flows along it, less what flows back.
    flow: Vec<i64>,
    /// By node, how many of its arcs are empty for good: flow only becomes less.
    empty: Vec<u32>,
    /// By node, where it stands on the path, from 1.
    on_path: Vec<u32>,
    /// Arcs from the node whose excess goes back.
    path: Vec<u32>,
}

impl Walk {
    fn new(graph: &Graph) -> Result<Self> {
        let (nodes, arcs) = (graph.len(), graph.rows.arcs.len());
        let mut flow = filled(0, arcs, nodes, arcs)?;
        for (&at, &capacity) in graph.rows.place.iter().zip(&graph.rows.forward) {
            let out = graph.rows.arcs[at as usize];
            flow[at as usize] = capacity - out.residual;
            flow[out.twin as usize] = out.residual - capacity;
        }
        let path = filled(0, nodes + 1, nodes, arcs)?;
        Ok(Self { flow, empty: filled(0, nodes, nodes, arcs)?, on_path: filled(0, nodes, nodes, arcs)?, path })
    }

    /// Sends all excess back that the nodes' own terminals did not give; with a sign of -1 all that they lack.
    fn return_all(&mut self, graph: &mut Graph, sign: i64) {
        self.empty.fill(0);
        for v in 0..graph.len() {
            while graph.roles[v] == Role::Free && 0 < -room(graph, v, sign) {
                self.return_some(graph, v, sign);
            }
        }
    }

    /// One walk from a node to a terminal.
    fn return_some(&mut self, graph: &mut Graph, from: usize, sign: i64) {
        self.path.clear();
        let mut at = from;
        self.on_path[from] = 1;
        loop {
            let Some(arc) = self.next(graph, at, sign) else {
                debug_assert!(false, "node {at} holds what never flowed into it");
                break;
            };
            self.path.push(arc as u32);
            at = graph.rows.arcs[arc].head as usize;
            let ends = graph.roles[at] != Role::Free || 0 < room(graph, at, sign);
            if ends {
                let most = if graph.roles[at] == Role::Free { room(graph, at, sign) } else { i64::MAX };
                let amount = self.least(0, sign).min(most).min(-room(graph, from, sign));
                self.send(graph, 0, sign * amount);
                graph.excess[from] -= sign * amount;
                graph.excess[at] += sign * amount;
                break;
            }
            if self.on_path[at] != 0 {
                let first = self.on_path[at] as usize - 1;
                let amount = self.least(first, sign);
                self.send(graph, first, sign * amount);
                for arc in self.path.drain(first..) {
                    self.on_path[graph.rows.arcs[arc as usize].head as usize] = 0;
                }
                self.on_path[at] = first as u32 + 1;
            } else {
                self.on_path[at] = self.path.len() as u32 + 1;
            }
        }
        self.on_path[from] = 0;
        self.path.iter().for_each(|&arc| self.on_path[graph.rows.arcs[arc as usize].head as usize] = 0);
    }

    /// An arc of a node along which something came.
    fn next(&mut self, graph: &Graph, node: usize, sign: i64) -> Option<usize> {
        let (first, end) = (graph.rows.first[node] as usize, graph.rows.first[node + 1] as usize);
        let found = (first + self.empty[node] as usize..end).find(|&arc| sign * self.flow[arc] < 0);
        self.empty[node] = (found.unwrap_or(end) - first) as u32;
        found
    }

    /// The least that came along the path from a step on.
    fn least(&self, first: usize, sign: i64) -> i64 {
        self.path[first..].iter().map(|&arc| -sign * self.flow[arc as usize]).min().unwrap_or(0)
    }

    fn send(&mut self, graph: &mut Graph, first: usize, amount: i64) {
        for &arc in &self.path[first..] {
            let (arc, twin) = (arc as usize, graph.rows.arcs[arc as usize].twin as usize);
            self.flow[arc] += amount;
            self.flow[twin] -= amount;
            graph.rows.arcs[arc].residual -= amount;
            graph.rows.arcs[twin].residual += amount;
        }
    }
}

/// What a node's terminal has given and would take back; below 0, what the node holds that it did not give.
fn room(graph: &Graph, node: usize, sign: i64) -> i64 {
    let [from_source, to_sink] = graph.terminals[node];
    (sign * (from_source - to_sink)).max(0) - sign * graph.excess[node]
}
