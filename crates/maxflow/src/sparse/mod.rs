//! Graphs of any form.

mod arcs;
mod residual;
mod whole;

use crate::cut::{MinCut, Side};
use crate::engine::{self, Engine, Scratch, closure};
use crate::error::{MaxflowError, Result, filled, push};
use crate::forms::solves;
use crate::network::Role;
pub use arcs::ArcId;
#[cfg(debug_assertions)]
use arcs::new_graph;
use residual::{Cursors, Edge, Rows, SparseNet};

/// A min-cut problem on a graph of any form, its current flow, and the memory to solve it.
///
/// Nodes and arcs come in any order. Arcs are sorted by tail, all of them, at the first solve after arcs were added: to
/// solve again and again, add them once and change their capacities. Capacities are `i64`; those of a graph may sum to
/// [`MAX_TOTAL`](Self::MAX_TOTAL), so that no flow can overflow.
///
/// ```
/// use selvedge_maxflow::{Graph, Side};
///
/// let mut graph = Graph::new(4)?;
/// graph.terminal(0, 7, 0)?; // 7 from the source
/// graph.pin(3, Side::Sink)?;
/// for (tail, head, capacity) in [(0, 1, 3), (0, 2, 5), (1, 3, 9), (2, 3, 2)] {
///     graph.arc(tail, head, capacity, 0)?;
/// }
/// let cut = graph.solve()?;
/// assert_eq!(cut.flow, 5);
/// assert_eq!(cut.source_side(), [true, false, true, false]);
/// assert_eq!(graph.cut_arcs(&cut).collect::<Vec<_>>(), [(0, 1, 3), (2, 3, 2)]);
/// # Ok::<(), selvedge_maxflow::MaxflowError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Graph {
    excess: Vec<i64>,
    /// Capacity from the source and to the sink, by node.
    terminals: Vec<[i64; 2]>,
    roles: Vec<Role>,
    rows: Rows,
    /// Arcs that are not in `rows` yet.
    fresh: Vec<Edge>,
    source_total: i64,
    /// Sum of all capacities of arcs and net capacities of terminals.
    total: i64,
    /// Solved before: the flow is nearly maximum.
    solved: bool,
    /// Solved, and not changed since.
    current: bool,
    /// Excess stands where terminals gave it: what the arcs carry is a flow.
    whole: bool,
    engine: Engine,
    scratch: Scratch<u32, Cursors>,
    stack: Vec<u32>,
    #[cfg(debug_assertions)]
    number: u64,
}

impl Graph {
    /// Largest sum of all capacities of a graph, net where terminals are concerned: `2^61`.
    pub const MAX_TOTAL: i64 = 1 << 61;
    /// Largest number of nodes, and of arcs: `2^31 - 8`.
    pub const MAX_NODES: usize = (1 << 31) - 8;

    /// A graph without arcs.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::TooLarge`] beyond [`MAX_NODES`](Self::MAX_NODES), [`MaxflowError::OutOfMemory`].
    pub fn new(nodes: usize) -> Result<Self> {
        if nodes > Self::MAX_NODES {
            return Err(MaxflowError::TooLarge { nodes, arcs: 0, max: Self::MAX_NODES });
        }
        let rows = Rows::of(nodes, &[])?;
        let (excess, terminals) = (filled(0, nodes, nodes, 0)?, filled([0; 2], nodes, nodes, 0)?);
        let roles = filled(Role::Free, nodes, nodes, 0)?;
        let (fresh, stack, scratch) = (Vec::new(), Vec::new(), Scratch::default());
        Ok(Self {
            excess,
            terminals,
            roles,
            rows,
            fresh,
            source_total: 0,
            total: 0,
            solved: false,
            current: false,
            whole: false,
            engine: Engine::Auto,
            scratch,
            stack,
            #[cfg(debug_assertions)]
            number: new_graph(),
        })
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.excess.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.excess.is_empty()
    }

    /// Number of arcs added.
    pub fn arc_count(&self) -> usize {
        self.rows.place.len() + self.fresh.len()
    }

    /// Takes all capacities and pins away and keeps nodes, arcs and memory: the next problem of the same form is set
    /// with [`change_arc`](Self::change_arc) and [`terminal`](Self::terminal).
    pub fn clear(&mut self) {
        self.excess.fill(0);
        self.terminals.fill([0; 2]);
        self.roles.fill(Role::Free);
        self.rows.arcs.iter_mut().for_each(|arc| arc.residual = 0);
        self.rows.forward.fill(0);
        self.fresh.iter_mut().for_each(|edge| (edge.residuals, edge.forward) = ([0, 0], 0));
        (self.source_total, self.total, self.solved, self.current) = (0, 0, false, false);
    }

    /// Chooses how later solves work. The answer does not depend on it.
    pub fn set_engine(&mut self, engine: Engine) {
        self.engine = engine;
    }

    /// Gives a node capacity from the source and to the sink, on top of what it has.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::NegativeCapacity`], [`MaxflowError::CapacityTooLarge`].
    pub fn terminal(&mut self, node: usize, from_source: i64, to_sink: i64) -> Result<()> {
        not_negative(node, from_source.min(to_sink))?;
        self.change_terminal(node, from_source, to_sink)
    }

    /// Changes a node's terminal capacities by the given amounts, which may be negative; also after a solve. See
    /// [`GridGraph::change_terminal`](crate::GridGraph::change_terminal).
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::CapacityTooLarge`]; [`MaxflowError::NegativeCapacity`] if more
    /// is taken back than the node has. Its capacities are then unchanged.
    pub fn change_terminal(&mut self, node: usize, from_source: i64, to_sink: i64) -> Result<()> {
        self.inside(node)?;
        let old = self.terminals[node];
        let too_large = |value| MaxflowError::CapacityTooLarge { node, value, max: Self::MAX_TOTAL };
        let sum = |a: i64, b: i64| a.checked_add(b).ok_or_else(|| too_large(b));
        let new = [sum(old[0], from_source)?, sum(old[1], to_sink)?];
        not_negative(node, new[0].min(new[1]))?;
        let source_total = sum(self.source_total, from_source)?;
        let [net, before] = [new, old].map(|[from, to]| from - to);
        self.count(node, net.abs() - before.abs())?;
        self.excess[node] += net - before;
        self.terminals[node] = new;
        self.source_total = source_total;
        self.current = false;
        Ok(())
    }

    /// Adds an arc from `tail` to `head` with a capacity, and one back with another (0 for a one-way arc). An arc of a
    /// node with itself has no effect.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::NegativeCapacity`], [`MaxflowError::CapacityTooLarge`],
    /// [`MaxflowError::TooLarge`], [`MaxflowError::OutOfMemory`].
    pub fn arc(&mut self, tail: usize, head: usize, capacity: i64, back: i64) -> Result<ArcId> {
        self.inside(tail)?;
        self.inside(head)?;
        not_negative(tail, capacity.min(back))?;
        let id = self.arc_count();
        if id >= Self::MAX_NODES {
            return Err(MaxflowError::TooLarge { nodes: self.len(), arcs: id + 1, max: Self::MAX_NODES });
        }
        let residuals = if tail == head { [0, 0] } else { [capacity, back] };
        let sum = residuals[0].checked_add(residuals[1]).unwrap_or(i64::MAX);
        self.count(tail, sum)?;
        if !push(&mut self.fresh, Edge { ends: [tail as u32, head as u32], residuals, forward: residuals[0] }) {
            self.total -= sum;
            return Err(MaxflowError::OutOfMemory { nodes: self.len(), links: id + 1 });
        }
        self.current = false;
        Ok(self.numbered(id))
    }

    /// Changes the two capacities of an arc by the given amounts, which may be negative; also after a solve, whose flow
    /// is kept as far as it fits. See [`GridGraph::change_link`](crate::GridGraph::change_link).
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NoSuchArc`]; in debug builds, which know every graph's arcs from all others',
    /// [`MaxflowError::ForeignArc`]; [`MaxflowError::NegativeCapacity`] if more is taken back than the arc has,
    /// [`MaxflowError::CapacityTooLarge`], [`MaxflowError::OutOfMemory`]; the arc is then unchanged.
    pub fn change_arc(&mut self, arc: ArcId, forward: i64, backward: i64) -> Result<()> {
        self.sort_in()?;
        let (id, out) = (arc.number as usize, self.place_of(arc)?);
        let back = self.rows.arcs[out].twin as usize;
        let (v, w) = (self.rows.arcs[back].head as usize, self.rows.arcs[out].head as usize);
        if v == w {
            return Ok(());
        }
        let residual = [self.rows.arcs[out].residual, self.rows.arcs[back].residual];
        let old = [self.rows.forward[id], residual[0] + residual[1] - self.rows.forward[id]];
        let new = [old[0].saturating_add(forward), old[1].saturating_add(backward)];
        not_negative(v, new[0].min(new[1]))?;
        self.count(v, new[0].saturating_add(new[1]) - (old[0] + old[1]))?;
        let residual = [residual[0] + forward, residual[1] + backward];
        // Flow beyond the new capacity goes back to where it came from.
        let returned = (-residual[0]).max(0) - (-residual[1]).max(0);
        self.rows.arcs[out].residual = residual[0] + returned;
        self.rows.arcs[back].residual = residual[1] - returned;
        self.rows.forward[id] = new[0];
        self.excess[v] += returned;
        self.excess[w] -= returned;
        self.current = false;
        Ok(())
    }

    /// Holds a node on one side, whatever the capacities say. May be set, moved and taken off between solves.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`].
    pub fn pin(&mut self, node: usize, side: Side) -> Result<()> {
        self.inside(node)?;
        self.roles[node] = match side {
            Side::Source => Role::PinnedSource,
            Side::Sink => Role::PinnedSink,
        };
        self.current = false;
        Ok(())
    }

    /// Lets a pinned node go.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`].
    pub fn unpin(&mut self, node: usize) -> Result<()> {
        self.inside(node)?;
        self.roles[node] = Role::Free;
        self.current = false;
        Ok(())
    }

    solves! {
        /// The minimum cut with the smallest source side.
        ///
        /// A later solve, after changes, starts from this one's flow. Time is at worst `O(nodes^2 arcs)`, unless
        /// [`Engine::Trees`] is named.
    }

    fn find(&mut self, cut: &mut MinCut, cancelled: &dyn Fn() -> bool) -> Result<()> {
        self.sort_in()?;
        (self.current, self.whole) = (false, false);
        let mut net = SparseNet { rows: &mut self.rows, excess: &mut self.excess, roles: &mut self.roles };
        engine::maximize(&mut net, self.engine, self.solved, &mut self.scratch, cancelled)?;
        closure::read_off(&net, self.source_total, cut, &mut self.stack)?;
        (self.solved, self.current) = (true, true);
        Ok(())
    }

    /// Capacity of the cut between the nodes marked `true` and the others; pins do not count. Exact before and after a
    /// solve. Time `O(nodes + arcs)`.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::LabellingSize`].
    pub fn capacity_of(&self, in_source: &[bool]) -> Result<i64> {
        if in_source.len() != self.len() {
            return Err(MaxflowError::LabellingSize { given: in_source.len(), len: self.len() });
        }
        let inside = in_source.iter().zip(&self.excess).filter(|&(&s, _)| s);
        let terminals = self.source_total - inside.map(|(_, &e)| e).sum::<i64>();
        let halves = self.edges().flat_map(|e| [(e.ends, e.residuals[0]), ([e.ends[1], e.ends[0]], e.residuals[1])]);
        let cut = halves.filter(|([v, w], _)| in_source[*v as usize] && !in_source[*w as usize]);
        Ok(terminals + cut.map(|(_, c)| c).sum::<i64>())
    }

    /// [`capacity_of`](Self::capacity_of) with every node on the source's side.
    pub(crate) fn capacity_of_all_source(&self) -> i64 {
        self.source_total - self.excess.iter().sum::<i64>()
    }

    /// The arcs that a cut of this graph severs, as (tail, head, capacity), in the order in which they were added: from
    /// the source's side to the sink's, those with capacity. With the terminals severed they make up the flow.
    ///
    /// # Panics
    ///
    /// If the cut is of a smaller graph.
    pub fn cut_arcs<'a>(&'a self, cut: &'a MinCut) -> impl Iterator<Item = (usize, usize, i64)> + 'a {
        let halves = self.edges().flat_map(|e| {
            let ([v, w], [forward, backward]) = (e.ends.map(|v| v as usize), e.capacities());
            [(v, w, forward), (w, v, backward)]
        });
        halves.filter(|&(v, w, capacity)| capacity > 0 && cut.in_source[v] && !cut.in_source[w])
    }

    fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        self.rows.edges().chain(self.fresh.iter().copied())
    }

    /// Sorts new arcs in among the others.
    fn sort_in(&mut self) -> Result<()> {
        if self.fresh.is_empty() {
            return Ok(());
        }
        if self.rows.place.is_empty() {
            self.rows = Rows::default();
            self.rows = Rows::of(self.len(), &self.fresh)?;
        } else {
            let (count, mut all) = (self.arc_count(), Vec::new());
            let no_memory = |_| MaxflowError::OutOfMemory { nodes: self.len(), links: count };
            all.try_reserve_exact(count).map_err(no_memory)?;
            all.extend(self.edges());
            self.rows = Rows::of(self.len(), &all)?;
        }
        self.fresh = Vec::new();
        Ok(())
    }

    fn inside(&self, node: usize) -> Result<()> {
        let len = self.len();
        if node < len { Ok(()) } else { Err(MaxflowError::NodeOutOfRange { node, len }) }
    }

    /// Counts a change of capacity against the headroom.
    fn count(&mut self, node: usize, change: i64) -> Result<()> {
        let (value, max) = (self.total.saturating_add(change), Self::MAX_TOTAL);
        if value > max {
            return Err(MaxflowError::CapacityTooLarge { node, value, max });
        }
        self.total = value;
        Ok(())
    }
}

fn not_negative(node: usize, value: i64) -> Result<()> {
    if value < 0 { Err(MaxflowError::NegativeCapacity { node, value }) } else { Ok(()) }
}
