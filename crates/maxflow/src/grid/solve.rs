//! Solving a grid, and reading the answer.

use super::GridGraph;
use super::residual::GridNet;
use crate::cut::MinCut;
use crate::engine::{self, Engine, Outcome, closure, strip};
use crate::error::{MaxflowError, Result};
use crate::forms::solves;

impl<const D: usize> GridGraph<D> {
    solves! {
        /// The minimum cut with the smallest source side.
        ///
        /// A later solve, after changes of capacities, terminals or pins, starts from this one's flow. Time is at worst
        /// `O(nodes^3)`, unless [`Engine::Trees`] is named; on overlays it was measured to grow as `nodes^1.1` to
        /// `nodes^1.3`.
    }

    fn find(&mut self, cut: &mut MinCut, cancelled: &dyn Fn() -> bool) -> Result<()> {
        self.touched = true;
        let wrap = self.lattice.periodic.contains(&true);
        match (self.lattice.directions, wrap) {
            (2, false) => self.solve_as::<2, false>(cut, cancelled),
            (2, true) => self.solve_as::<2, true>(cut, cancelled),
            (4, false) => match self.solve_strip(cancelled) {
                Some(Outcome::Cancelled) => Err(MaxflowError::Cancelled),
                Some(_) => self.read_off::<4, false>(cut),
                None => self.solve_as::<4, false>(cut, cancelled),
            },
            (4, true) => self.solve_as::<4, true>(cut, cancelled),
            (6, false) => self.solve_as::<6, false>(cut, cancelled),
            (6, true) => self.solve_as::<6, true>(cut, cancelled),
            (_, false) => self.solve_as::<8, false>(cut, cancelled),
            (_, true) => self.solve_as::<8, true>(cut, cancelled),
        }
    }

    /// Sum of all capacities out of the source.
    #[cfg(test)]
    pub(crate) fn source_total(&self) -> i64 {
        self.source_total
    }

    /// The grid as the engines see it.
    pub(crate) fn net<const K: usize, const WRAP: bool>(&mut self) -> GridNet<'_, K, WRAP> {
        let first = self.lattice.margin;
        GridNet {
            nodes: first..first + self.lattice.len,
            caps: self.caps.as_chunks_mut().0,
            excess: &mut self.excess,
            flags: &mut self.flags,
            offsets: self.offsets.as_chunks().0,
        }
    }

    /// What engine D makes of the grid, if it is a plain strip.
    fn solve_strip(&mut self, cancelled: &dyn Fn() -> bool) -> Option<Outcome> {
        if !matches!(self.engine, Engine::Auto | Engine::ShortestPath) {
            return None;
        }
        let shape = [self.lattice.shape[0], self.lattice.shape[D - 1]];
        let mut distance = std::mem::take(&mut self.distance);
        let done = strip::solve(&mut self.net(), shape, &mut distance, cancelled);
        self.distance = distance;
        done
    }

    fn solve_as<const K: usize, const WRAP: bool>(
        &mut self,
        cut: &mut MinCut,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<()> {
        let (engine, solved, mut scratch) = (self.engine, self.solved, std::mem::take(&mut self.scratch));
        let done = engine::maximize(&mut self.net::<K, WRAP>(), engine, solved, &mut scratch, cancelled);
        self.scratch = scratch;
        done?;
        self.read_off::<K, WRAP>(cut)
    }

    /// The cut of a maximum flow.
    fn read_off<const K: usize, const WRAP: bool>(&mut self, cut: &mut MinCut) -> Result<()> {
        let (source_total, mut stack) = (self.source_total, std::mem::take(&mut self.stack));
        let read = closure::read_off(&self.net::<K, WRAP>(), source_total, cut, &mut stack);
        self.stack = stack;
        self.solved = true;
        read
    }

    /// Capacity of the cut between the nodes marked `true` and the others: what [`solve`](Self::solve) makes least.
    /// Pins are constraints, not capacities, and do not count.
    ///
    /// Exact before and after a solve: flow does not change the capacity of any cut. Time `O(nodes)`.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::LabellingSize`].
    pub fn capacity_of(&self, in_source: &[bool]) -> Result<i64> {
        if in_source.len() != self.len() {
            return Err(MaxflowError::LabellingSize { given: in_source.len(), len: self.len() });
        }
        let (k, first) = (self.lattice.directions, self.lattice.margin);
        let mut capacity = self.source_total;
        for (node, _) in in_source.iter().enumerate().filter(|&(_, &s)| s) {
            let slot = node + first;
            capacity -= i64::from(self.excess[slot]);
            for d in 0..k {
                let residual = self.caps[slot * k + d];
                if residual > 0 && !in_source[self.head(slot, d) - first] {
                    capacity += i64::from(residual);
                }
            }
        }
        Ok(capacity)
    }

    /// [`capacity_of`](Self::capacity_of) with every node on the source's side.
    pub(crate) fn capacity_of_all_source(&self) -> i64 {
        self.source_total - self.excess.iter().map(|&e| i64::from(e)).sum::<i64>()
    }

    /// The links between the two sides of a cut of this graph, as pairs (on the source's side, on the sink's side), in
    /// node order. What it costs to sever one is the capacity it was given from the first to the second, which may be
    /// 0; links that were given no capacity either way are not listed.
    ///
    /// # Panics
    ///
    /// If the cut is of a smaller graph.
    pub fn cut_links<'a>(&'a self, cut: &'a MinCut) -> impl Iterator<Item = (usize, usize)> + 'a {
        let (k, first) = (self.lattice.directions, self.lattice.margin);
        let inside = cut.in_source.iter().enumerate().take(self.len()).filter(|&(_, &s)| s);
        inside.flat_map(move |(node, _)| {
            let slot = node + first;
            (0..k).filter_map(move |d| {
                let head = self.head(slot, d);
                let given = self.caps[slot * k + d] > 0 || self.caps[head * k + (d ^ 1)] > 0;
                (given && !cut.in_source[head - first]).then(|| (node, head - first))
            })
        })
    }

    #[inline]
    pub(super) fn head(&self, slot: usize, direction: usize) -> usize {
        let edges = (self.flags[slot] & super::EDGE_MASK) as usize;
        slot.wrapping_add_signed(self.offsets[edges * self.lattice.directions + direction] as isize)
    }
}
