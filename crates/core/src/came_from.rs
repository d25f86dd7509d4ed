//! Where the samples of a frame come from in the frame before. `[Kwatra05 4.1]`

use crate::{Domain, Error, Flow, par, try_vec};

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
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// Where a sample of a frame was in the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameFrom {
    /// Between samples of the frame before, or beyond its open edges; where that is unknown, where it is.
    pub at: [f64; 2],
    /// Whether something was there that moved here: not from beyond an edge, nor stretched, nor unknown.
    pub is_sure: bool,
}

impl Flow {
    /// Where each sample of the next frame was.
    ///
    /// Time `O(samples)`, in the caller's pool.
    ///
    /// # Errors
    /// No memory.
    pub fn came_from(&self, direction: Direction) -> Result<Vec<CameFrom>, Error> {
        let domain = self.domain();
        let mut all = try_vec(domain.len(), CameFrom { at: [0.0; 2], is_sure: false })?;
        par::for_rows(&mut all, domain.shape[1].max(1) as usize, |y, row| {
            row.iter_mut().zip(0..).for_each(|(one, x)| *one = came_from(self, direction, [y as u32, x]));
        });
        Ok(all)
    }

    /// The flow between samples; `None` where it is unknown. Beyond open edges that of the edge.
    ///
    /// # Panics
    /// If the flow has no sample.
    pub fn between(&self, p: [f64; 2]) -> Option<[f64; 2]> {
        let mut sum = [0.0; 2];
        for (at, weight) in self.domain().corners(p) {
            if !self.is_known(at) {
                return None;
            }
            (0..2).for_each(|c| sum[c] += weight * f64::from(self.by.get(c, at)));
        }
        Some(sum)
    }
}

fn came_from(flow: &Flow, direction: Direction, q: [u32; 2]) -> CameFrom {
    let domain = flow.domain();
    let here = q.map(f64::from);
    let (at, is_sure) = match direction {
        Direction::Forward => inverse(flow, here).unwrap_or((here, false)),
        Direction::Backward => {
            flow.between(here).map_or((here, false), |by| ([here[0] + by[0], here[1] + by[1]], true))
        }
    };
    // Of a backward field the area that a sample came from.
    let area = determinant(flow, if direction == Direction::Forward { at } else { here }).unwrap_or(1.0);
    let grown = if direction == Direction::Forward { area } else { 1.0 / area };
    let (at, is_inside) = inside(domain, at);
    CameFrom { at, is_sure: is_sure && is_inside && 0.0 < grown && grown <= GROWTH }
}

/// The position from which a forward field leads to `q`, by `p = q - u(p)`, and whether it does.
fn inverse(flow: &Flow, q: [f64; 2]) -> Option<([f64; 2], bool)> {
    let (mut p, mut missed) = (q, f64::INFINITY);
    for _ in 0..STEPS {
        let by = flow.between(p)?;
        let next = [q[0] - by[0], q[1] - by[1]];
        missed = (next[0] - p[0]).abs().max((next[1] - p[1]).abs());
        p = next;
        if missed == 0.0 {
            break;
        }
    }
    Some((p, missed <= MISSED))
}

impl Domain<2> {
    /// The samples around a position that have a part in it, and how much: around periodic axes, none beyond open ones.
    ///
    /// # Panics
    /// If the domain has no sample.
    pub fn corners(self, p: [f64; 2]) -> impl Iterator<Item = ([u32; 2], f64)> {
        let along = |axis: usize| {
            let first = p[axis].floor();
            let by = p[axis] - first;
            // Whole numbers beyond those of i64 are their ends: where motion is not known it may be anywhere.
            [(self.nearest(axis, first as i64), 1.0 - by), (self.nearest(axis, (first as i64).saturating_add(1)), by)]
        };
        let [rows, columns] = [along(0), along(1)];
        let each = move |(y, v): (u32, f64)| columns.into_iter().map(move |(x, w)| ([y, x], v * w));
        rows.into_iter().flat_map(each).filter(|(_, weight)| *weight != 0.0)
    }
}

/// How much larger an area becomes under the vectors around a position.
fn determinant(flow: &Flow, p: [f64; 2]) -> Option<f64> {
    let along = |axis: usize| {
        let beside = |by: f64| {
            let mut at = p;
            at[axis] += by;
            flow.between(at)
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

impl CameFrom {
    /// The sample of the frame before that is nearest to it, and how far it is from that: beyond open edges more than a
    /// half.
    ///
    /// # Panics
    /// If the domain has no sample.
    pub fn nearest(&self, domain: Domain<2>) -> ([u32; 2], [f64; 2]) {
        let along = |axis: usize| {
            let (near, n) = ((self.at[axis] + 0.5).floor(), f64::from(domain.shape[axis]));
            let near = if domain.periodic[axis] { near } else { near.clamp(0.0, n - 1.0) };
            // A place before the first sample of a periodic axis is one of its last.
            (near.rem_euclid(n) as u32, self.at[axis] - near)
        };
        let [(y, down), (x, across)] = [along(0), along(1)];
        ([y, x], [down, across])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_around_a_periodic_axis_are_its_samples() {
        let domain = Domain { shape: [11, 8], periodic: [true, false] };
        let nearest = |at| CameFrom { at, is_sure: true }.nearest(domain);
        assert_eq!(nearest([-3.0, 2.0]), ([8, 2], [0.0, 0.0]));
        assert_eq!(nearest([-0.25, 9.5]), ([0, 7], [-0.25, 2.5]));
        assert_eq!(nearest([10.75, 7.25]), ([0, 7], [-0.25, 0.25]));
        assert_eq!(nearest([24.0, -1.0]), ([2, 0], [0.0, -1.0]));
    }
}
