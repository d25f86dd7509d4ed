//! What lies around a sample, and what it counts.

/// Neighborhoods reach so far on each side: 7 by 7 samples, as in the paper.
pub(crate) const REACH: i32 = 3;
/// What the difference at a neighbour counts, by the squared distance: near `48 / (1 + d^2)`, so that the eight next
/// neighbours count about as much as all others together.
pub(crate) const FALL_OFF: [u64; 19] = [0, 24, 16, 0, 10, 8, 0, 0, 5, 5, 4, 0, 0, 3, 0, 0, 0, 0, 3];
/// Where neighbours are, the nearest first, since they tell soonest that a candidate is worse than another; of equally
/// near ones in raster order.
pub(crate) const AROUND: [[i32; 2]; NEIGHBORS] = nearest_first();
pub(crate) const NEIGHBORS: usize = ((2 * REACH + 1) * (2 * REACH + 1) - 1) as usize;

const fn nearest_first() -> [[i32; 2]; NEIGHBORS] {
    let (mut around, mut found, mut distance) = ([[0; 2]; NEIGHBORS], 0, 1);
    while found < NEIGHBORS {
        let mut i = 0;
        while i < (2 * REACH + 1) * (2 * REACH + 1) {
            let by = [i / (2 * REACH + 1) - REACH, i % (2 * REACH + 1) - REACH];
            if by[0] * by[0] + by[1] * by[1] == distance {
                around[found] = by;
                found += 1;
            }
            i += 1;
        }
        distance += 1;
    }
    around
}

/// True if a position's whole neighborhood lies within a shape.
pub(crate) fn is_inside(at: [u32; 2], shape: [u32; 2]) -> bool {
    (0..2).all(|a| REACH as u32 <= at[a] && at[a] + (REACH as u32) < shape[a])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_around_come_once_and_the_nearest_first() {
        let distance = |[y, x]: [i32; 2]| y * y + x * x;
        assert!(AROUND.is_sorted_by_key(|&by| (distance(by), by)));
        assert!((-REACH..=REACH).all(|y| (-REACH..=REACH).all(|x| (y, x) == (0, 0) || AROUND.contains(&[y, x]))));
    }

    #[test]
    fn fall_off_is_near_its_formula() {
        for (y, x) in (0..=REACH).flat_map(|y| (0..=REACH).map(move |x| (y, x))).filter(|p| *p != (0, 0)) {
            let d = y * y + x * x;
            let formula = 48.0 / f64::from(1 + d);
            assert!((FALL_OFF[d as usize] as f64 - formula).abs() <= 0.6, "{d} {formula}");
        }
    }
}
