//! Engine D: the cut of a plain strip is a shortest path.
//!
//! In a strip all of one border line is held by the source, all of the opposite line by the sink, and there are no
//! other terminals: the overlap of two patches. The graph is planar, and a cut is a path from one end of the strip to
//! the other through the *faces* between the nodes, paying for every link it crosses the capacity in the direction that
//! it severs; it is free to turn back. By planar duality (Ford and Fulkerson 1956; Hassin 1981) shortest distances of
//! faces are a maximum flow too: a link carries the difference of its two faces' distances. Distances beyond the end's
//! may be clipped to it. So this engine also ends with residual capacities, and the smallest source side is read off as
//! ever.
//!
//! Distances are found by sweeps over the rows of faces, down and up in turn, each row relaxed exactly from the
//! row before and then in itself both ways. A path with `t` turns is found after `t + 1` sweeps, and rows that did not
//! change are skipped. A strip that needs more than [`MAX_SWEEPS`] is left to another engine.

use super::{Outcome, settle};
use crate::error::refill;
use crate::grid::GridNet;
use crate::network::{Network, Role, saturate_pins};

/// After so many sweeps a strip is left to the general engines. A sweep follows a path as far as it goes down, or up,
/// so that a path of few turns is found by few; one that winds through the whole strip takes one sweep a turn.
const MAX_SWEEPS: usize = 64;
/// How many rows are swept between two looks at `cancelled`: microseconds, beside which a look costs nothing.
const CANCEL_PERIOD: usize = 64;
/// Distance of a face not reached yet; small enough to add capacities to.
const FAR: i64 = i64::MAX / 4;

/// A grid seen as a strip: the source on its left, the sink on its right, from the top down.
#[derive(Clone, Copy, Debug)]
struct Strip {
    /// Slot of the top left node.
    corner: usize,
    /// Slots from one row to the next, from one column to the next.
    steps: [isize; 2],
    rows: usize,
    columns: usize,
    /// Direction to the next row.
    down: usize,
    /// Direction to the next column, toward the sink.
    right: usize,
}

/// Makes the flow maximum if the grid is a plain strip without flow. `None` if it is not, takes too many sweeps, or
/// there is no memory for its faces: then, and when it is cancelled, nothing has changed.
///
/// Pins are saturated along with it. `distance` is scratch. Time `O(nodes)` a sweep.
pub(crate) fn solve(
    net: &mut GridNet<'_, 4, false>,
    shape: [usize; 2],
    distance: &mut Vec<i64>,
    cancelled: &dyn Fn() -> bool,
) -> Option<Outcome> {
    let strip = Strip::of(net, shape)?;
    let (outcome, length) = strip.distances(net, distance, cancelled)?;
    if outcome == Outcome::Done {
        strip.push_flow(net, distance, length);
        strip.saturate_border(net);
    }
    Some(outcome)
}

/// The side of a node that is pinned, or has a terminal that is as good.
fn side(net: &GridNet<'_, 4, false>, slot: usize) -> Option<Role> {
    match net.role(slot) {
        Role::Free => settle::plain_side(net, slot),
        role => Some(role),
    }
}

impl Strip {
    fn of(net: &GridNet<'_, 4, false>, shape: [usize; 2]) -> Option<Self> {
        let strip = [0, 1].into_iter().find_map(|across| Self::across(net, shape, across))?;
        let plain = |row, column| {
            let slot = strip.slot(row, column);
            let border = column == 0 || column == strip.columns - 1;
            border || net.excess(slot) == 0 && net.role(slot) == Role::Free
        };
        (0..strip.rows).all(|row| (0..strip.columns).all(|column| plain(row, column))).then_some(strip)
    }

    /// The strip whose columns follow an axis, if the border lines are pinned as they should be.
    fn across(net: &GridNet<'_, 4, false>, shape: [usize; 2], across: usize) -> Option<Self> {
        let (along, strides) = (1 - across, [shape[1] as isize, 1]);
        let (rows, columns) = (shape[along], shape[across]);
        let corner = net.nodes().start;
        let mut strip = Self {
            corner,
            steps: [strides[along], strides[across]],
            rows,
            columns,
            down: 2 * along,
            right: 2 * across,
        };
        if side(net, corner) == Some(Role::PinnedSink) {
            strip.corner = strip.slot(0, columns - 1);
            strip.steps[1] = -strip.steps[1];
            strip.right ^= 1;
        }
        let line = |column, role| (0..rows).all(|row| side(net, strip.slot(row, column)) == Some(role));
        (columns > 1 && line(0, Role::PinnedSource) && line(columns - 1, Role::PinnedSink)).then_some(strip)
    }

    /// Saturates what leads from the source's line and to the sink's, of pins and of heavy terminals alike.
    fn saturate_border(&self, net: &mut GridNet<'_, 4, false>) {
        for row in 0..self.rows {
            for (column, side) in [(0, Role::PinnedSource), (self.columns - 1, Role::PinnedSink)] {
                let slot = self.slot(row, column);
                if net.role(slot) == Role::Free {
                    settle::saturate(net, slot, side);
                }
            }
        }
        saturate_pins(net);
    }

    #[inline]
    fn slot(&self, row: usize, column: usize) -> usize {
        self.corner.wrapping_add_signed(row as isize * self.steps[0] + column as isize * self.steps[1])
    }

    /// Distances of the faces below each row but the last, `columns - 1` a row, from the outer face above; and the
    /// distance of the outer face below. `None` after too many sweeps, or without memory.
    fn distances(
        &self,
        net: &GridNet<'_, 4, false>,
        distance: &mut Vec<i64>,
        cancelled: &dyn Fn() -> bool,
    ) -> Option<(Outcome, i64)> {
        let faces = self.columns - 1;
        let mut length = FAR;
        // Whether a row has changed since the sweeps last carried it on, down and up.
        let mut changed = Vec::new();
        if !refill(distance, FAR, (self.rows - 1) * faces) || !refill(&mut changed, [true; 2], self.rows) {
            return None;
        }
        for _ in 0..MAX_SWEEPS / 2 {
            let before = length;
            for row in 0..self.rows {
                if row % CANCEL_PERIOD == 0 && cancelled() {
                    return Some((Outcome::Cancelled, length));
                }
                let (above, here) = distance.split_at_mut(row * faces);
                let above = above.get((row.max(1) - 1) * faces..);
                if row > 0 && !std::mem::take(&mut changed[row - 1][0]) {
                    continue;
                }
                let crossing = |j: usize| {
                    let near = if row == 0 { 0 } else { above.map_or(FAR, |a| a[j]) };
                    near + i64::from(net.residual(self.slot(row, j), self.right as u8))
                };
                if row == self.rows - 1 {
                    length = (0..faces).map(crossing).fold(length, i64::min);
                } else if self.relax(net, row, &mut here[..faces], length, crossing) {
                    changed[row] = [true; 2];
                }
            }
            for row in (0..self.rows.saturating_sub(2)).rev() {
                if !std::mem::take(&mut changed[row + 1][1]) {
                    continue;
                }
                let (here, below) = distance[row * faces..].split_at_mut(faces);
                let back = (self.right ^ 1) as u8;
                let crossing = |j: usize| below[j] + i64::from(net.residual(self.slot(row + 1, j + 1), back));
                if self.relax(net, row, here, length, crossing) {
                    changed[row] = [true; 2];
                }
            }
            let settled = changed[..self.rows - 1].iter().all(|c| !c[0]);
            if settled && before == length {
                return Some((Outcome::Done, length));
            }
        }
        None
    }

    /// Relaxes a row of faces from its neighbour row by `crossing`, then in itself to the right and to the left.
    /// Returns whether a distance below `length` fell.
    #[inline]
    fn relax(
        &self,
        net: &GridNet<'_, 4, false>,
        row: usize,
        here: &mut [i64],
        length: i64,
        crossing: impl Fn(usize) -> i64,
    ) -> bool {
        let mut fell = false;
        let mut carried = FAR;
        for (j, d) in here.iter_mut().enumerate() {
            // To the right between a node above and one below, whose arc up is severed.
            let up = if j == 0 { 0 } else { net.residual(self.slot(row + 1, j), (self.down ^ 1) as u8) };
            let new = crossing(j).min(carried + i64::from(up));
            if new < *d && new < length {
                *d = new;
                fell = true;
            }
            carried = *d;
        }
        if !fell {
            return false;
        }
        for j in (1..here.len()).rev() {
            let new = here[j] + i64::from(net.residual(self.slot(row, j), self.down as u8));
            here[j - 1] = here[j - 1].min(new);
        }
        true
    }

    /// Turns distances, clipped to `length`, into flow.
    fn push_flow(&self, net: &mut GridNet<'_, 4, false>, distance: &[i64], length: i64) {
        let faces = self.columns - 1;
        let face =
            |row: usize, j: usize| if row + 1 == self.rows { length } else { distance[row * faces + j].min(length) };
        for row in 0..self.rows {
            for j in 0..faces {
                let above = if row == 0 { 0 } else { face(row - 1, j) };
                self.push(net, [row, j], self.right, self.slot(row, j + 1), face(row, j) - above);
                if j > 0 && row + 1 < self.rows {
                    let upward = face(row, j) - face(row, j - 1);
                    self.push(net, [row, j], self.down, self.slot(row + 1, j), -upward);
                }
            }
        }
    }

    /// Pushes `x`, which may be negative, from a node to its neighbour `w` in direction `d`.
    #[inline]
    fn push(&self, net: &mut GridNet<'_, 4, false>, [row, column]: [usize; 2], d: usize, w: usize, x: i64) {
        let v = self.slot(row, column);
        // A difference of distances is at most the capacity of the link that separates the faces.
        let x = x as i32;
        net.push(v, d as u8, w, x);
        debug_assert!(net.residual(v, d as u8) >= 0 && net.residual(w, d as u8 ^ 1) >= 0, "flow within capacity");
        net.add_excess(v, -x);
        net.add_excess(w, x);
    }
}
