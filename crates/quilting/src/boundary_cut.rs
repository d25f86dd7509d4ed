//! The minimum error boundary cut of one block against what lies under it. `[Efros01 2.1]`
//!
//! A block meets old samples on up to four strips: left and top in raster order, right and bottom where a periodic
//! output closes. On each strip the cut is the cheapest path of `[Efros01 eq. 1]`. Where two strips meet, "the minimal
//! paths meet in the middle and the overall minimum is chosen": over all cells of the corner, the sum of both paths to
//! the cell, its own error counted once. With corners at both ends, a strip's two halves are joined at its middle row;
//! the choices there are tried all, so the cut is the cheapest of all closed ones.
//!
//! Of a strip, old samples may be there in part only. Where there is none the new block shows, and a path that runs
//! there pays for where the old really ends: for the last old sample between it and the block's edge, if there is any.
//! Without that the cheapest path would be the one that keeps everything old and ends it in a visible edge.
//!
//! ```
//! use selvedge_quilting::boundary_cut::{Overlaps, boundary_cut};
//! # fn main() -> Result<(), selvedge_core::Error> {
//! // Three rows of an overlap of three on the left; in the last row only the first sample is old.
//! let error = [5, 1, 5, 9, 5, 1, 9, 5, 2, 9, 1, 0, 4, 0, 0, 9];
//! let known = [true, true, true, false, true, true, true, false, true, true, true, false, true, false, false, false];
//! let cut = boundary_cut([4, 4], Overlaps { left: 3, ..Overlaps::default() }, &error, Some(&known))?;
//! let shown: String = cut.new.iter().map(|&new| if new { '#' } else { '.' }).collect();
//! assert_eq!(shown, ".###.###..##.###");
//! # Ok(())
//! # }
//! ```

use selvedge_core::{Error, try_vec};

use crate::strip::{Cumulative, End, Start, Strip};

/// Samples of overlap on each side of a block; 0 for a side that is not cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overlaps {
    /// Columns on the left.
    pub left: usize,
    /// Rows at the top.
    pub top: usize,
    /// Columns on the right.
    pub right: usize,
    /// Rows at the bottom.
    pub bottom: usize,
}

/// The sides in ring order; each corner lies between a side and the next.
const LEFT: usize = 0;
const TOP: usize = 1;
const RIGHT: usize = 2;
const BOTTOM: usize = 3;

/// At each corner the ends of the two strips that meet there, in ring order: top left, top right, bottom right, bottom
/// left.
const CORNERS: [(End, End); 4] =
    [(End::Low, End::Low), (End::High, End::Low), (End::High, End::High), (End::Low, End::High)];

/// The cut of one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Row-major over the block: true where the new block shows.
    pub new: Vec<bool>,
    /// Sum of the errors along the cut.
    pub cost: u64,
}

/// Cuts a block of `h * w` samples, whose squared errors against the old samples are `error` (row-major, `h * w` values
/// of which only those on the overlaps are looked at). `known` says which old samples there are; `None` for all on the
/// overlaps.
///
/// Two overlaps that face each other must not meet: `left + right <= w`, `top + bottom <= h`. The errors of a block
/// together are less than `2^62`; of larger ones the cut is some cut, but perhaps not the cheapest.
///
/// Time `O(h * w)` for a cut that is open at both ends. A strip between two corners, where the output closes, is solved
/// for each cell of its middle row: `O(side * overlap^2)` time and space for its paths, and `overlap^4` sums for a
/// corner between two of them.
///
/// # Errors
/// [`Error::Allocation`].
///
/// # Panics
/// If a buffer is shorter than the block, or an overlap wider.
pub fn boundary_cut(
    [h, w]: [usize; 2],
    overlaps: Overlaps,
    error: &[u64],
    known: Option<&[bool]>,
) -> Result<Cut, Error> {
    let strip = |len: usize, width: usize, at: &dyn Fn(usize, usize) -> usize| {
        let strip = |()| Strip::new(len, width, |along, across| error[at(along, across)]);
        let mut strip = (0 < width).then_some(()).map(strip).transpose()?;
        if let (Some(strip), Some(known)) = (&mut strip, known) {
            strip.carry_inwards(|along, across| known[at(along, across)]);
        }
        Ok::<_, Error>(strip)
    };
    let strips = [
        strip(h, overlaps.left, &|a, c| a * w + c)?,
        strip(w, overlaps.top, &|a, c| c * w + a)?,
        strip(h, overlaps.right, &|a, c| a * w + w - 1 - c)?,
        strip(w, overlaps.bottom, &|a, c| (h - 1 - c) * w + a)?,
    ];
    let (paths, cost) = Ring { strips }.solve()?;
    let mut new = try_vec(h * w, false)?;
    let is_hole = |i: usize| known.is_some_and(|known| !known[i]);
    new.iter_mut().enumerate().for_each(|(i, new)| {
        *new = is_hole(i) || is_new(&paths, overlaps, [h, w], [i / w, i % w]);
    });
    Ok(Cut { new, cost })
}

/// Per side the path's `across` at each `along`; `None` beyond a corner's meeting cell.
type Paths = [Vec<Option<usize>>; 4];

/// A sample is old where it lies outside of a path, or beyond the cell where two paths meet.
fn is_new(paths: &Paths, o: Overlaps, [h, w]: [usize; 2], [y, x]: [usize; 2]) -> bool {
    let inside = [(o.left, y, x), (o.top, x, y), (o.right, y, w - 1 - x), (o.bottom, x, h - 1 - y)];
    let mut verdicts = (0..4).filter(|&s| inside[s].2 < inside[s].0).map(|s| {
        let (_, along, across) = inside[s];
        paths[s][along].map(|p| p <= across)
    });
    // In a corner two strips judge. Where neither path is defined the sample is old; where one is, that one decides.
    match (verdicts.next(), verdicts.next()) {
        (None, _) => true,
        (Some(one), None) => one.unwrap_or(false),
        (Some(None), Some(None)) => false,
        (Some(a), Some(b)) => a.unwrap_or(true) && b.unwrap_or(true),
    }
}

/// The strips around a block, in ring order.
struct Ring {
    strips: [Option<Strip>; 4],
}

/// For each pair of the two strips' states the cost of the best meeting cell.
struct Corner {
    n_second: usize,
    costs: Vec<u64>,
}

/// What no path leads to costs more than any path, and twice as much is still a number.
const UNREACHED: u64 = 1 << 62;

/// The cells of a corner that two strips reach over so many rows: depth on the first strip's end, depth on the
/// second's. Each is the other's `across`.
fn cells([a, b]: [&Strip; 2], [a_rows, b_rows]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let (depths, others) = (b.width().min(a_rows), a.width().min(b_rows));
    (0..depths).flat_map(move |u| (0..others).map(move |v| [u, v]))
}

/// The error of a corner's cell. Where nothing old is there, the two strips may see different errors beyond it.
fn shared(corner: usize, [a, b]: [&Strip; 2], [u, v]: [usize; 2]) -> u64 {
    let (end_a, end_b) = CORNERS[corner];
    a.error(a.row(end_a, u), v).min(b.error(b.row(end_b, v), u))
}

impl Ring {
    fn has_corner(&self, corner: usize) -> bool {
        self.strips[corner].is_some() && self.strips[(corner + 1) % 4].is_some()
    }

    /// Corners at the strip's low and high end, by side.
    fn corner_at(side: usize, end: End) -> usize {
        match (side, end) {
            (LEFT, End::Low) | (TOP, End::Low) => 0,
            (TOP, End::High) | (RIGHT, End::Low) => 1,
            (RIGHT, End::High) | (BOTTOM, End::High) => 2,
            _ => 3,
        }
    }

    /// A strip between two corners has one state for each cell of its middle row; any other just one.
    fn n_states(&self, side: usize) -> usize {
        match &self.strips[side] {
            Some(strip) if self.is_double(side) => strip.width(),
            _ => 1,
        }
    }

    fn is_double(&self, side: usize) -> bool {
        [End::Low, End::High].iter().all(|&end| self.has_corner(Self::corner_at(side, end)))
    }

    fn start(&self, side: usize, strip: &Strip, state: usize) -> Start {
        if self.is_double(side) { Start::Cell { along: strip.len() / 2, across: state } } else { Start::OtherEnd }
    }

    /// What leads to a corner from each state of its two strips.
    fn ways(&self, corner: usize, a: &Strip, b: &Strip) -> Result<[Vec<Cumulative>; 2], Error> {
        let (second, (end_a, end_b)) = ((corner + 1) % 4, CORNERS[corner]);
        let from = |side, strip: &Strip, end| -> Result<Vec<Cumulative>, Error> {
            (0..self.n_states(side)).map(|s| strip.cumulative(self.start(side, strip, s), end)).collect()
        };
        Ok([from(corner, a, end_a)?, from(second, b, end_b)?])
    }

    /// Costs alone: of four strips there are `overlap^4` sums, and the cells of only one pair of states are asked for.
    fn corner(&self, corner: usize) -> Result<Corner, Error> {
        let second = (corner + 1) % 4;
        let (n_first, n_second) = (self.n_states(corner), self.n_states(second));
        let (Some(a), Some(b)) = (&self.strips[corner], &self.strips[second]) else {
            return Ok(Corner { n_second, costs: try_vec(n_first * n_second, 0)? });
        };
        let mut costs = try_vec(n_first * n_second, u64::MAX)?;
        let [from_a, from_b] = self.ways(corner, a, b)?;
        let (mut to_a, mut to_b) = (try_vec(n_first, 0)?, try_vec(n_second, 0)?);
        for [u, v] in cells([a, b], [from_a[0].len(), from_b[0].len()]) {
            let shared = shared(corner, [a, b], [u, v]);
            // The cell counts once.
            let at_a = |sums: &Cumulative| sums.row(sums.len() - 1 - u)[v].min(UNREACHED).saturating_sub(shared);
            let at_b = |sums: &Cumulative| sums.row(sums.len() - 1 - v)[u].min(UNREACHED);
            to_a.iter_mut().zip(&from_a).for_each(|(to, sums)| *to = at_a(sums));
            to_b.iter_mut().zip(&from_b).for_each(|(to, sums)| *to = at_b(sums));
            for (costs, a) in costs.chunks_mut(n_second).zip(&to_a) {
                costs.iter_mut().zip(&to_b).for_each(|(cost, b)| *cost = (*cost).min(a + b));
            }
        }
        Ok(Corner { n_second, costs })
    }

    /// The cell in which the paths of two states meet; of cells that cost the same the first.
    fn meeting(&self, corner: usize, [state_a, state_b]: [usize; 2]) -> Result<[usize; 2], Error> {
        let second = (corner + 1) % 4;
        let (Some(a), Some(b)) = (&self.strips[corner], &self.strips[second]) else { return Ok([0; 2]) };
        let (end_a, end_b) = CORNERS[corner];
        let a_sums = a.cumulative(self.start(corner, a, state_a), end_a)?;
        let b_sums = b.cumulative(self.start(second, b, state_b), end_b)?;
        let cost = |[u, v]: [usize; 2]| {
            let (va, vb) = (a_sums.row(a_sums.len() - 1 - u)[v], b_sums.row(b_sums.len() - 1 - v)[u]);
            va.saturating_add(vb).saturating_sub(shared(corner, [a, b], [u, v]))
        };
        let cells = cells([a, b], [a_sums.len(), b_sums.len()]);
        Ok(cells.map(|cell| (cost(cell), cell)).min().map_or([0; 2], |(_, cell)| cell))
    }

    /// The cheapest closed cut: paths of all sides, and its cost.
    fn solve(&self) -> Result<(Paths, u64), Error> {
        let corners = [self.corner(0)?, self.corner(1)?, self.corner(2)?, self.corner(3)?];
        let (mut cost, states) = self.choose_states(&corners);
        let undefined = |side: usize| try_vec(self.strips[side].as_ref().map_or(0, Strip::len), None);
        let mut paths: Paths = [undefined(LEFT)?, undefined(TOP)?, undefined(RIGHT)?, undefined(BOTTOM)?];
        for side in 0..4 {
            let Some(strip) = &self.strips[side] else { continue };
            let mut any_corner = false;
            for end in [End::Low, End::High] {
                let c = Self::corner_at(side, end);
                if !self.has_corner(c) {
                    continue;
                }
                any_corner = true;
                let [u, v] = self.meeting(c, [states[c], states[(c + 1) % 4]])?;
                let (depth, across) = if c == side { (u, v) } else { (v, u) };
                draw(&mut paths[side], &strip.trace(self.start(side, strip, states[side]), end, depth, across)?);
            }
            if !any_corner {
                let sums = strip.cumulative(Start::OtherEnd, End::High)?;
                let last = sums.row(sums.len() - 1).iter().enumerate();
                let (end_cost, across) = last.map(|(c, &v)| (v, c)).min().unwrap_or((0, 0));
                cost = cost.saturating_add(end_cost);
                draw(&mut paths[side], &strip.trace(Start::OtherEnd, End::High, 0, across)?);
            }
        }
        Ok((paths, cost))
    }

    /// One state a side, so that the corners' costs are least; a middle cell that both halves hold is counted once.
    fn choose_states(&self, corners: &[Corner; 4]) -> (u64, [usize; 4]) {
        let n: [usize; 4] = std::array::from_fn(|s| self.n_states(s));
        let twice = |side: usize, state: usize| match &self.strips[side] {
            Some(strip) if self.is_double(side) => strip.error(strip.len() / 2, state),
            _ => 0,
        };
        let corner = |c: usize, a: usize, b: usize| corners[c].costs[a * corners[c].n_second + b];
        let mut best = (u64::MAX, [0; 4]);
        for left in 0..n[LEFT] {
            // Cheapest way round so far to each state of a side, with the states before it.
            let mut so_far: Vec<(u64, [usize; 4])> = vec![(0, [left, 0, 0, 0])];
            for side in [TOP, RIGHT, BOTTOM] {
                let step = |state: usize| {
                    so_far
                        .iter()
                        .map(|&(cost, mut states)| {
                            let added = corner(side - 1, states[side - 1], state);
                            states[side] = state;
                            (cost.saturating_add(added).saturating_sub(twice(side, state)), states)
                        })
                        .min()
                        .unwrap_or(best)
                };
                so_far = (0..n[side]).map(step).collect();
            }
            for (cost, states) in so_far {
                let total = cost.saturating_add(corner(3, states[BOTTOM], left)).saturating_sub(twice(LEFT, left));
                best = best.min((total, states));
            }
        }
        best
    }
}

fn draw(path: &mut [Option<usize>], cells: &[(usize, usize)]) {
    for &(along, across) in cells {
        path[along] = Some(across);
    }
}

#[cfg(test)]
mod tests;
