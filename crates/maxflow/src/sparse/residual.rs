//! A sparse graph as the engines see it: arcs sorted by tail.

use std::ops::Range;

use crate::error::{MaxflowError, Result, filled};
use crate::network::{ArcNotes, Network, Role};

/// Half of an edge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arc {
    pub(super) residual: i64,
    pub(super) head: u32,
    /// The other half, which leads back.
    pub(super) twin: u32,
}

/// An edge as it is sorted in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) ends: [u32; 2],
    /// Both ways.
    pub(super) residuals: [i64; 2],
    /// The capacity forward; that backward is the rest of the two residuals' sum, which no flow changes.
    pub(super) forward: i64,
}

impl Edge {
    /// Capacities forward and backward.
    pub(super) fn capacities(&self) -> [i64; 2] {
        [self.forward, self.residuals[0] + self.residuals[1] - self.forward]
    }
}

/// Arcs by tail (compressed sparse rows): those of `v` are `arcs[first[v]..first[v + 1]]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    pub(super) first: Vec<u32>,
    pub(super) arcs: Vec<Arc>,
    /// By edge: where its forward arc went.
    pub(super) place: Vec<u32>,
    /// By edge: its capacity forward.
    pub(super) forward: Vec<i64>,
}

impl Rows {
    /// Sorts edges in, keeping their order around each node. Time `O(nodes + edges)`.
    pub(super) fn of(nodes: usize, edges: &[Edge]) -> Result<Self> {
        let no_memory = |_| MaxflowError::OutOfMemory { nodes, links: edges.len() };
        let mut first = filled(0_u32, nodes + 2, nodes, edges.len())?;
        for edge in edges {
            edge.ends.iter().for_each(|&v| first[v as usize + 2] += 1);
        }
        for v in 2..first.len() {
            first[v] += first[v - 1];
        }
        let mut arcs = filled(Arc::default(), 2 * edges.len(), nodes, edges.len())?;
        let (mut place, mut forward) = (Vec::new(), Vec::new());
        place.try_reserve_exact(edges.len()).map_err(no_memory)?;
        forward.try_reserve_exact(edges.len()).map_err(no_memory)?;
        // `first[v + 1]` is where the next arc of `v` goes, and ends up as the end of its row.
        for edge in edges {
            let at = edge.ends.map(|v| {
                let next = &mut first[v as usize + 1];
                *next += 1;
                *next - 1
            });
            for (half, other) in [(0, 1), (1, 0)] {
                arcs[at[half] as usize] =
                    Arc { residual: edge.residuals[half], head: edge.ends[other], twin: at[other] };
            }
            place.push(at[0]);
            forward.push(edge.forward);
        }
        first.pop();
        Ok(Self { first, arcs, place, forward })
    }

    /// The edges again, in the order in which they were given.
    pub(super) fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        self.place.iter().zip(&self.forward).map(|(&at, &capacity)| {
            let forward = self.arcs[at as usize];
            let backward = self.arcs[forward.twin as usize];
            let (ends, residuals) = ([backward.head, forward.head], [forward.residual, backward.residual]);
            Edge { ends, residuals, forward: capacity }
        })
    }
}

/// How many arcs of a node each of engine P's searches has passed over.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cursors {
    down: u32,
    child: u32,
}

impl ArcNotes<u32> for Cursors {
    #[inline]
    fn rewind_down(&mut self) {
        self.down = 0;
    }

    #[inline]
    fn rewind_children(&mut self) {
        self.child = 0;
    }
}

/// Rows and excess together.
pub(super) struct SparseNet<'a> {
    pub(super) rows: &'a mut Rows,
    pub(super) excess: &'a mut [i64],
    pub(super) roles: &'a mut [Role],
}

impl Network for SparseNet<'_> {
    type Cap = i64;
    type Arc = u32;
    type Arcs = Range<u32>;
    type Notes = Cursors;
    const ROOT: u32 = u32::MAX;
    const ORPHAN: u32 = u32::MAX - 1;

    fn slots(&self) -> usize {
        self.excess.len()
    }

    fn nodes(&self) -> Range<usize> {
        0..self.excess.len()
    }

    #[inline]
    fn arcs(&self, v: usize) -> Range<u32> {
        self.rows.first[v]..self.rows.first[v + 1]
    }

    #[inline]
    fn head(&self, _: usize, a: u32) -> usize {
        self.rows.arcs[a as usize].head as usize
    }

    #[inline]
    fn twin(&self, a: u32) -> u32 {
        self.rows.arcs[a as usize].twin
    }

    #[inline]
    fn residual(&self, _: usize, a: u32) -> i64 {
        self.rows.arcs[a as usize].residual
    }

    #[inline]
    fn push(&mut self, _: usize, a: u32, _: usize, x: i64) {
        let arc = &mut self.rows.arcs[a as usize];
        arc.residual -= x;
        let twin = arc.twin as usize;
        self.rows.arcs[twin].residual += x;
    }

    #[inline]
    fn excess(&self, v: usize) -> i64 {
        self.excess[v]
    }

    #[inline]
    fn add_excess(&mut self, v: usize, x: i64) {
        self.excess[v] += x;
    }

    #[inline]
    fn role(&self, v: usize) -> Role {
        self.roles[v]
    }

    #[inline]
    fn set_role(&mut self, v: usize, role: Role) {
        self.roles[v] = role;
    }

    #[inline]
    fn find_down(&self, v: usize, notes: &mut Cursors, wanted: impl Fn(&Self, u32, usize) -> bool) -> Option<u32> {
        let Range { start, end } = self.arcs(v);
        let found = (start + notes.down..end).find(|&a| wanted(self, a, self.head(v, a)));
        notes.down = found.unwrap_or(end) - start;
        found
    }

    #[inline]
    fn find_child(
        &self,
        v: usize,
        notes: &mut Cursors,
        parents: &[u32],
        wanted: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let Range { start, end } = self.arcs(v);
        let is_child = |&(a, w): &(u32, usize)| wanted(w) && parents[w] == self.twin(a);
        let found = (start + notes.child..end).map(|a| (a, self.head(v, a))).find(is_child);
        notes.child = found.map_or(end, |(a, _)| a + 1) - start;
        found.map(|(_, w)| w)
    }
}
