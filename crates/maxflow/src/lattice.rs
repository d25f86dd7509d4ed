//! Where the neighbours of a grid node are, without a list of them.
//!
//! Nodes are numbered row-major. Node `v` lives in slot `margin + v`; the margins before and after are empty slots, so
//! that the neighbour of *any* node in *any* direction is a slot that exists. A step off an open side lands in the
//! margin or on a node of the next row: harmless, because no capacity is ever stored there. So no row is padded, and
//! node numbers need no translation. Along a periodic axis the last node's step leads back to the first; the `2 D`
//! edge bits of a node choose its row in a small table of steps.

use crate::error::{MaxflowError, Result};

/// Largest number of axes.
const MAX_AXES: usize = 3;
/// Refuses other numbers of axes. Where it stands in a function that users call, the compiler names the line that
/// called it.
pub(crate) const fn supported(axes: usize) {
    assert!(1 <= axes && axes <= MAX_AXES, "grids have one to three axes");
}

/// Number of edge patterns: two bits an axis.
pub(crate) const EDGE_PATTERNS: usize = 1 << (2 * MAX_AXES);
/// Slots are numbered by `u32`, and the distance of two of them is an `i32`.
const MAX_SLOTS: usize = i32::MAX as usize - 16;

/// Shape, topology and numbering of a grid.
///
/// Directions come in pairs: `2 a` steps forward along axis `a`, `2 a + 1` backward. With diagonals (two axes), 4 steps
/// `(+1, +1)`, 5 back, 6 steps `(+1, -1)`, 7 back. The opposite of direction `d` is therefore `d ^ 1`.
#[derive(Clone, Debug)]
pub(crate) struct Lattice<const D: usize> {
    pub(crate) shape: [usize; D],
    pub(crate) periodic: [bool; D],
    strides: [usize; D],
    /// Number of nodes.
    pub(crate) len: usize,
    /// Empty slots on either end.
    pub(crate) margin: usize,
    /// Directions a node: `2 D`, or 8.
    pub(crate) directions: usize,
    /// By direction: the edge bits with which there is no neighbour.
    pub(crate) walls: [u8; 8],
}

/// The edge bit that a step along an axis runs into.
fn edge_bit(axis: usize, step: i8) -> u8 {
    if step > 0 { 1 << (2 * axis) } else { 2 << (2 * axis) }
}

impl<const D: usize> Lattice<D> {
    pub(crate) fn new(shape: [usize; D], periodic: [bool; D], diagonals: bool) -> Result<Self> {
        let refused = || MaxflowError::Shape { shape: shape.to_vec(), max: MAX_SLOTS };
        if D == 0 || D > MAX_AXES || shape.contains(&0) {
            return Err(refused());
        }
        let mut strides = [1; D];
        for a in (0..D - 1).rev() {
            strides[a] = shape[a + 1].checked_mul(strides[a + 1]).ok_or_else(refused)?;
        }
        let len = shape[0].checked_mul(strides[0]).ok_or_else(refused)?;
        // The longest step; along an axis of length 1 there is none.
        let longest = (0..D).find(|&a| shape[a] > 1).map_or(1, |a| strides[a]);
        let margin = longest + usize::from(diagonals);
        if len > MAX_SLOTS || len + 2 * margin > MAX_SLOTS {
            return Err(refused());
        }
        let directions = if diagonals { 8 } else { 2 * D };
        let mut lattice = Self { shape, periodic, strides, len, margin, directions, walls: [0; 8] };
        for d in 0..directions {
            lattice.walls[d] = lattice.walls_of(d);
        }
        Ok(lattice)
    }

    /// Number of slots: nodes and both margins.
    pub(crate) fn slots(&self) -> usize {
        self.len + 2 * self.margin
    }

    /// The node at a position, row-major. `None` outside.
    #[inline]
    pub(crate) fn node(&self, at: [usize; D]) -> Option<usize> {
        let inside = (0..D).all(|a| at[a] < self.shape[a]);
        inside.then(|| (0..D).map(|a| at[a] * self.strides[a]).sum())
    }

    /// Edge bits of a node: bit `2 a` if it is the last along axis `a`, bit `2 a + 1` if it is the first.
    fn edges(&self, node: usize) -> u8 {
        let mut bits = 0;
        for a in 0..D {
            let at = node / self.strides[a] % self.shape[a];
            bits |= u8::from(at + 1 == self.shape[a]) << (2 * a) | u8::from(at == 0) << (2 * a + 1);
        }
        bits
    }

    /// Writes the edge bits of every node, in node order: found once, since divisions are slow.
    pub(crate) fn write_edges(&self, bits: &mut [u8]) {
        let row = self.shape[D - 1];
        for (r, cells) in bits.chunks_exact_mut(row).enumerate() {
            let inner = self.edges(r * row) & !(0b11 << (2 * (D - 1)));
            cells.fill(inner);
            cells[0] |= 0b10 << (2 * (D - 1));
            cells[row - 1] |= 0b01 << (2 * (D - 1));
        }
    }

    /// The axes' steps that make up a direction.
    fn steps(&self, direction: usize) -> [i8; D] {
        let sign = if direction.is_multiple_of(2) { 1 } else { -1 };
        let mut steps = [0; D];
        if direction < 2 * D {
            steps[direction / 2] = sign;
        } else {
            steps[0] = sign;
            steps[D - 1] = if direction < 6 { sign } else { -sign };
        }
        steps
    }

    /// The edge bits with which there is no neighbour in a direction: the step leaves an open axis.
    fn walls_of(&self, direction: usize) -> u8 {
        let steps = self.steps(direction);
        (0..D).filter(|&a| steps[a] != 0 && !self.periodic[a]).fold(0, |bits, a| bits | edge_bit(a, steps[a]))
    }

    /// Distance in slots from a node with these edge bits to its neighbour in a direction.
    fn offset(&self, edges: u8, direction: usize) -> i32 {
        let steps = self.steps(direction);
        let mut offset = 0;
        for (a, &step) in steps.iter().enumerate() {
            let around = step != 0 && self.periodic[a] && edges & edge_bit(a, step) != 0;
            let length = if around || self.shape[a] == 1 { 1 - self.shape[a] as i64 } else { 1 };
            offset += i64::from(step) * length * self.strides[a] as i64;
        }
        offset as i32
    }

    /// Every offset, edge pattern by edge pattern, direction by direction.
    pub(crate) fn offset_table(&self) -> Vec<i32> {
        let of = |edges| (0..self.directions).map(move |d| self.offset(edges as u8, d));
        (0..EDGE_PATTERNS).flat_map(of).collect()
    }
}
