//! Names of arcs.

use super::Graph;
use crate::error::{MaxflowError, Result};

/// Names an arc of a [`Graph`] and of its clones: the number of arcs added before it. From [`Graph::arc`], or, where
/// someone else added the arcs, from [`Graph::arc_id`] and [`Graph::arc_ids`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArcId {
    pub(super) number: u32,
    /// In debug builds, whose arc it is.
    #[cfg(debug_assertions)]
    graph: u64,
}

/// The number of a new graph.
#[cfg(debug_assertions)]
pub(super) fn new_graph() -> u64 {
    static GRAPHS: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    GRAPHS.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

impl Graph {
    /// The arc before which `number` were added, `None` if there is none: of a graph from petgraph that of the edge
    /// with this index (of a stable one without its gaps), of a DIMACS file that of its arc line, from 0.
    pub fn arc_id(&self, number: usize) -> Option<ArcId> {
        (number < self.arc_count()).then(|| self.numbered(number))
    }

    /// All arcs, in the order in which they were added.
    ///
    /// ```
    /// use selvedge_maxflow::{Graph, dimacs::Problem};
    ///
    /// let problem = Problem::read("p max 3 2\nn 1 s\nn 3 t\na 1 2 5\na 2 3 4\n".as_bytes())?;
    /// let mut graph = problem.graph()?;
    /// graph.solve()?;
    /// let flows = graph.arc_ids().map(|arc| graph.flow(arc)).collect::<Result<Vec<_>, _>>()?;
    /// assert_eq!(flows, [4, 4]);
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    pub fn arc_ids(&self) -> impl ExactSizeIterator<Item = ArcId> + use<> {
        #[cfg(debug_assertions)]
        let graph = self.number;
        (0..self.arc_count()).map(move |number| ArcId {
            number: number as u32,
            #[cfg(debug_assertions)]
            graph,
        })
    }

    pub(super) fn numbered(&self, number: usize) -> ArcId {
        ArcId {
            number: number as u32,
            #[cfg(debug_assertions)]
            graph: self.number,
        }
    }

    /// Where the forward half of an arc stands, once it is sorted in.
    pub(super) fn place_of(&self, arc: ArcId) -> Result<usize> {
        let (id, arcs) = (arc.number as usize, self.arc_count());
        #[cfg(debug_assertions)]
        if arc.graph != self.number {
            return Err(MaxflowError::ForeignArc { arc: id });
        }
        self.rows.place.get(id).map(|&at| at as usize).ok_or(MaxflowError::NoSuchArc { arc: id, arcs })
    }
}
