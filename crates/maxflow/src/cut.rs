//! The answer: a cut.

/// The two sides of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// With the source.
    Source,
    /// With the sink.
    Sink,
}

/// A minimum cut.
///
/// Of all minimum cuts it is the one with the *smallest source side*: the nodes that the source still reaches when the
/// flow is maximum. That set is unique, so every engine returns the same nodes, whatever order it worked in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MinCut {
    /// The value of the maximum flow, equal to the capacity of the cut. Negative only on a grid, of whose terminals
    /// more was taken back than they had been given
    /// ([`GridGraph::change_terminal`](crate::GridGraph::change_terminal)).
    pub flow: i64,
    pub(crate) in_source: Vec<bool>,
}

impl MinCut {
    /// The side of a node. Masked nodes count as [`Side::Sink`].
    ///
    /// # Panics
    ///
    /// If `node` is not a node of the graph.
    #[inline]
    pub fn side(&self, node: usize) -> Side {
        if self.in_source[node] { Side::Source } else { Side::Sink }
    }

    /// One `bool` a node, in node order: whether it is on the source's side.
    #[inline]
    pub fn source_side(&self) -> &[bool] {
        &self.in_source
    }

    /// One `bool` a node, in node order: whether it is on the sink's side. Collected, it is the mask of label 1.
    ///
    /// ```
    /// use selvedge_maxflow::GridGraph;
    ///
    /// let mut graph = GridGraph::new([3], [false])?;
    /// graph.terminals(&[[9, 0], [0, 0], [0, 9]])?;
    /// assert_eq!(graph.solve()?.sink_side().collect::<Vec<_>>(), [false, true, true]);
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    pub fn sink_side(&self) -> impl ExactSizeIterator<Item = bool> + '_ {
        self.in_source.iter().map(|source| !source)
    }

    /// Number of nodes on the source's side.
    pub fn source_len(&self) -> usize {
        self.in_source.iter().filter(|&&s| s).count()
    }
}
