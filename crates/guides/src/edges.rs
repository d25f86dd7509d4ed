//! How far away the nearest edge is.

use selvedge_core::{Domain, Error as CoreError, Grid, par};

use crate::Error;

/// A sample is on an edge if the square of its gradient is so many times the mean of all: what edge detectors that
/// choose by themselves take.
const STRONG: u64 = 4;

/// And no less than this, in half grey levels a sample: what is flat but for noise has no edges.
const LEAST: u64 = 16 * 16;

/// Distance to the nearest edge of the first channel: 0 on edges, 255 from `most` samples on (1 to 255). Without any
/// edge all is far away. So shapes are told from their middles, and strokes along outlines from those across.
///
/// An edge is where central differences are strong for the map. Periodic axes wrap.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for `most`, and [`Error::Core`] if memory is short.
///
/// # Complexity
/// `O(samples most)`.
pub fn edge_distance(map: &Grid<u8, 2>, most: u32) -> Result<Grid<u8, 2>, Error> {
    CoreError::within("most", most, 1.0..=255.0, "1 to 255")?;
    let (domain, wide) = (map.domain(), map.domain().shape[1].max(1) as usize);
    let edges = edges(map)?;
    // Squares of distances along columns, then the least of their sums with those along rows.
    let mut along = Grid::try_filled(domain, 1, 0_u32)?;
    let far = most * most;
    let nearest = |at: [u32; 2], axis: usize, of: &dyn Fn([u32; 2]) -> u32| {
        let steps = -(most as i32)..=most as i32;
        let squares = steps.filter_map(|by| {
            let to = domain.step(at, std::array::from_fn(|a| if a == axis { by } else { 0 }))?;
            Some(of(to).saturating_add(by.unsigned_abs().pow(2)))
        });
        squares.min().unwrap_or(far).min(far)
    };
    let on_edge = |at: [u32; 2]| if edges.get(0, at) { 0 } else { far };
    par::for_rows(along.plane_mut(0), wide, |y, row| {
        row.iter_mut().enumerate().for_each(|(x, to)| *to = nearest([y as u32, x as u32], 0, &on_edge));
    });
    let mut out = Grid::try_filled(domain, 1, 0_u8)?;
    par::for_rows(out.plane_mut(0), wide, |y, row| {
        let of = |at: [u32; 2]| along.get(0, at);
        for (x, to) in row.iter_mut().enumerate() {
            let square = nearest([y as u32, x as u32], 1, &of);
            *to = (255.0 * f64::from(square).sqrt() / f64::from(most) + 0.5) as u8;
        }
    });
    Ok(out)
}

/// Where samples are on an edge.
fn edges(map: &Grid<u8, 2>) -> Result<Grid<bool, 2>, Error> {
    let domain = map.domain();
    let square = |at: [u32; 2]| {
        let value = |by: [i32; 2]| i64::from(map.get(0, domain.step(at, by).unwrap_or(at)));
        let [y, x] = [value([1, 0]) - value([-1, 0]), value([0, 1]) - value([0, -1])];
        (y * y + x * x) as u64
    };
    let sum: u64 = domain.positions().map(square).sum();
    let least = (STRONG * sum / domain.len().max(1) as u64).max(LEAST);
    let mut out = Grid::try_filled(domain, 1, false)?;
    out.plane_mut(0).iter_mut().zip(domain.positions()).for_each(|(to, at)| *to = least <= square(at));
    Ok(out)
}

/// Where in its picture each sample is: from 0 to 255 along either axis.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn position(domain: Domain<2>) -> Result<Grid<u8, 2>, Error> {
    let mut out = Grid::try_filled(domain, 2, 0_u8)?;
    for axis in 0..2 {
        let last = u64::from(domain.shape[axis].saturating_sub(1).max(1));
        let along = |at: [u32; 2]| ((510 * u64::from(at[axis]) + last) / (2 * last)) as u8;
        out.plane_mut(axis).iter_mut().zip(domain.positions()).for_each(|(to, at)| *to = along(at));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bright square on dark ground.
    fn square(periodic: [bool; 2]) -> Grid<u8, 2> {
        let domain = Domain { shape: [24, 30], periodic };
        let value = |[y, x]: [u32; 2]| if (8..16).contains(&y) && (6..14).contains(&x) { 200 } else { 20 };
        Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap()
    }

    #[test]
    fn distances_are_those_of_the_definition_and_wrap() {
        for periodic in [[false; 2], [true, false], [true, true]] {
            let map = square(periodic);
            let (domain, edges, most) = (map.domain(), edges(&map).unwrap(), 9);
            let found = edge_distance(&map, most).unwrap();
            for at in domain.positions() {
                let apart = |to: [u32; 2], a: usize| {
                    let d = at[a].abs_diff(to[a]);
                    if periodic[a] { d.min(domain.shape[a] - d) } else { d }
                };
                let on = domain.positions().filter(|&to| edges.get(0, to));
                let least = on.map(|to| apart(to, 0).pow(2) + apart(to, 1).pow(2)).min().unwrap();
                let expected = 255.0 * f64::from(least).sqrt().min(f64::from(most)) / f64::from(most);
                assert!((f64::from(found.get(0, at)) - expected).abs() <= 0.5, "{at:?} {periodic:?}");
            }
            // On the square's side, in its middle, and far away.
            assert_eq!((found.get(0, [8, 10]), found.get(0, [11, 9])), (0, 85));
        }
        assert_eq!(edge_distance(&square([false; 2]), 9).unwrap().get(0, [23, 29]), 255);
    }

    #[test]
    fn what_is_flat_has_no_edges_and_a_cut_of_zero_is_refused() {
        let noise = Grid::from_vec(Domain::open([1, 6]), 1, vec![9, 12, 9, 12, 10, 9]).unwrap();
        assert_eq!(edge_distance(&noise, 4).unwrap().samples(), [255; 6]);
        assert!(matches!(edge_distance(&noise, 0), Err(Error::Core(CoreError::Range { option: "most", .. }))));
        assert!(edge_distance(&Grid::try_filled(Domain::open([0, 3]), 1, 0).unwrap(), 4).unwrap().samples().is_empty());
    }

    #[test]
    fn positions_go_from_side_to_side() {
        let map = position(Domain::open([3, 2])).unwrap();
        assert_eq!((map.plane(0), map.plane(1)), (&[0, 0, 128, 128, 255, 255][..], &[0, 255, 0, 255, 0, 255][..]));
        assert_eq!(position(Domain::open([1, 1])).unwrap().samples(), [0, 0]);
    }
}
