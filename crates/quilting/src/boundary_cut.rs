//! The minimum error boundary cut of one block against what lies under it. `[Efros01 2.1]`
//!
//! A block meets old samples on up to four strips: left and top in raster order, right and bottom where a periodic
//! output closes. On each strip the cut is the cheapest path of `[Efros01 eq. 1]`. Where two strips meet, "the minimal
//! paths meet in the middle and the overall minimum is chosen": over all cells of the corner, the sum of both paths to
//! the cell, its own error counted once. With corners at both ends, a strip's two halves are joined at its middle row;
//! the choices there are tried all, so the cut is the cheapest of all closed ones.

use selvedge_core::{Error, try_vec};

use crate::strip::{Cumulative, End, Start, Strip};

/// Samples of overlap on each side of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Overlaps {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) right: usize,
    pub(crate) bottom: usize,
}

/// The sides in ring order; each corner lies between a side and the next.
const LEFT: usize = 0;
const TOP: usize = 1;
const RIGHT: usize = 2;
const BOTTOM: usize = 3;

/// At each corner the ends of the two strips that meet there, in ring order: top left, top right, bottom right, bottom left.
const CORNERS: [(End, End); 4] =
    [(End::Low, End::Low), (End::High, End::Low), (End::High, End::High), (End::Low, End::High)];

/// The cut of one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    /// Row-major over the block: true where the new block shows.
    pub(crate) new: Vec<bool>,
    /// Sum of the errors along the cut.
    pub(crate) cost: u64,
}

/// Cuts a block of `h * w` samples, whose squared errors against the old samples are `error` (row-major, defined on
/// the overlaps).
///
/// Time `O(h * w)` for a cut that is open at both ends. A strip between two corners, where the output closes, is solved
/// for each cell of its middle row: `O(side * overlap^2)` time and space for its paths, and `O(overlap^4)` time for a
/// corner between two of them.
///
/// # Errors
/// No memory.
pub(crate) fn boundary_cut([h, w]: [usize; 2], overlaps: Overlaps, error: &[u64]) -> Result<Cut, Error> {
    let at = |y: usize, x: usize| error[y * w + x];
    let strips = [
        (overlaps.left > 0).then(|| Strip::new(h, overlaps.left, at)).transpose()?,
        (overlaps.top > 0).then(|| Strip::new(w, overlaps.top, |a, c| at(c, a))).transpose()?,
        (overlaps.right > 0).then(|| Strip::new(h, overlaps.right, |a, c| at(a, w - 1 - c))).transpose()?,
        (overlaps.bottom > 0).then(|| Strip::new(w, overlaps.bottom, |a, c| at(h - 1 - c, a))).transpose()?,
    ];
    let (paths, cost) = Ring { strips }.solve()?;
    let mut new = try_vec(h * w, false)?;
    new.iter_mut().enumerate().for_each(|(i, new)| *new = is_new(&paths, overlaps, [h, w], [i / w, i % w]));
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

/// For each pair of the two strips' states the cost of the best meeting cell, and the cell (depth on the first strip's
/// end, depth on the second's: each is the other's `across`).
struct Corner {
    n_second: usize,
    best: Vec<(u64, [usize; 2])>,
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

    fn corner(&self, corner: usize) -> Result<Corner, Error> {
        let second = (corner + 1) % 4;
        let (n_first, n_second) = (self.n_states(corner), self.n_states(second));
        let mut best = try_vec(n_first * n_second, (0, [0; 2]))?;
        let (Some(a), Some(b)) = (&self.strips[corner], &self.strips[second]) else {
            return Ok(Corner { n_second, best });
        };
        let (end_a, end_b) = CORNERS[corner];
        let reach = |side, strip: &Strip, end, n| -> Result<Vec<Cumulative>, Error> {
            (0..n).map(|s| strip.cumulative(self.start(side, strip, s), end)).collect()
        };
        let (from_a, from_b) = (reach(corner, a, end_a, n_first)?, reach(second, b, end_b, n_second)?);
        for (i, best) in best.iter_mut().enumerate() {
            let (a_sums, b_sums) = (&from_a[i / n_second], &from_b[i % n_second]);
            // Cell (u, v): u rows from a's end and v rows from b's end; u is b's `across`, v is a's.
            let cells = (0..b.width()).flat_map(|u| (0..a.width()).map(move |v| (u, v)));
            let cost = |u: usize, v: usize| {
                let (va, vb) = (a_sums.row(a_sums.len() - 1 - u)[v], b_sums.row(b_sums.len() - 1 - v)[u]);
                va.saturating_add(vb).saturating_sub(a.error(a.row(end_a, u), v))
            };
            let cells = cells.filter(|&(u, v)| u < a_sums.len() && v < b_sums.len());
            *best = cells.map(|(u, v)| (cost(u, v), [u, v])).min().unwrap_or((u64::MAX, [0; 2]));
        }
        Ok(Corner { n_second, best })
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
                let [u, v] = corners[c].best[states[c] * corners[c].n_second + states[(c + 1) % 4]].1;
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
        let corner = |c: usize, a: usize, b: usize| corners[c].best[a * n[(c + 1) % 4] + b].0;
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
mod tests {
    use super::*;
    use selvedge_core::{Rng, Seed};

    fn random_errors(rng: &mut Rng, n: usize, below: u32) -> Vec<u64> {
        (0..n).map(|_| u64::from(rng.below(below))).collect()
    }

    /// Cheapest path between two cells, by trying every one.
    fn brute(error: &dyn Fn(usize, usize) -> u64, width: usize, from: (usize, usize), to: (usize, usize)) -> u64 {
        let here = error(from.0, from.1);
        if from.0 == to.0 {
            return if from.1 == to.1 { here } else { u64::MAX };
        }
        let near = from.1.saturating_sub(1)..(from.1 + 2).min(width);
        let rest = near.map(|c| brute(error, width, (from.0 + 1, c), to)).min().unwrap_or(u64::MAX);
        rest.saturating_add(here)
    }

    /// The cheapest cut, by trying every meeting cell of every corner and every path between them.
    fn brute_cut([h, w]: [usize; 2], o: Overlaps, e: &[u64]) -> u64 {
        let sides = [(o.left, h), (o.top, w), (o.right, h), (o.bottom, w)];
        let at = |side: usize, a: usize, c: usize| match side {
            LEFT => e[a * w + c],
            TOP => e[c * w + a],
            RIGHT => e[a * w + w - 1 - c],
            _ => e[(h - 1 - c) * w + a],
        };
        // A corner's candidates are its cells (depth on the first strip, depth on the second).
        let has = |c: usize| 0 < sides[c].0 && 0 < sides[(c + 1) % 4].0;
        let cells = |c: usize| -> Vec<[usize; 2]> {
            if !has(c) {
                return vec![[0, 0]];
            }
            (0..sides[(c + 1) % 4].0).flat_map(|u| (0..sides[c].0).map(move |v| [u, v])).collect()
        };
        let mut best = u64::MAX;
        for c0 in cells(0) {
            for c1 in cells(1) {
                for c2 in cells(2) {
                    for c3 in cells(3) {
                        let chosen = [c0, c1, c2, c3];
                        let mut total = 0_u64;
                        for (side, &(width, len)) in sides.iter().enumerate() {
                            if width == 0 {
                                continue;
                            }
                            let ends = [End::Low, End::High].map(|end| {
                                let c = Ring::corner_at(side, end);
                                let cell = if c == side { chosen[c] } else { [chosen[c][1], chosen[c][0]] };
                                let along = if end == End::Low { cell[0] } else { len - 1 - cell[0] };
                                let open = if end == End::Low { 0 } else { len - 1 };
                                if has(c) { vec![(along, cell[1])] } else { (0..width).map(|x| (open, x)).collect() }
                            });
                            let path = ends[0].iter().flat_map(|&a| ends[1].iter().map(move |&b| (a, b)));
                            let error = |a: usize, c: usize| at(side, a, c);
                            let cost =
                                path.map(|(a, b)| if a.0 <= b.0 { brute(&error, width, a, b) } else { u64::MAX });
                            total = total.saturating_add(cost.min().unwrap_or(u64::MAX));
                        }
                        for c in (0..4).filter(|&c| has(c)) {
                            let [u, v] = chosen[c];
                            let (len, end) = (sides[c].1, CORNERS[c].0);
                            total = total.saturating_sub(at(c, if end == End::Low { u } else { len - 1 - u }, v));
                        }
                        best = best.min(total);
                    }
                }
            }
        }
        best
    }

    #[test]
    fn the_cut_is_the_cheapest_of_all() {
        let mut rng = Seed(1).rng();
        for case in 0..400 {
            let [h, w] = [4 + rng.below(3) as usize, 4 + rng.below(3) as usize];
            let mut side =
                |bit: u32, max: usize| if case >> bit & 1 == 1 { 1 + rng.below(max as u32) as usize } else { 0 };
            let o =
                Overlaps { left: side(0, w / 2), top: side(1, h / 2), right: side(2, w / 2), bottom: side(3, h / 2) };
            let e = random_errors(&mut rng, h * w, 50);
            let cut = boundary_cut([h, w], o, &e).unwrap();
            let expected = if o == Overlaps::default() { 0 } else { brute_cut([h, w], o, &e) };
            assert_eq!(cut.cost, expected, "{h}x{w} {o:?}");
        }
    }

    /// Every path between two cells, row by row.
    fn all_paths(width: usize, from: (usize, usize), to: (usize, usize)) -> Vec<Vec<usize>> {
        if from.0 == to.0 {
            return if from.1 == to.1 { vec![vec![from.1]] } else { Vec::new() };
        }
        let near = from.1.saturating_sub(1)..(from.1 + 2).min(width);
        let rests = near.flat_map(|c| all_paths(width, (from.0 + 1, c), to));
        rests.map(|rest| std::iter::once(from.1).chain(rest).collect()).collect()
    }

    /// The cells of the cheapest cut along left and top that meet in their corner, by trying all, if it is the only one.
    fn brute_corner([h, w]: [usize; 2], left: usize, top: usize, e: &[u64]) -> Option<Vec<usize>> {
        let mut all: Vec<(u64, Vec<usize>)> = Vec::new();
        for (y, x) in (0..top).flat_map(|y| (0..left).map(move |x| (y, x))) {
            let down = (0..left).flat_map(|end| all_paths(left, (y, x), (h - 1, end)));
            let down: Vec<Vec<usize>> =
                down.map(|p| p.iter().enumerate().map(|(i, c)| (y + i) * w + c).collect()).collect();
            let right = (0..top).flat_map(|end| all_paths(top, (x, y), (w - 1, end)));
            for along in right {
                let along: Vec<usize> = along.iter().enumerate().skip(1).map(|(i, c)| c * w + x + i).collect();
                for down in &down {
                    let cells = [&down[..], &along[..]].concat();
                    all.push((cells.iter().map(|&i| e[i]).sum(), cells));
                }
            }
        }
        all.sort_unstable();
        (all[0].0 < all[1].0).then(|| all.swap_remove(0).1)
    }

    /// What is not enclosed by a cut with the block's left and top edge: the cut's cells and all on their far side.
    fn beyond(cells: &[usize], [h, w]: [usize; 2]) -> Vec<bool> {
        let mut new = vec![true; h * w];
        let edge = (0..w).chain((0..h).map(|y| y * w));
        let mut stack: Vec<usize> = edge.collect();
        while let Some(i) = stack.pop() {
            if cells.contains(&i) || !std::mem::replace(&mut new[i], false) {
                continue;
            }
            let (y, x) = (i / w, i % w);
            let next = [
                (0 < y).then(|| i - w),
                (y + 1 < h).then(|| i + w),
                (0 < x).then(|| i - 1),
                (x + 1 < w).then(|| i + 1),
            ];
            stack.extend(next.into_iter().flatten());
        }
        new
    }

    #[test]
    fn the_mask_is_bounded_by_the_cheapest_cut() {
        let mut rng = Seed(5).rng();
        let mut tried = 0;
        for _ in 0..60 {
            let [h, w] = [4 + rng.below(2) as usize, 4 + rng.below(2) as usize];
            let (left, top) = (2 + rng.below(2) as usize, 2 + rng.below(2) as usize);
            let e = random_errors(&mut rng, h * w, 10_000);
            let Some(cells) = brute_corner([h, w], left, top, &e) else { continue };
            let cut = boundary_cut([h, w], Overlaps { left, top, ..Overlaps::default() }, &e).unwrap();
            assert_eq!(cut.cost, cells.iter().map(|&i| e[i]).sum::<u64>());
            assert_eq!(cut.new, beyond(&cells, [h, w]), "{h}x{w} {left} {top} {e:?}");
            tried += 1;
        }
        assert!(40 < tried, "{tried}");
    }

    #[test]
    fn the_errors_along_the_mask_are_the_cost() {
        let mut rng = Seed(6).rng();
        let [h, w] = [14, 11];
        for case in 0..100 {
            let e = random_errors(&mut rng, h * w, 100);
            let on = |side| if case % 4 == side { 5 } else { 0 };
            let overlaps = Overlaps { left: on(0), top: on(1), right: on(2), bottom: on(3) };
            let cut = boundary_cut([h, w], overlaps, &e).unwrap();
            // Line by line from the old side: the first new sample.
            let (lines, across) = if case % 2 == 0 { (h, w) } else { (w, h) };
            let index = |line: usize, a: usize| match case % 4 {
                0 => line * w + a,
                1 => a * w + line,
                2 => line * w + w - 1 - a,
                _ => (h - 1 - a) * w + line,
            };
            let border = (0..lines).map(|line| (0..across).map(|a| index(line, a)).find(|&i| cut.new[i]).unwrap());
            assert_eq!(border.map(|i| e[i]).sum::<u64>(), cut.cost, "{overlaps:?}");
        }
    }

    #[test]
    fn no_straight_cut_is_cheaper() {
        let mut rng = Seed(2).rng();
        for _ in 0..200 {
            let (h, w, left) = (12, 12, 5);
            let e = random_errors(&mut rng, h * w, 1000);
            let cut = boundary_cut([h, w], Overlaps { left, ..Overlaps::default() }, &e).unwrap();
            let straight = (0..left).map(|x| (0..h).map(|y| e[y * w + x]).sum::<u64>()).min().unwrap();
            assert!(cut.cost <= straight);
        }
    }

    #[test]
    fn the_new_side_is_right_of_the_left_path_and_below_the_top_path() {
        // Zero errors along an L through column 1 and row 2 force the cut.
        let (h, w) = (6, 6);
        let mut e = vec![9_u64; h * w];
        (2..h).for_each(|y| e[y * w + 1] = 0);
        (1..w).for_each(|x| e[2 * w + x] = 0);
        let cut = boundary_cut([h, w], Overlaps { left: 3, top: 3, ..Overlaps::default() }, &e).unwrap();
        let picture: Vec<String> =
            cut.new.chunks(w).map(|r| r.iter().map(|&n| if n { '#' } else { '.' }).collect()).collect();
        assert_eq!(cut.cost, 0);
        assert_eq!(picture, ["......", "......", ".#####", ".#####", ".#####", ".#####"]);
    }

    #[test]
    fn the_two_sides_of_a_ring_are_connected() {
        // What is new is one piece, and so is what stays old: the cut is closed.
        let mut rng = Seed(3).rng();
        for _ in 0..100 {
            let (h, w) = (12, 14);
            let o = Overlaps { left: 4, top: 5, right: 6, bottom: 3 };
            let e = random_errors(&mut rng, h * w, 9);
            let new = boundary_cut([h, w], o, &e).unwrap().new;
            assert!(new[(h / 2) * w + w / 2]);
            assert_eq!(pieces(&new, [h, w], true), 1);
        }
    }

    /// Number of 8-connected pieces of a kind.
    fn pieces(mask: &[bool], [h, w]: [usize; 2], kind: bool) -> usize {
        let mut seen = vec![false; h * w];
        let mut n = 0;
        for start in 0..h * w {
            if seen[start] || mask[start] != kind {
                continue;
            }
            n += 1;
            let mut stack = vec![start];
            while let Some(i) = stack.pop() {
                if std::mem::replace(&mut seen[i], true) {
                    continue;
                }
                let (y, x) = (i / w, i % w);
                for (ny, nx) in (y.saturating_sub(1)..(y + 2).min(h))
                    .flat_map(|ny| (x.saturating_sub(1)..(x + 2).min(w)).map(move |nx| (ny, nx)))
                {
                    if mask[ny * w + nx] == kind && !seen[ny * w + nx] {
                        stack.push(ny * w + nx);
                    }
                }
            }
        }
        n
    }
}
