//! Where the seams are bad: their costs, summed over boxes. `[Kwatra03 4]`

use selvedge_core::{Domain, SeamCosts, SourceMap, try_vec};

use crate::error::Error;
use crate::window::Window;

/// Cells along a side of an error region.
pub(crate) const CELLS_A_REGION: u32 = 4;

/// Costs of seams summed over small boxes, kept up to date where patches are laid.
#[derive(Clone, Debug)]
pub(crate) struct ErrorCells<const D: usize> {
    /// Samples along a cell's side.
    side: u32,
    output: Domain<D>,
    /// The cells' own grid.
    pub(crate) cells: Domain<D>,
    sums: Vec<i64>,
    total: i64,
}

impl<const D: usize> ErrorCells<D> {
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(output: Domain<D>, side: u32) -> Result<Self, Error> {
        let side = side.max(1);
        let cells = Domain { shape: output.shape.map(|n| n.div_ceil(side)), periodic: output.periodic };
        let len = cells.checked_len().unwrap_or(usize::MAX);
        Ok(Self { side, output, cells, sums: try_vec(len, 0)?, total: 0 })
    }

    /// The cost of all seams.
    pub(crate) fn total(&self) -> i64 {
        self.total
    }

    /// Sums the seams of a changed window again. A seam belongs to the lower of its two positions.
    pub(crate) fn update(&mut self, map: &SourceMap<D>, costs: &SeamCosts<D>, window: &Window<D>) {
        for cell in self.cells_of(&window.grown(self.output, [1; D], [0; D])) {
            let sum = self.sum(map, costs, cell);
            self.total += sum - self.sums[cell];
            self.sums[cell] = sum;
        }
    }

    /// The cells that a window meets.
    pub(crate) fn cells_of(&self, window: &Window<D>) -> Vec<usize> {
        let mut found = vec![0_usize];
        for (axis, stride) in self.cells.strides().into_iter().enumerate() {
            let size = self.output.strides()[axis] as u32 * self.side;
            let mut along: Vec<usize> =
                window.places(self.output, axis).flatten().map(|p| (p / size) as usize * stride).collect();
            along.sort_unstable();
            along.dedup();
            found = found.iter().flat_map(|f| along.iter().map(move |a| f + a)).collect();
        }
        found
    }

    fn sum(&self, map: &SourceMap<D>, costs: &SeamCosts<D>, cell: usize) -> i64 {
        let first = self.cells.position(cell).map(|c| c * self.side);
        let shape: [u32; D] = std::array::from_fn(|a| self.side.min(self.output.shape[a] - first[a]));
        let ids = map.ids.plane(0);
        let strides = self.output.strides();
        let mut sum = 0;
        for local in Domain::open(shape).positions() {
            let at: [u32; D] = std::array::from_fn(|a| first[a] + local[a]);
            let place = self.output.index(at);
            if !ids[place].is_assigned() {
                continue;
            }
            for axis in 0..D {
                sum += if at[axis] + 1 < self.output.shape[axis] {
                    let next = ids[place + strides[axis]];
                    if next.is_assigned() { i64::from(costs.between(axis, ids[place], next)) } else { 0 }
                } else {
                    i64::from(costs.at(map, at, axis))
                };
            }
        }
        sum
    }

    /// The region (its first cell) with the largest sum among those that `allowed` lets pass, and that sum; the first
    /// of several. `None` if no sum is above 0.
    ///
    /// Sums over regions come from prefix sums axis by axis (a summed-area table): time `O(cells * axes)`.
    pub(crate) fn worst(&self, allowed: impl Fn(usize) -> bool) -> Option<(usize, i64)> {
        let mut sums = self.sums.clone();
        for axis in 0..D {
            self.sum_along(axis, &mut sums);
        }
        let best = sums.iter().enumerate().filter(|&(cell, &sum)| 0 < sum && allowed(cell));
        best.max_by_key(|&(cell, &sum)| (sum, std::cmp::Reverse(cell))).map(|(cell, &sum)| (cell, sum))
    }

    /// Replaces each cell by the sum of it and the next cells of a region; regions shrink at open ends.
    fn sum_along(&self, axis: usize, sums: &mut [i64]) {
        let (stride, side) = (self.cells.strides()[axis], self.cells.shape[axis] as usize);
        let reach = (CELLS_A_REGION as usize).min(side);
        let mut prefix = vec![0_i64; side + reach + 1];
        for line in (0..sums.len()).filter(|i| (i / stride).is_multiple_of(side)) {
            for i in 0..side + reach {
                let inside = i < side || self.cells.periodic[axis];
                prefix[i + 1] = prefix[i] + if inside { sums[line + i % side * stride] } else { 0 };
            }
            for i in 0..side {
                sums[line + i * stride] = prefix[i + reach] - prefix[i];
            }
        }
    }

    /// The region that starts at a cell, of a given shape; moved inside on open axes.
    pub(crate) fn region(&self, cell: usize, shape: [u32; D]) -> Window<D> {
        let first = self.cells.position(cell);
        let start = std::array::from_fn(|a| {
            let p = first[a] * self.side;
            let most = self.output.shape[a] - shape[a];
            (if self.output.periodic[a] { p } else { p.min(most) }) as i32
        });
        Window { start, shape }
    }
}
