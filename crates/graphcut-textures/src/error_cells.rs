//! Where the seams are bad: their costs, summed over boxes. `[Kwatra03 4]`

use selvedge_core::{Domain, SeamCosts, SourceMap, Window, try_vec};

use crate::error::Error;

/// Cells along a side of an error region. Regions begin where cells do, so that the worst is found up to an eighth of
/// its side; of twice as many cells a change would have to enter four times as many regions anew.
pub(crate) const CELLS_A_REGION: u32 = 4;

/// Costs of seams summed over small boxes, kept up to date where patches are laid.
#[derive(Clone, Debug)]
pub(crate) struct ErrorCells<const D: usize> {
    /// Samples along a cell's sides.
    sides: [u32; D],
    output: Domain<D>,
    /// The cells' own grid.
    pub(crate) cells: Domain<D>,
    sums: Vec<i64>,
    total: i64,
    /// Sums over regions, by their first cell; 0 for those left out.
    regions: Tournament,
    left_out: Vec<bool>,
    /// Regions that are hidden for now.
    hidden: Vec<usize>,
}

impl<const D: usize> ErrorCells<D> {
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(output: Domain<D>, sides: [u32; D]) -> Result<Self, Error> {
        let sides = sides.map(|n| n.max(1));
        let shape = std::array::from_fn(|a| output.shape[a].div_ceil(sides[a]));
        let cells = Domain { shape, periodic: output.periodic };
        let len = cells.checked_len().unwrap_or(usize::MAX);
        let (regions, left_out) = (Tournament::new(len)?, try_vec(len, false)?);
        Ok(Self { sides, output, cells, sums: try_vec(len, 0)?, total: 0, regions, left_out, hidden: Vec::new() })
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
        // Regions begin up to their own side before a cell that they hold.
        let before = self.sides.map(|side| 1 + (CELLS_A_REGION - 1) * side);
        for first in self.cells_of(&window.grown(self.output, before, [0; D])) {
            self.note(first);
        }
    }

    /// Enters a region's sum.
    fn note(&mut self, first: usize) {
        let sum = if self.left_out[first] { 0 } else { self.region_sum(first) };
        self.regions.set(first, sum);
    }

    /// Costs in the region that starts at a cell; regions shrink at open ends.
    fn region_sum(&self, first: usize) -> i64 {
        let from = self.cells.position(first);
        let shape = self.cells.shape.map(|n| n.min(CELLS_A_REGION));
        let cells = Domain::open(shape).positions();
        cells
            .filter_map(|by| self.cells.step(from, by.map(|b| b as i32)))
            .map(|at| self.sums[self.cells.index(at)])
            .sum()
    }

    /// Leaves the region that starts at a cell out of the search for the worst, and those that share most of it.
    pub(crate) fn leave_out(&mut self, first: usize) {
        let from = self.cells.position(first);
        for by in Domain::open([3; D]).positions() {
            let Some(at) = self.cells.step(from, by.map(|b| b as i32 - 1)) else { continue };
            let near = self.cells.index(at);
            self.left_out[near] = true;
            self.note(near);
        }
    }

    /// By region, whether it is left out.
    pub(crate) fn left_out(&self) -> &[bool] {
        &self.left_out
    }

    /// Leaves out these regions and no others; false, and nothing, unless there are as many.
    pub(crate) fn leave_out_all(&mut self, left_out: &[bool]) -> bool {
        if left_out.len() != self.left_out.len() {
            return false;
        }
        self.left_out.copy_from_slice(left_out);
        (0..left_out.len()).for_each(|first| self.note(first));
        true
    }

    /// Hides regions for now whose surroundings, `near` them, meet a window.
    pub(crate) fn hide(&mut self, window: &Window<D>, shape: [u32; D], near: impl Fn(&Window<D>) -> Window<D>) {
        let of = |first: usize| near(&self.region(first, shape));
        let reach = of(0).shape;
        let around = std::array::from_fn(|a| reach[a] + self.sides[a]);
        let met = |&first: &usize| of(first).meets(window, self.output);
        let met: Vec<usize> =
            self.cells_of(&window.grown(self.output, around, around)).into_iter().filter(met).collect();
        met.iter().for_each(|&first| self.regions.set(first, 0));
        self.hidden.extend(met);
    }

    /// Shows the hidden regions again.
    pub(crate) fn show(&mut self) {
        for first in std::mem::take(&mut self.hidden) {
            self.note(first);
        }
    }

    /// About how many regions lie in the output side by side.
    pub(crate) fn regions(&self) -> u64 {
        self.cells.shape.iter().map(|&n| u64::from(n.div_ceil(CELLS_A_REGION))).product()
    }

    /// Takes regions of a shape in again that meet a window.
    pub(crate) fn readmit(&mut self, window: &Window<D>, shape: [u32; D]) {
        let around = std::array::from_fn(|a| shape[a] + self.sides[a]);
        for first in self.cells_of(&window.grown(self.output, around, around)) {
            if self.left_out[first] && self.region(first, shape).meets(window, self.output) {
                self.left_out[first] = false;
                self.note(first);
            }
        }
    }

    /// The cells that a window meets.
    pub(crate) fn cells_of(&self, window: &Window<D>) -> Vec<usize> {
        let mut found = vec![0_usize];
        for (axis, stride) in self.cells.strides().into_iter().enumerate() {
            let size = self.output.strides()[axis] as u32 * self.sides[axis];
            let mut along: Vec<usize> =
                window.along(self.output, axis).flatten().map(|p| (p / size) as usize * stride).collect();
            // A window that wraps comes back to the cell that it began in: twice in the list it would only cost its sum
            // once more.
            along.sort_unstable();
            along.dedup();
            found = found.iter().flat_map(|f| along.iter().map(move |a| f + a)).collect();
        }
        found
    }

    fn sum(&self, map: &SourceMap<D>, costs: &SeamCosts<D>, cell: usize) -> i64 {
        let first = self.corner(cell);
        let shape: [u32; D] = std::array::from_fn(|a| self.sides[a].min(self.output.shape[a] - first[a]));
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

    /// The region (its first cell) with the largest sum among those not left out; the first of several. `None` if no
    /// sum is above 0. Time `O(1)`: sums are entered in `O(log(cells))` where seams change.
    pub(crate) fn worst(&self) -> Option<usize> {
        self.regions.best()
    }

    /// The region that starts at a cell, of a given shape; moved inside on open axes.
    pub(crate) fn region(&self, cell: usize, shape: [u32; D]) -> Window<D> {
        let corner = self.corner(cell);
        let start = std::array::from_fn(|a| {
            let most = self.output.shape[a] - shape[a];
            (if self.output.periodic[a] { corner[a] } else { corner[a].min(most) }) as i32
        });
        Window { start, shape }
    }

    /// The first position of a cell.
    fn corner(&self, cell: usize) -> [u32; D] {
        let at = self.cells.position(cell);
        std::array::from_fn(|a| at[a] * self.sides[a])
    }
}

/// Keeps the largest of many numbers: a binary tree of pairwise comparisons.
#[derive(Clone, Debug)]
struct Tournament {
    /// Numbers from the middle on; before them, each node's larger child.
    nodes: Vec<i64>,
}

impl Tournament {
    fn new(len: usize) -> Result<Self, Error> {
        Ok(Self { nodes: try_vec(2 * len.next_power_of_two(), 0)? })
    }

    fn set(&mut self, index: usize, value: i64) {
        let mut node = self.nodes.len() / 2 + index;
        self.nodes[node] = value;
        while 1 < node {
            node /= 2;
            self.nodes[node] = self.nodes[2 * node].max(self.nodes[2 * node + 1]);
        }
    }

    /// The first place of the largest number, if that is above 0.
    fn best(&self) -> Option<usize> {
        let leaves = self.nodes.len() / 2;
        let mut node = 1;
        while node < leaves {
            node = 2 * node + usize::from(self.nodes[2 * node] < self.nodes[2 * node + 1]);
        }
        (0 < self.nodes[node]).then(|| node - leaves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Exemplars, Grid, Origin, SampleId, SeamMeasure, Seed, Source, Transform};

    /// The definition: every region summed anew.
    fn worst_of<const D: usize>(cells: &ErrorCells<D>) -> Option<usize> {
        let sums = (0..cells.cells.len()).map(|first| if cells.left_out[first] { 0 } else { cells.region_sum(first) });
        let best = sums.enumerate().filter(|&(_, sum)| 0 < sum);
        best.max_by_key(|&(first, sum)| (sum, std::cmp::Reverse(first))).map(|(first, _)| first)
    }

    #[test]
    fn hidden_regions_are_those_whose_surroundings_meet_a_window() {
        for periodic in [[false; 2], [true, false], [true; 2]] {
            let output = Domain { shape: [40, 61], periodic };
            let mut cells = ErrorCells::<2>::new(output, [3, 4]).unwrap();
            let all = 0..cells.cells.len();
            all.clone().for_each(|first| cells.sums[first] = 1 + first as i64);
            all.clone().for_each(|first| cells.note(first));
            let (shown, region) = (cells.regions.clone(), [9, 12]);
            let near = |r: &Window<2>| Window { start: [r.start[0] - 4, r.start[1] - 7], shape: [18, 25] };
            for window in [Window { start: [-3, 50], shape: [10, 30] }, Window { start: [20, 20], shape: [1, 1] }] {
                cells.hide(&window.grown(output, [0; 2], [0; 2]), region, near);
                let is_hidden = |first: &usize| cells.regions.nodes[cells.regions.nodes.len() / 2 + first] == 0;
                let meets = |&first: &usize| near(&cells.region(first, region)).meets(&window, output);
                let hidden: Vec<usize> = all.clone().filter(is_hidden).collect();
                assert_eq!(hidden, all.clone().filter(meets).collect::<Vec<_>>());
                assert!(!hidden.is_empty() && hidden.len() < cells.cells.len());
                cells.show();
                assert_eq!(cells.regions.nodes, shown.nodes);
            }
        }
    }

    #[test]
    fn the_worst_region_is_kept_up_to_date() {
        let topologies = [[false; 2], [true, false], [true; 2]];
        for (i, (periodic, sides)) in topologies.into_iter().zip([[3, 3], [2, 5], [4, 1]]).enumerate() {
            let region = sides.map(|side| CELLS_A_REGION * side);
            let mut rng = Seed(3).derive("cells", i as u64).rng();
            let noise = (0..64).map(|_| rng.below(256) as u8).collect();
            let features = Grid::from_vec(Domain::open([8, 8]), 1, noise).unwrap();
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
            let costs = SeamCosts::new(&exemplars, SeamMeasure::Difference).unwrap();
            let mut map = SourceMap::unassigned(&exemplars, Domain { shape: [23, 31], periodic }).unwrap();
            map.ids.plane_mut(0).fill(SampleId::new(9));
            let mut cells = ErrorCells::new(map.domain(), sides).unwrap();
            cells.update(&map, &costs, &Window::all(map.domain()));
            for _ in 0..200 {
                let at = [rng.below(23), rng.below(31)];
                let place = map.domain().index(at);
                map.ids.plane_mut(0)[place] = SampleId::new(rng.below(64));
                let window = Window { start: at.map(|a| a as i32), shape: [1, 1] };
                cells.update(&map, &costs, &window);
                assert_eq!(cells.worst(), worst_of(&cells));
                match (rng.below(3), cells.worst()) {
                    (0, Some(first)) => cells.leave_out(first),
                    (1, _) => cells.readmit(&window, region),
                    _ => {}
                }
                assert_eq!(cells.worst(), worst_of(&cells));
            }
            let met: Vec<usize> = (0..cells.cells.len()).collect();
            met.iter().for_each(|&first| cells.leave_out(first));
            let window = Window { start: [20, 2], shape: [5, 1] };
            cells.readmit(&window, region);
            for first in met {
                assert_eq!(cells.left_out[first], !cells.region(first, region).meets(&window, map.domain()));
            }
        }
    }
}
