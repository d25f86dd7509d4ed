//! Where a seam is in reach.

use selvedge_core::{Domain, Error, SourceMap, par, try_vec};

/// Positions that one task looks at: enough that starting it costs nothing beside them.
const TOGETHER: usize = 1 << 14;

/// Positions from which a seam is within reach along every axis; none for a reach of 0.
///
/// Time `O(positions)`, whatever the reach.
pub(crate) fn near_seams<const D: usize>(map: &SourceMap<D>, reach: u32) -> Result<Vec<bool>, Error> {
    let domain = map.domain();
    let mut near = try_vec(domain.len(), false)?;
    if reach == 0 {
        return Ok(near);
    }
    // By position a bit for each axis along which a seam parts it from the next one.
    let mut seams = try_vec(domain.len(), 0_u8)?;
    par::for_rows(&mut seams, TOGETHER, |part, seams| {
        for (i, seams) in (part * TOGETHER..).zip(seams) {
            let at = domain.position(i);
            *seams = (0..D).filter(|&axis| map.is_seam(at, axis)).fold(0, |bits, axis| bits | 1 << axis);
        }
    });
    for (i, seams) in seams.into_iter().enumerate().filter(|s| s.1 != 0) {
        near[i] = true;
        for axis in (0..D).filter(|&axis| seams & 1 << axis != 0) {
            if let Some(next) = domain.next(domain.position(i), axis) {
                near[domain.index(next)] = true;
            }
        }
    }
    (0..D).for_each(|axis| widen(&mut near, domain, axis, reach as usize));
    Ok(near)
}

/// Marks everything within reach of a mark along an axis.
fn widen<const D: usize>(near: &mut [bool], domain: Domain<D>, axis: usize, reach: usize) {
    let (side, stride) = (domain.shape[axis] as usize, domain.strides()[axis]);
    let mut line = vec![false; side];
    // Around a periodic axis a mark may lie behind the start.
    let rounds = if domain.periodic[axis] { 2 } else { 1 };
    for first in (0..near.len()).filter(|i| i / stride % side == 0) {
        (0..side).for_each(|p| line[p] = near[first + p * stride]);
        for forward in [true, false] {
            let mut since = usize::MAX;
            for step in 0..rounds * side {
                let p = if forward { step % side } else { side - 1 - step % side };
                since = if line[p] { 0 } else { since.saturating_add(1) };
                near[first + p * stride] |= since <= reach;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn marks_are_widened_as_by_the_definition() {
        let mut rng = Seed(1).rng();
        for round in 0..200 {
            let shape = [1 + rng.below(7), 1 + rng.below(9)];
            let domain = Domain { shape, periodic: [round % 2 == 0, round % 3 == 0] };
            let marks: Vec<bool> = (0..domain.len()).map(|_| rng.below(9) == 0).collect();
            let reach = 1 + rng.below(11) as i32;
            for axis in 0..2 {
                let mut fast = marks.clone();
                widen(&mut fast, domain, axis, reach as usize);
                let marked = |at: [u32; 2], d: i32| {
                    let by = std::array::from_fn(|a| if a == axis { d } else { 0 });
                    domain.step(at, by).is_some_and(|to| marks[domain.index(to)])
                };
                let slow: Vec<bool> = domain.positions().map(|at| (-reach..=reach).any(|d| marked(at, d))).collect();
                assert_eq!(fast, slow, "{domain:?} {axis} {reach}");
            }
        }
    }
}
