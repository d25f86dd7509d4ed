//! Energies of binary labels: unary and pairwise terms in, a labelling of least energy out.

mod books;
mod graph;

use crate::cut::MinCut;
use crate::error::{MaxflowError, Result};
use crate::forms::minimizes;
use crate::grid::GridGraph;
use books::{Books, Lowered, Parts};
pub use graph::GraphEnergy;

/// The energy of two neighbouring labels: `e01` is paid if the first node has label 0 and the second label 1.
///
/// A term is *regular* if `e00 + e11 <= e01 + e10`: neighbours like to agree. Only regular terms can be a graph
/// (Kolmogorov and Zabih, PAMI 2004); what happens to others is told at [`BinaryEnergy::pairwise`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairwiseTerm {
    /// Both keep label 0.
    pub e00: i32,
    /// First 0, second 1.
    pub e01: i32,
    /// First 1, second 0.
    pub e10: i32,
    /// Both take label 1.
    pub e11: i32,
}

/// A labelling of least energy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Minimum {
    /// The labelling as a cut: label 0 is [`Side::Source`](crate::Side::Source), label 1 the sink's side.
    pub cut: MinCut,
    /// Energy of label 0 everywhere, of the terms as they were given. Pins do not count: where one wants label 1, what
    /// was found, `after`, may be more than this.
    pub before: i64,
    /// Energy of the labelling found, of the terms as they were given.
    pub after: i64,
    /// Number of pairwise terms that were not regular and had their `e00` lowered.
    pub truncated: usize,
}

impl Minimum {
    /// The label of each node, in node order: `true` for label 1.
    pub fn labels(&self) -> impl ExactSizeIterator<Item = bool> + '_ {
        self.cut.sink_side()
    }
}

/// An energy of one binary label a grid node, `sum of unary(p) + sum of pairwise(p, q)`, and the memory to minimise it.
///
/// To segment a picture: [`unary`](Self::unary) says what either label costs at a pixel, [`pairwise`](Self::pairwise)
/// what a change of label costs between two, less where their contrast is high; [`Minimum::labels`] is the mask. To
/// synthesise: label 0 stands for what is there (keep, old), label 1 for what is offered (alpha, new). It is the
/// source's side that has label 0, so ties go to label 1: the cut has the *smallest* source side.
///
/// ```
/// use selvedge_maxflow::{BinaryEnergy, PairwiseTerm};
///
/// // Three nodes in a row. The outer ones want label 1, the middle one label 0, and changes cost 2.
/// let mut energy = BinaryEnergy::new([3], [false])?;
/// for (node, e0, e1) in [(0, 5, 0), (1, 0, 3), (2, 5, 0)] {
///     energy.unary(node, e0, e1)?;
/// }
/// for node in 0..2 {
///     energy.pairwise(node, 0, PairwiseTerm { e00: 0, e01: 2, e10: 2, e11: 0 })?;
/// }
/// let minimum = energy.minimize()?;
/// assert_eq!((minimum.before, minimum.after), (10, 3));
/// assert_eq!(minimum.labels().collect::<Vec<_>>(), [true, true, true]);
/// # Ok::<(), selvedge_maxflow::MaxflowError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BinaryEnergy<const D: usize> {
    graph: GridGraph<D>,
    books: Books,
}

impl<const D: usize> BinaryEnergy<D> {
    /// An energy without terms over a grid, see [`GridGraph::new`].
    ///
    /// # Errors
    ///
    /// As [`GridGraph::new`].
    pub fn new(shape: [usize; D], periodic: [bool; D]) -> Result<Self> {
        const { crate::lattice::supported(D) };
        Ok(GridGraph::new(shape, periodic)?.into())
    }

    /// The graph: for masks and pins.
    pub fn graph_mut(&mut self) -> &mut GridGraph<D> {
        &mut self.graph
    }

    /// The graph: for its shape and numbering.
    pub fn graph(&self) -> &GridGraph<D> {
        &self.graph
    }

    /// Takes all terms, pins and masks away and keeps the memory.
    pub fn clear(&mut self) {
        self.graph.clear();
        self.books.clear();
    }

    /// Adds `e0` for label 0 at a node, `e1` for label 1; both may be negative.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::CapacityTooLarge`].
    #[inline]
    pub fn unary(&mut self, node: usize, e0: i32, e1: i32) -> Result<()> {
        self.unaries_from(node, &[[e0, e1]])
    }

    /// Adds an energy for label 0 and for label 1 at every node, in node order, as [`unary`](Self::unary) does at one.
    ///
    /// ```
    /// use selvedge_maxflow::{BinaryEnergy, PairwiseTerm};
    ///
    /// // Two rows of two. Neighbours in a row agree for 9, those in a column for 1.
    /// let mut energy = BinaryEnergy::new([2, 2], [false; 2])?;
    /// energy.unaries(&[[0, 6], [3, 0], [4, 0], [0, 0]])?;
    /// let [row, column] = [9, 1].map(|cost| PairwiseTerm { e00: 0, e01: cost, e10: cost, e11: 0 });
    /// let none = PairwiseTerm::default(); // at the end of an axis
    /// energy.pairwises(0, &[column, column, none, none])?;
    /// energy.pairwises(1, &[row, none, row, none])?;
    /// assert_eq!(energy.minimize()?.cut.source_side(), [true, true, false, false]);
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Count`] unless there are two energies a node, and those of [`unary`](Self::unary); nodes before
    /// the one that is refused then have theirs.
    pub fn unaries(&mut self, energies: &[[i32; 2]]) -> Result<()> {
        self.graph.check_count(energies.len())?;
        self.unaries_from(0, energies)
    }

    #[inline]
    fn unaries_from(&mut self, mut node: usize, mut energies: &[[i32; 2]]) -> Result<()> {
        loop {
            let (count, constant) = self.graph.add_unaries(node, energies);
            self.books.constant += constant;
            let [[e0, e1], rest @ ..] = &energies[count..] else { return Ok(()) };
            self.unary_wide((node + count, (*e0).into(), (*e1).into()))?;
            (node, energies) = (node + count + 1, rest);
        }
    }

    #[cold]
    fn unary_wide(&mut self, (node, e0, e1): (usize, i64, i64)) -> Result<()> {
        let least = e0.min(e1);
        let fit = |e: i64| {
            let max = GridGraph::<D>::MAX_TERMINAL.into();
            i32::try_from(e - least).map_err(|_| MaxflowError::CapacityTooLarge { node, value: e - least, max })
        };
        // A node on the sink's side has label 1 and severs its arc from the source.
        self.graph.terminal(node, fit(e1)?, fit(e0)?)?;
        if !self.graph.masked(node) {
            self.books.constant += least;
        }
        Ok(())
    }

    /// Takes back what was just added.
    #[cold]
    fn take_back(&mut self, (node, e0, e1): (usize, i64, i64)) {
        let least = e0.min(e1);
        let undone = self.graph.change_terminal(node, (least - e1) as i32, (least - e0) as i32);
        undone.expect("the terminal was within its headroom before");
        self.books.constant -= least;
    }

    /// Adds a term for a node and the next along `axis`. Terms with a masked node are dropped.
    ///
    /// By Kolmogorov and Zabih's construction it is two unary terms and an arc each way. If it is not regular its `e00`
    /// is *lowered* to `e01 + e10 - e11` and the term is counted. Only the energy of keeping label 0 at both is ever
    /// under-estimated, so a labelling that improves on 0 everywhere in the model improves at least as much in truth.
    ///
    /// # Errors
    ///
    /// As [`GridGraph::link`]; [`MaxflowError::OutOfMemory`]. The energy is then unchanged.
    #[inline]
    pub fn pairwise(&mut self, node: usize, axis: usize, term: PairwiseTerm) -> Result<()> {
        let (v, w) = self.graph.ends(node, axis)?;
        self.pairwises_from(node, axis, [v, w], &[term])
    }

    /// Adds a term for every node and the next along `axis`, in node order, as [`pairwise`](Self::pairwise) does one:
    /// faster, and mostly as fast as the terms can be read. Those of the last nodes of an open axis, which have no
    /// next, are `PairwiseTerm::default()`.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Count`] unless there is a term a node, and those of [`pairwise`](Self::pairwise); nodes before
    /// the one that is refused then have theirs.
    pub fn pairwises(&mut self, axis: usize, terms: &[PairwiseTerm]) -> Result<()> {
        self.graph.check_count(terms.len())?;
        if axis >= D {
            self.graph.ends(0, axis)?;
        }
        let mut node = 0;
        for (ends, count) in self.graph.runs(axis) {
            let some = &terms[node..node + count];
            if ends[1] != 0 {
                self.pairwises_from(node, axis, ends, some)?;
            } else if let Some(k) = some.iter().position(|&term| term != PairwiseTerm::default()) {
                self.graph.ends(node + k, axis)?;
            }
            node += count;
        }
        Ok(())
    }

    /// Adds terms of nodes in a row and their next along an axis, of which the slots of the first are known.
    #[inline]
    fn pairwises_from(
        &mut self,
        mut node: usize,
        axis: usize,
        [mut v, mut w]: [usize; 2],
        mut terms: &[PairwiseTerm],
    ) -> Result<()> {
        loop {
            let (count, constant) = self.graph.add_pairwises(2 * axis, (v, w), terms);
            self.books.constant += constant;
            let [term, rest @ ..] = &terms[count..] else { return Ok(()) };
            self.add_any_along(node + count, axis, *term)?;
            (node, v, w, terms) = (node + count + 1, v + count + 1, w + count + 1, rest);
        }
    }

    #[cold]
    fn add_any_along(&mut self, node: usize, axis: usize, term: PairwiseTerm) -> Result<()> {
        let next = self.graph.neighbour(node, axis)?;
        self.add_term(node, next, term, |graph, [out, back]| graph.link(node, axis, out, back))
    }

    /// Forbids label 1 to be followed by label 0 along an open axis: each line changes from 0 to 1 once at most. Masked
    /// nodes part lines. Comes after all terms and pins: what is added later is not reckoned with.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NoNeighbour`] for an axis that is periodic or none; [`MaxflowError::OutOfMemory`];
    /// [`MaxflowError::CapacityTooLarge`] where the terms of a line sum to more than [`GridGraph::MAX_LINK`], or pins
    /// contradict the order. The energy is of no use then.
    pub fn ordered(&mut self, axis: usize) -> Result<()> {
        self.graph.order(axis)
    }

    /// Adds all parts of a term, or none. `link` adds its arcs.
    fn add_term(
        &mut self,
        first: usize,
        second: usize,
        term: PairwiseTerm,
        link: impl FnOnce(&mut GridGraph<D>, [i32; 2]) -> Result<()>,
    ) -> Result<()> {
        if self.graph.masked(first) || self.graph.masked(second) {
            return Ok(());
        }
        let parts = Parts::of(term, first == second);
        let max = GridGraph::<D>::MAX_LINK.into();
        let [out, back] = parts
            .arcs
            .map(|value| i32::try_from(value).map_err(|_| MaxflowError::CapacityTooLarge { node: first, value, max }));
        let arcs = [out?, back?];
        if parts.lowered > 0 && !self.books.reserve() {
            return Err(MaxflowError::OutOfMemory { nodes: self.graph.len(), links: self.books.len() });
        }
        let unaries = [(first, parts.constant, parts.constant + parts.unaries[0]), (second, 0, parts.unaries[1])];
        self.unary_wide(unaries[0])?;
        if let Err(error) = self.unary_wide(unaries[1]) {
            self.take_back(unaries[0]);
            return Err(error);
        }
        if first != second
            && let Err(error) = link(&mut self.graph, arcs)
        {
            unaries.into_iter().for_each(|unary| self.take_back(unary));
            return Err(error);
        }
        let noted = self.books.note(Lowered { first, second, by: parts.lowered });
        debug_assert!(noted, "its place was reserved");
        Ok(())
    }

    minimizes!();
}

impl<const D: usize> From<GridGraph<D>> for BinaryEnergy<D> {
    /// An energy over a grid that may already have masks and pins, and capacities as a first part of the energy.
    fn from(graph: GridGraph<D>) -> Self {
        Self { graph, books: Books::default() }
    }
}

impl BinaryEnergy<2> {
    /// [`pairwise`](Self::pairwise) along a diagonal of a [`GridGraph::with_diagonals`].
    ///
    /// # Errors
    ///
    /// As [`GridGraph::link_diagonal`].
    pub fn pairwise_diagonal(&mut self, node: usize, diagonal: crate::Diagonal, term: PairwiseTerm) -> Result<()> {
        let next = self.graph.diagonal_neighbour(node, diagonal)?;
        self.add_term(node, next, term, |graph, [out, back]| graph.link_diagonal(node, diagonal, out, back))
    }
}
