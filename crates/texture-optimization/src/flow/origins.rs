//! Where the samples of a frame come from in the frame before. `[Kwatra05 4.1]`

use selvedge_core::{Domain, Error, Flow, par, try_vec};

/// Fixed-point steps at most. Fields that a texture can follow change by less than half a sample from one to the next,
/// and each step halves the error there at least.
const STEPS: u32 = 30;
/// Samples by which a forward field may miss where its inverse came from, and still count: a twentieth adds up to half
/// a sample in ten frames at most, and what is carried is measured anew in each.
const MISSED: f64 = 0.05;
/// Times by which an area may grow in a step and still be wished for: what is stretched more shows blur or copies.
const GROWTH: f64 = 1.5;

/// What the vectors of a flow say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// Where each sample of a frame goes in the next one.
    #[default]
    Forward,
    /// Where each sample of a frame comes from in the one before.
    Backward,
}

impl Direction {
    /// By the same vectors, the other way.
    pub(crate) fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// Where a sample comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Origin {
    /// Between samples of the frame before, or beyond its open edges; where that is unknown, where it is.
    pub(crate) at: [f64; 2],
    /// Whether something was there that moved here: not from beyond an edge, nor stretched, nor unknown.
    pub(crate) is_sure: bool,
}

/// One for each sample of the next frame.
///
/// Time `O(samples)`, in the caller's pool.
///
/// # Errors
/// No memory.
pub(crate) fn origins(flow: &Flow, direction: Direction) -> Result<Vec<Origin>, Error> {
    let domain = flow.domain();
    let mut origins = try_vec(domain.len(), Origin { at: [0.0; 2], is_sure: false })?;
    par::for_rows(&mut origins, domain.shape[1].max(1) as usize, |y, row| {
        row.iter_mut().zip(0..).for_each(|(one, x)| *one = origin(flow, direction, [y as u32, x]));
    });
    Ok(origins)
}

fn origin(flow: &Flow, direction: Direction, q: [u32; 2]) -> Origin {
    let domain = flow.domain();
    let here = q.map(f64::from);
    let (at, is_sure) = match direction {
        Direction::Forward => inverse(flow, here).unwrap_or((here, false)),
        Direction::Backward => vector(flow, here).map_or((here, false), |by| (plus(here, by), true)),
    };
    // Of a backward field the area that a sample came from.
    let area = determinant(flow, if direction == Direction::Forward { at } else { here }).unwrap_or(1.0);
    let grown = if direction == Direction::Forward { area } else { 1.0 / area };
    let (at, is_inside) = inside(domain, at);
    Origin { at, is_sure: is_sure && is_inside && 0.0 < grown && grown <= GROWTH }
}

/// The position from which a forward field leads to `q`, by `p = q - u(p)`, and whether it does.
fn inverse(flow: &Flow, q: [f64; 2]) -> Option<([f64; 2], bool)> {
    let (mut p, mut missed) = (q, f64::INFINITY);
    for _ in 0..STEPS {
        let by = vector(flow, p)?;
        let next = [q[0] - by[0], q[1] - by[1]];
        missed = (next[0] - p[0]).abs().max((next[1] - p[1]).abs());
        p = next;
        if missed == 0.0 {
            break;
        }
    }
    Some((p, missed <= MISSED))
}

fn plus(p: [f64; 2], by: [f64; 2]) -> [f64; 2] {
    [p[0] + by[0], p[1] + by[1]]
}

/// The flow between samples; `None` where it is unknown. Beyond open edges that of the edge.
fn vector(flow: &Flow, p: [f64; 2]) -> Option<[f64; 2]> {
    let mut sum = [0.0; 2];
    for (at, weight) in corners(flow.domain(), p) {
        if !flow.is_known(at) {
            return None;
        }
        (0..2).for_each(|c| sum[c] += weight * f64::from(flow.by.get(c, at)));
    }
    Some(sum)
}

/// The samples around a position that have a part in it, and how much: around periodic axes, none beyond open ones.
pub(super) fn corners(domain: Domain<2>, p: [f64; 2]) -> impl Iterator<Item = ([u32; 2], f64)> {
    let along = |axis: usize| {
        let first = p[axis].floor();
        let by = p[axis] - first;
        // Whole numbers beyond those of i64 are their ends: where motion is not known it may be anywhere.
        [(domain.nearest(axis, first as i64), 1.0 - by), (domain.nearest(axis, (first as i64).saturating_add(1)), by)]
    };
    let [rows, columns] = [along(0), along(1)];
    let each = move |(y, v): (u32, f64)| columns.into_iter().map(move |(x, w)| ([y, x], v * w));
    rows.into_iter().flat_map(each).filter(|(_, weight)| *weight != 0.0)
}

/// How much larger an area becomes under the vectors around a position.
fn determinant(flow: &Flow, p: [f64; 2]) -> Option<f64> {
    let along = |axis: usize| {
        let beside = |by: f64| {
            let mut at = p;
            at[axis] += by;
            vector(flow, at)
        };
        let (before, after) = (beside(-0.5)?, beside(0.5)?);
        Some([after[0] - before[0], after[1] - before[1]])
    };
    let [down, across] = [along(0)?, along(1)?];
    Some((1.0 + down[0]) * (1.0 + across[1]) - down[1] * across[0])
}

/// Around periodic axes, and whether it is within open ones.
fn inside(domain: Domain<2>, at: [f64; 2]) -> ([f64; 2], bool) {
    let mut is_inside = true;
    let along = |axis: usize| {
        let (p, n) = (at[axis], f64::from(domain.shape[axis]));
        if domain.periodic[axis] {
            let around = p - (p / n).floor() * n;
            // A tiny step below 0 is rounded to n.
            return if around < n { around } else { 0.0 };
        }
        // Half a sample beyond the outer ones is theirs.
        is_inside &= -0.5 <= p && p < n - 0.5;
        p
    };
    ([0, 1].map(along), is_inside)
}

impl Origin {
    /// The sample of the frame before that is nearest to it, and how far it is from that: beyond open edges more than a
    /// half.
    pub(super) fn nearest(&self, domain: Domain<2>) -> ([u32; 2], [f64; 2]) {
        let along = |axis: usize| {
            let (near, n) = ((self.at[axis] + 0.5).floor(), f64::from(domain.shape[axis]));
            let near = if domain.periodic[axis] { near } else { near.clamp(0.0, n - 1.0) };
            ((near as u32) % domain.shape[axis], self.at[axis] - near)
        };
        let [(y, down), (x, across)] = [along(0), along(1)];
        ([y, x], [down, across])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::{Field, Motion};
    use selvedge_core::{Grid, Seed};

    fn motion(field: Field, speed: f64) -> Motion {
        Motion { field, speed, center: None, angle: 30.0 }
    }

    #[test]
    fn what_is_carried_back_and_forth_is_where_it_was() {
        for (case, field) in (0..).zip(Field::ALL) {
            for periodic in [[false; 2], [true; 2]] {
                let domain = Domain { shape: [48, 57], periodic };
                let flow = motion(field, 1.5).flow(domain, Seed(case)).unwrap();
                let all = origins(&flow, Direction::Forward).unwrap();
                let sure = all.iter().filter(|origin| origin.is_sure).count();
                assert!(domain.len() * 8 / 10 < sure, "{field:?}: {sure}");
                for (q, origin) in domain.positions().zip(&all).filter(|(_, origin)| origin.is_sure) {
                    let there = plus(origin.at, vector(&flow, origin.at).unwrap());
                    for axis in 0..2 {
                        let n = f64::from(domain.shape[axis]);
                        let by = (there[axis] - f64::from(q[axis])).abs();
                        let by = if domain.periodic[axis] { by.min((by - n).abs()) } else { by };
                        assert!(by <= 0.1, "{field:?} {q:?}: {origin:?}, {there:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn whole_steps_are_exact_and_nothing_comes_from_beyond_an_edge() {
        let domain = Domain { shape: [9, 11], periodic: [false, true] };
        let by = Grid::from_vec(domain, 2, [vec![2.0; 99], vec![-3.0; 99]].concat()).unwrap();
        for (direction, sign) in [(Direction::Forward, 1.0), (Direction::Backward, -1.0)] {
            let flow = Flow { by: by.map(|v| sign * v).unwrap(), known: None };
            for (q, origin) in domain.positions().zip(origins(&flow, direction).unwrap()) {
                assert_eq!(origin.is_sure, 2 <= q[0]);
                let expected = [f64::from(q[0]) - 2.0, f64::from((q[1] + 3) % 11)];
                assert_eq!(origin.at, expected);
            }
        }
    }

    #[test]
    fn what_is_unknown_stays_and_is_not_sure() {
        let domain = Domain::open([5, 6]);
        let known = Grid::from_vec(domain, 1, (0..30).map(|i| i != 14).collect()).unwrap();
        let flow = Flow { by: Grid::try_filled(domain, 2, 0.0).unwrap(), known: Some(known) };
        let all = origins(&flow, Direction::Forward).unwrap();
        assert_eq!(all.iter().filter(|origin| !origin.is_sure).count(), 1);
        assert_eq!(all[14], Origin { at: [2.0, 2.0], is_sure: false });
    }

    #[test]
    fn what_grows_too_much_is_not_wished_for() {
        let domain = Domain::open([40, 40]);
        let all = origins(&motion(Field::Source, 3.0).flow(domain, Seed(0)).unwrap(), Direction::Forward).unwrap();
        assert!(!all[20 * 40 + 20].is_sure && all[3 * 40 + 20].is_sure);
    }
}
