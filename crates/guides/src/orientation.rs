//! Local orientation by the structure tensor.

use selvedge_core::{Domain, Grid, collected, reserve};

use crate::Error;
use crate::gaussian::{Gaussian, neighbor};

/// Added to the gradients' energy: gradients of about 2 grey levels a sample are as good as none.
const FLAT: f64 = 4.0;

/// Local orientation of the first channel: `cos 2t` and `sin 2t` times the coherence, where `t` is the angle of the
/// structure tensor's first eigenvector; -1..1 as 0..255. Lines in one direction look the same either way along, and
/// flat or cluttered places are near 128.
///
/// The gradients, by central differences, are averaged by a Gaussian of standard deviation `sigma` in samples.
///
/// # Errors
/// [`Error::Blur`], and [`Error::Core`] if memory is short.
pub fn orientation(map: &Grid<u8, 2>, sigma: f64) -> Result<Grid<u8, 2>, Error> {
    let (domain, gaussian) = (map.domain(), Gaussian::new(sigma)?);
    let mut gradients: Vec<[f64; 2]> = Vec::new();
    reserve(&mut gradients, domain.len())?;
    gradients.extend(domain.positions().map(|at| gradient(map, domain, at)));
    let smooth = |of: fn(&[f64; 2]) -> f64| gaussian.smooth(domain, &collected(gradients.iter().map(of))?);
    // With the tensor's eigenvalues a >= b, xx - yy = (a - b) cos 2t and 2 xy = (a - b) sin 2t; the coherence is
    // (a - b) / (a + b), so no angle is needed.
    let energy = smooth(|[x, y]| x * x + y * y)?;
    let parts = [smooth(|[x, y]| x * x - y * y)?, smooth(|[x, y]| 2.0 * x * y)?];
    let mut out = Grid::try_filled(domain, 2, 0)?;
    for (c, part) in parts.iter().enumerate() {
        for (to, (part, energy)) in out.plane_mut(c).iter_mut().zip(part.iter().zip(&energy)) {
            *to = (127.5 + 127.5 * part / (energy + FLAT) + 0.5) as u8;
        }
    }
    Ok(out)
}

/// Grey levels a sample along x and y.
fn gradient(map: &Grid<u8, 2>, domain: Domain<2>, [y, x]: [u32; 2]) -> [f64; 2] {
    let value = |dy: isize, dx: isize| {
        let row = neighbor(y as usize, dy, domain.shape[0] as usize, domain.periodic[0]);
        let column = neighbor(x as usize, dx, domain.shape[1] as usize, domain.periodic[1]);
        f64::from(map.get(0, [row as u32, column as u32]))
    };
    [(value(0, 1) - value(0, -1)) / 2.0, (value(1, 0) - value(-1, 0)) / 2.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orientation in the middle of stripes whose phase is `(a y + b x) / 4` turns.
    fn of_stripes(a: u32, b: u32) -> [u8; 2] {
        let domain = Domain::open([32, 32]);
        let value = |[y, x]: [u32; 2]| [40, 120, 200, 120][((a * y + b * x) % 4) as usize];
        let map = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let out = orientation(&map, 2.0).unwrap();
        [0, 1].map(|c| out.get(c, [16, 16]))
    }

    #[test]
    fn stripes_have_the_orientation_of_their_gradient() {
        let near = |found: [u8; 2], expected: [u8; 2]| {
            assert!(found.iter().zip(expected).all(|(f, e)| f.abs_diff(e) <= 1), "{found:?} {expected:?}");
        };
        near(of_stripes(0, 1), [255, 128]);
        near(of_stripes(1, 0), [0, 128]);
        near(of_stripes(1, 1), [128, 255]);
        near(of_stripes(3, 1), [128, 0]);
    }

    #[test]
    fn slopes_of_two_grey_levels_count_half() {
        for (slope, expected) in [(1, 153), (2, 191), (4, 230)] {
            let domain = Domain::open([32, 32]);
            let map = Grid::from_vec(domain, 1, domain.positions().map(|[_, x]| (x * slope) as u8).collect()).unwrap();
            let out = orientation(&map, 2.0).unwrap();
            assert_eq!([0, 1].map(|c| out.get(c, [16, 16])), [expected, 128], "{slope}");
        }
    }

    #[test]
    fn flat_places_have_none() {
        let map = Grid::try_filled(Domain::open([1, 9]), 1, 200_u8).unwrap();
        assert!(orientation(&map, 3.0).unwrap().samples().iter().all(|&v| v == 128));
    }
}
