//! Graphs whose nodes are the points of a grid.

mod edit;
mod residual;
mod solve;
mod terms;

use crate::cut::Side;
use crate::engine::{Engine, Scratch};
use crate::error::{MaxflowError, Result, filled};
use crate::lattice::{EDGE_PATTERNS, Lattice};
use crate::network::Role;
pub(crate) use residual::GridNet;
use residual::{Children, EDGE_MASK, role};

/// A diagonal of a two-dimensional grid, seen from the node it starts at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diagonal {
    /// To the node one further along both axes: row + 1, column + 1.
    Main,
    /// To the node one further along axis 0 and one back along axis 1: row + 1, column - 1.
    Anti,
}

/// A min-cut problem on a grid with `D` axes, its current flow, and the memory to solve it.
///
/// Shapes, axes and positions are ordered slowest first: `[rows, columns]`, `[frames, rows, columns]`. Nodes are
/// numbered row-major, so a pixel's index is its node. Each node is linked with its neighbours along the axes (4 in
/// 2-D, 6 in 3-D; 8 with [`GridGraph::with_diagonals`]), each link with one capacity a direction, and with the two
/// terminals. Links not given have no capacity.
///
/// *Capacities add up*: a second [`link`](Self::link) or [`terminal`](Self::terminal) at the same place comes on top
/// of the first. That stays so after a solve, which keeps the flow it found: see [`change_link`](Self::change_link).
///
/// *Headroom*: the two capacities of a link sum to at most [`MAX_LINK`](Self::MAX_LINK), a node's net terminal capacity
/// stays within ±[`MAX_TERMINAL`](Self::MAX_TERMINAL); then no flow can overflow, whatever the engine. What must not be
/// cut is a [`pin`](Self::pin), not a large number.
///
/// ```
/// use selvedge_maxflow::{GridGraph, Side};
///
/// // Two rows of three: the left column is the source's, the right column the sink's; cut where it is cheapest.
/// let mut graph = GridGraph::new([2, 3], [false, false])?;
/// for row in 0..2 {
///     graph.pin(graph.node([row, 0]), Side::Source)?;
///     graph.pin(graph.node([row, 2]), Side::Sink)?;
///     graph.link(graph.node([row, 0]), 1, 5, 5)?; // to the right: 5 forward, 5 backward
///     graph.link(graph.node([row, 1]), 1, 3, 3)?;
/// }
/// graph.link(graph.node([0, 1]), 0, 9, 9)?; // down
/// let cut = graph.solve()?;
/// assert_eq!(cut.flow, 6);
/// assert_eq!(cut.source_side(), [true, true, false, true, true, false]);
/// # Ok::<(), selvedge_maxflow::MaxflowError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GridGraph<const D: usize> {
    lattice: Lattice<D>,
    /// Residual capacities by slot and direction.
    caps: Vec<i32>,
    /// Excess by slot.
    excess: Vec<i32>,
    /// Edge bits and role by slot.
    flags: Vec<u8>,
    /// Steps by edge pattern and direction.
    offsets: Vec<i32>,
    /// Sum of all capacities out of the source.
    source_total: i64,
    /// Anything but masks was set since the graph was new or cleared.
    touched: bool,
    /// Solved since the graph was new or cleared: the flow is nearly maximum.
    solved: bool,
    engine: Engine,
    scratch: Scratch<u8, Children>,
    stack: Vec<u32>,
    distance: Vec<i64>,
}

impl<const D: usize> GridGraph<D> {
    /// Largest sum of the two capacities of one link: `2^27`.
    pub const MAX_LINK: i32 = 1 << 27;
    /// Largest net terminal capacity of a node, `from_source - to_sink`, either way: `2^30 - 1`.
    pub const MAX_TERMINAL: i32 = (1 << 30) - 1;

    /// A grid linked along its axes, without any capacity. One to three axes: the line that asks for a fourth does not
    /// compile.
    ///
    /// ```compile_fail,E0080
    /// let graph = selvedge_maxflow::GridGraph::new([2, 2, 2, 2], [false; 4]);
    /// ```
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Shape`] unless no side is 0 and nodes fit 32-bit numbers; [`MaxflowError::OutOfMemory`].
    pub fn new(shape: [usize; D], periodic: [bool; D]) -> Result<Self> {
        const { crate::lattice::supported(D) };
        Self::build(Lattice::new(shape, periodic, false)?)
    }

    fn build(lattice: Lattice<D>) -> Result<Self> {
        let (slots, len, directions) = (lattice.slots(), lattice.len, lattice.directions);
        let links = len.saturating_mul(directions / 2);
        let of = |per_slot: usize| filled(0, slots.saturating_mul(per_slot), len, links);
        let mut flags = filled(0, slots, len, links)?;
        lattice.write_edges(&mut flags[lattice.margin..][..len]);
        let offsets = lattice.offset_table();
        debug_assert_eq!(offsets.len(), EDGE_PATTERNS * directions);
        Ok(Self {
            caps: of(directions)?,
            excess: of(1)?,
            flags,
            offsets,
            source_total: 0,
            touched: false,
            solved: false,
            engine: Engine::Auto,
            scratch: Scratch::default(),
            stack: Vec::new(),
            distance: Vec::new(),
            lattice,
        })
    }

    /// How many bytes a graph of this shape takes at most while it is solved, and solved again: 43 a node in 2-D, 51 in
    /// 3-D. With diagonals it takes 16 a node more. `u64::MAX` for shapes that are refused.
    pub fn estimate(shape: [usize; D]) -> u64 {
        // Capacities, excess and flags; engine T's notes and queue; marks; the cut and a stack.
        let per_slot = 8 * D + 5 + 12 + 4 + 1 + 5;
        Lattice::new(shape, [false; D], false).map_or(u64::MAX, |lattice| lattice.slots() as u64 * per_slot as u64)
    }

    /// Takes all capacities, pins and masks away and keeps the memory: for the next problem of the same shape.
    pub fn clear(&mut self) {
        self.caps.fill(0);
        self.excess.fill(0);
        self.flags.iter_mut().for_each(|f| *f &= EDGE_MASK);
        self.source_total = 0;
        self.touched = false;
        self.solved = false;
    }

    /// Chooses how later solves work. The answer does not depend on it.
    pub fn set_engine(&mut self, engine: Engine) {
        self.engine = engine;
    }

    /// Lengths of the axes, slowest first.
    pub fn shape(&self) -> [usize; D] {
        self.lattice.shape
    }

    /// Which axes are periodic.
    pub fn periodic(&self) -> [bool; D] {
        self.lattice.periodic
    }

    /// Number of nodes, masked ones included.
    pub fn len(&self) -> usize {
        self.lattice.len
    }

    /// Always false: a grid has at least one node.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The node at a position: its row-major index.
    ///
    /// # Panics
    ///
    /// With both in numbers, if the position is outside the grid.
    #[inline]
    pub fn node(&self, at: [usize; D]) -> usize {
        match self.lattice.node(at) {
            Some(node) => node,
            None => panic!("position {at:?} is outside a grid of {:?}", self.lattice.shape),
        }
    }

    /// The position of a node: the inverse of [`node`](Self::node).
    ///
    /// # Panics
    ///
    /// With both in numbers, if the grid has no such node.
    #[inline]
    pub fn position(&self, node: usize) -> [usize; D] {
        assert!(node < self.len(), "node {node} is outside a grid of {:?}", self.lattice.shape);
        let (mut at, mut rest) = ([0; D], node);
        for axis in (0..D).rev() {
            (at[axis], rest) = (rest % self.lattice.shape[axis], rest / self.lattice.shape[axis]);
        }
        at
    }

    /// The next node along an axis; around on a periodic axis, `None` at the end of an open one (and for a node or an
    /// axis that does not exist).
    #[inline]
    pub fn next(&self, node: usize, axis: usize) -> Option<usize> {
        self.neighbour(node, axis).ok()
    }

    #[inline]
    pub(crate) fn neighbour(&self, node: usize, axis: usize) -> Result<usize> {
        self.ends(node, axis).map(|(_, head)| head - self.lattice.margin)
    }

    /// Whether a node exists and is masked.
    #[inline]
    pub(crate) fn masked(&self, node: usize) -> bool {
        self.slot(node).is_ok_and(|slot| self.is_masked(slot))
    }

    /// Takes a node out of the grid. Links and terminals given to it later are dropped, and it counts as
    /// [`Side::Sink`]. Masks belong to the shape of the problem and come first.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`]; [`MaxflowError::MaskTooLate`] once anything else was set.
    pub fn mask(&mut self, node: usize) -> Result<()> {
        let slot = self.slot(node)?;
        if self.touched {
            return Err(MaxflowError::MaskTooLate { node });
        }
        self.set_role(slot, Role::Masked);
        Ok(())
    }

    /// Holds a node on one side, whatever the capacities say. (A terminal larger than all links of its node does so
    /// too, and is solved as fast.) Pins may be set, moved and taken off between solves.
    /// Masked nodes stay masked.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`].
    #[inline]
    pub fn pin(&mut self, node: usize, side: Side) -> Result<()> {
        let role = match side {
            Side::Source => Role::PinnedSource,
            Side::Sink => Role::PinnedSink,
        };
        self.change_role(node, role)
    }

    /// Lets a pinned node go.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`].
    pub fn unpin(&mut self, node: usize) -> Result<()> {
        self.change_role(node, Role::Free)
    }

    #[inline]
    fn change_role(&mut self, node: usize, new: Role) -> Result<()> {
        let slot = self.slot(node)?;
        self.touched = true;
        if role(self.flags[slot]) != Role::Masked {
            self.set_role(slot, new);
        }
        Ok(())
    }

    #[inline]
    fn set_role(&mut self, slot: usize, role: Role) {
        residual::set_role(&mut self.flags[slot], role);
    }

    #[inline]
    fn is_masked(&self, slot: usize) -> bool {
        role(self.flags[slot]) == Role::Masked
    }

    #[inline]
    fn slot(&self, node: usize) -> Result<usize> {
        if node < self.lattice.len {
            Ok(node + self.lattice.margin)
        } else {
            Err(MaxflowError::NodeOutOfRange { node, len: self.lattice.len })
        }
    }

    /// The slots that a link joins.
    #[inline]
    pub(crate) fn ends(&self, node: usize, axis: usize) -> Result<(usize, usize)> {
        if axis >= D {
            return Err(MaxflowError::NoNeighbour { node, along: format!("axis {axis}") });
        }
        self.ends_of_direction(node, 2 * axis)
    }

    #[inline]
    fn ends_of_direction(&self, node: usize, direction: usize) -> Result<(usize, usize)> {
        let slot = self.slot(node)?;
        let edges = self.flags[slot] & EDGE_MASK;
        if edges & self.lattice.walls[direction] != 0 {
            return Err(MaxflowError::NoNeighbour { node, along: direction_name(direction, D) });
        }
        let offset = self.offsets[edges as usize * self.lattice.directions + direction];
        Ok((slot, slot.wrapping_add_signed(offset as isize)))
    }
}

impl GridGraph<2> {
    /// A grid whose nodes are also linked along both diagonals: 8 neighbours.
    ///
    /// # Errors
    ///
    /// As [`GridGraph::new`].
    pub fn with_diagonals(shape: [usize; 2], periodic: [bool; 2]) -> Result<Self> {
        Self::build(Lattice::new(shape, periodic, true)?)
    }
}

/// A direction in words.
fn direction_name(direction: usize, axes: usize) -> String {
    if direction < 2 * axes {
        format!("axis {}", direction / 2)
    } else {
        format!("diagonal {:?}", if direction < 6 { Diagonal::Main } else { Diagonal::Anti })
    }
}
