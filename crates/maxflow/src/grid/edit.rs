//! Giving a grid its capacities, before a solve and after.

use super::residual::role;
use super::{Diagonal, GridGraph};
use crate::error::{MaxflowError, Result, filled};
use crate::network::Role;

impl<const D: usize> GridGraph<D> {
    /// Gives a node capacity from the source and to the sink, on top of what it has.
    ///
    /// A cut that puts the node on the sink's side pays `from_source`, on the source's side `to_sink`.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::NegativeCapacity`], [`MaxflowError::CapacityTooLarge`].
    #[inline]
    pub fn terminal(&mut self, node: usize, from_source: i32, to_sink: i32) -> Result<()> {
        if (from_source | to_sink) < 0 {
            return Err(negative(node, from_source.min(to_sink)));
        }
        self.change_terminal(node, from_source, to_sink)
    }

    /// Changes a node's terminal capacities by the given amounts, which may be negative; also after a solve, whose
    /// flow is kept.
    ///
    /// Only the difference of the two capacities is stored: taking back more than was given goes unnoticed and counts
    /// as a capacity to the other terminal (with the value of the cut shifted by the same amount). Both would be 4
    /// bytes a node more, of 43, to be written for each; [`Graph`](crate::Graph), of which a node takes more, refuses
    /// it. Of a node with links somewhat more than [`MAX_TERMINAL`](Self::MAX_TERMINAL) is accepted: what the links
    /// could take away.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::CapacityTooLarge`].
    #[inline]
    pub fn change_terminal(&mut self, node: usize, from_source: i32, to_sink: i32) -> Result<()> {
        let slot = self.slot(node)?;
        self.touched = true;
        if self.is_masked(slot) {
            return Ok(());
        }
        let excess = i64::from(self.excess[slot]) + i64::from(from_source) - i64::from(to_sink);
        self.check_headroom(slot, excess, [0, 0])?;
        self.excess[slot] = excess as i32;
        self.source_total += i64::from(from_source);
        Ok(())
    }

    /// Whether no flow can overflow a node with this excess, whose arcs have this much more residual capacity, out and
    /// in together, than is stored.
    ///
    /// Excess less the residual capacity out, and excess plus that in, are not changed by flow: they are the net
    /// terminal capacity less, or plus, the capacity of the arcs. As long as they stay within `MAX_TERMINAL` below and
    /// above, excess does within `i32`, since the capacity of all arcs is at most `8 MAX_LINK`.
    #[inline]
    fn check_headroom(&self, slot: usize, excess: i64, [out, into]: [i64; 2]) -> Result<()> {
        let max = i64::from(Self::MAX_TERMINAL);
        if excess.abs() <= max {
            return Ok(());
        }
        let (mut least, mut most) = (excess - out, excess + into);
        for d in 0..self.lattice.directions {
            let (out, back) = self.arc_pair(d, slot, self.head(slot, d));
            least -= i64::from(self.caps[out]);
            most += i64::from(self.caps[back]);
        }
        if least <= max && -max <= most {
            return Ok(());
        }
        let value = if least > max { least } else { most };
        Err(MaxflowError::CapacityTooLarge { node: slot - self.lattice.margin, value, max })
    }

    /// Gives the link between a node and the next along `axis` capacity: `forward` from `node` to the next, `backward`
    /// from the next to `node`, on top of what it has.
    ///
    /// Links of masked nodes are dropped, as are those of a node with itself (a periodic axis of length 1).
    /// A periodic axis of length 2 has two links between its nodes, one from each.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::NodeOutOfRange`], [`MaxflowError::NoNeighbour`] at the end of an open axis,
    /// [`MaxflowError::NegativeCapacity`], [`MaxflowError::CapacityTooLarge`].
    #[inline]
    pub fn link(&mut self, node: usize, axis: usize, forward: i32, backward: i32) -> Result<()> {
        let ends = self.ends(node, axis)?;
        self.add(node, 2 * axis, ends, forward, backward)
    }

    /// Lets the sink's side never be followed by the source's along an open axis: adds arcs back along it that no
    /// minimum cut severs.
    ///
    /// Where a cut severed the arc from `t + 1` back to `t`, all nodes of the line up to `t` could go to the source's
    /// side, or all after it to the sink's: that severs no other such arc, and costs at most what leaves the former, or
    /// enters the latter, across other axes and from terminals. One more than the lesser of both is therefore enough.
    /// (One more than the arcs of `t` or `t + 1` alone is not: where several nodes of a line lean on their neighbours,
    /// moving one of them only moves the fault.)
    pub(crate) fn order(&mut self, axis: usize) -> Result<()> {
        if axis >= D || self.lattice.periodic[axis] {
            return Err(MaxflowError::NoNeighbour { node: 0, along: format!("axis {axis}, which does not end") });
        }
        let side = self.lattice.shape[axis];
        let stride: usize = self.lattice.shape[axis + 1..].iter().product();
        let mut lines = filled([0_i64; 2], stride, self.lattice.len, self.lattice.len * D)?;
        for first in (0..self.lattice.len).step_by(stride * side) {
            lines.fill([0; 2]);
            for v in first..first + stride * side {
                lines[v % stride][1] += self.cost_to_move(v, axis)[1];
            }
            for v in first..first + stride * (side - 1) {
                let [to_source, to_sink] = self.cost_to_move(v, axis);
                let [before, after] = &mut lines[v % stride];
                *before += to_source;
                *after -= to_sink;
                let capacity = i32::try_from(1 + (*before).min(*after)).unwrap_or(i32::MAX);
                self.link(v, axis, 0, capacity)?;
            }
        }
        Ok(())
    }

    /// What it costs at most, across all axes but one, to move a node to the source's and to the sink's side; more than
    /// any sum of capacities where it is pinned to the other.
    fn cost_to_move(&self, node: usize, but: usize) -> [i64; 2] {
        const NEVER: i64 = 1 << 48;
        let slot = node + self.lattice.margin;
        match role(self.flags[slot]) {
            Role::PinnedSource => return [0, NEVER],
            Role::PinnedSink => return [NEVER, 0],
            Role::Masked => return [0, 0],
            Role::Free => {}
        }
        let excess = i64::from(self.excess[slot]);
        let mut costs = [(-excess).max(0), excess.max(0)];
        for d in (0..self.lattice.directions).filter(|d| d / 2 != but) {
            let (out, back) = self.arc_pair(d, slot, self.head(slot, d));
            costs[0] += i64::from(self.caps[out]);
            costs[1] += i64::from(self.caps[back]);
        }
        costs
    }

    /// Gives all links along an axis capacity, as [`link`](Self::link) does one: forward and backward by node, in node
    /// order. Those of the last nodes of an open axis, which have no next, are 0.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Count`] unless there are two capacities a node, and those of [`link`](Self::link); the links of
    /// nodes before the one that is refused then have theirs.
    pub fn links(&mut self, axis: usize, capacities: &[[i32; 2]]) -> Result<()> {
        self.check_count(capacities.len())?;
        let given = capacities.iter().enumerate().filter(|(_, both)| **both != [0, 0]);
        given.into_iter().try_for_each(|(node, &[forward, backward])| self.link(node, axis, forward, backward))
    }

    /// Gives all nodes capacity from the source and to the sink, in node order, as [`terminal`](Self::terminal) does
    /// one.
    ///
    /// ```
    /// use selvedge_maxflow::GridGraph;
    ///
    /// let mut graph = GridGraph::new([3], [false])?;
    /// graph.terminals(&[[9, 0], [0, 0], [0, 9]])?;
    /// graph.links(0, &[[4, 4], [3, 3], [0, 0]])?;
    /// assert_eq!(graph.solve()?.source_side(), [true, true, false]);
    /// # Ok::<(), selvedge_maxflow::MaxflowError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Count`] unless there are two capacities a node, and those of [`terminal`](Self::terminal); nodes
    /// before the one that is refused then have theirs.
    pub fn terminals(&mut self, capacities: &[[i32; 2]]) -> Result<()> {
        self.check_count(capacities.len())?;
        let all = capacities.iter().enumerate();
        all.into_iter().try_for_each(|(node, &[from_source, to_sink])| self.terminal(node, from_source, to_sink))
    }

    pub(crate) fn check_count(&self, given: usize) -> Result<()> {
        let len = self.len();
        if given == len { Ok(()) } else { Err(MaxflowError::Count { given, len }) }
    }

    /// Changes the capacities of a link by the given amounts, which may be negative; also after a solve.
    ///
    /// The solve's flow is kept as far as it still fits; what no longer fits becomes excess at one end and lack at the
    /// other, and the next solve mends that alone (Kohli and Torr, PAMI 2007).
    ///
    /// # Errors
    ///
    /// As [`link`](Self::link); [`MaxflowError::NegativeCapacity`] if more is taken back than the link has (noticed
    /// as far as the flow on it allows; the link is then unchanged).
    pub fn change_link(&mut self, node: usize, axis: usize, forward: i32, backward: i32) -> Result<()> {
        let ends = self.ends(node, axis)?;
        self.change(node, 2 * axis, ends, forward, backward)
    }

    #[inline]
    fn add(&mut self, node: usize, d: usize, (v, w): (usize, usize), forward: i32, backward: i32) -> Result<()> {
        if (forward | backward) < 0 {
            return Err(negative(node, forward.min(backward)));
        }
        self.touched = true;
        if v == w || self.is_masked(v) || self.is_masked(w) {
            return Ok(());
        }
        let (out, back) = self.arc_pair(d, v, w);
        let sum = i64::from(self.caps[out]) + i64::from(self.caps[back]) + i64::from(forward) + i64::from(backward);
        if sum > i64::from(Self::MAX_LINK) {
            return Err(MaxflowError::CapacityTooLarge { node, value: sum, max: Self::MAX_LINK.into() });
        }
        self.caps[out] += forward;
        self.caps[back] += backward;
        Ok(())
    }

    /// Where the residual capacities of a link stand.
    #[inline]
    fn arc_pair(&self, d: usize, v: usize, w: usize) -> (usize, usize) {
        let k = self.lattice.directions;
        (v * k + d, w * k + (d ^ 1))
    }

    fn change(&mut self, node: usize, d: usize, (v, w): (usize, usize), forward: i32, backward: i32) -> Result<()> {
        self.touched = true;
        if v == w || self.is_masked(v) || self.is_masked(w) {
            return Ok(());
        }
        let (out, back) = self.arc_pair(d, v, w);
        let mut residual =
            [i64::from(self.caps[out]) + i64::from(forward), i64::from(self.caps[back]) + i64::from(backward)];
        let sum = residual[0] + residual[1];
        if sum < 0 {
            return Err(MaxflowError::NegativeCapacity { node, value: sum });
        }
        if sum > i64::from(Self::MAX_LINK) {
            return Err(MaxflowError::CapacityTooLarge { node, value: sum, max: Self::MAX_LINK.into() });
        }
        // Flow beyond the new capacity goes back to where it came from.
        let returned = (-residual[0]).max(0) - (-residual[1]).max(0);
        residual = [residual[0] + returned, residual[1] - returned];
        let more = [residual[0] - i64::from(self.caps[out]), residual[1] - i64::from(self.caps[back])];
        let excess = [i64::from(self.excess[v]) + returned, i64::from(self.excess[w]) - returned];
        self.check_headroom(v, excess[0], more)?;
        self.check_headroom(w, excess[1], [more[1], more[0]])?;
        (self.caps[out], self.caps[back]) = (residual[0] as i32, residual[1] as i32);
        (self.excess[v], self.excess[w]) = (excess[0] as i32, excess[1] as i32);
        Ok(())
    }
}

impl GridGraph<2> {
    /// [`link`](Self::link) along a diagonal of a grid made [`with_diagonals`](Self::with_diagonals).
    ///
    /// # Errors
    ///
    /// As [`link`](Self::link).
    #[inline]
    pub fn link_diagonal(&mut self, node: usize, diagonal: Diagonal, forward: i32, backward: i32) -> Result<()> {
        let (direction, ends) = self.diagonal(node, diagonal)?;
        self.add(node, direction, ends, forward, backward)
    }

    /// [`change_link`](Self::change_link) along a diagonal.
    ///
    /// # Errors
    ///
    /// As [`change_link`](Self::change_link).
    pub fn change_diagonal(&mut self, node: usize, diagonal: Diagonal, forward: i32, backward: i32) -> Result<()> {
        let (direction, ends) = self.diagonal(node, diagonal)?;
        self.change(node, direction, ends, forward, backward)
    }

    #[inline]
    pub(crate) fn diagonal_neighbour(&self, node: usize, diagonal: Diagonal) -> Result<usize> {
        self.diagonal(node, diagonal).map(|(_, (_, head))| head - self.lattice.margin)
    }

    #[inline]
    fn diagonal(&self, node: usize, diagonal: Diagonal) -> Result<(usize, (usize, usize))> {
        let direction = match diagonal {
            Diagonal::Main => 4,
            Diagonal::Anti => 6,
        };
        if direction >= self.lattice.directions {
            return Err(MaxflowError::NoNeighbour { node, along: format!("diagonal {diagonal:?}") });
        }
        Ok((direction, self.ends_of_direction(node, direction)?))
    }
}

fn negative(node: usize, value: i32) -> MaxflowError {
    MaxflowError::NegativeCapacity { node, value: value.into() }
}
