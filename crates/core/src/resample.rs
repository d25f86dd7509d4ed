//! Sources mirrored, turned by any angle and scaled: the only transforms that do not copy samples bit for bit.

use half::f16;

use crate::plane::Samples;
use crate::resampling::Resampling;
use crate::{Domain, Error, Grid, NormalCoding, Plane, Role, par, try_vec};

fn last_two<const D: usize>(domain: Domain<D>) -> [u32; 2] {
    [domain.shape[D - 2], domain.shape[D - 1]]
}

/// Resamples each channel of each frame; `read` and `write` are to and from numbers.
pub(crate) fn resample<T: Copy + Send + Sync, const D: usize>(
    grid: &Grid<T, D>,
    resampling: Resampling,
    read: impl Fn(T) -> f64 + Sync,
    write: impl Fn(f64) -> T + Sync,
) -> Result<Grid<T, D>, Error> {
    let domain = resampling.domain(grid.domain());
    let (from, to) = (last_two(grid.domain()), last_two(domain));
    let frame = (from[0] * from[1]) as usize;
    let Some(&first) = grid.samples().first() else { return Grid::from_vec(domain, grid.channels(), Vec::new()) };
    let mut samples = try_vec(domain.len() * grid.channels(), first)?;
    let spots = f64::from(resampling.spots().pow(2));
    par::for_rows(&mut samples, to[1] as usize, |row, samples| {
        let pixels = &grid.samples()[row / to[0] as usize * frame..][..frame];
        for (x, sample) in (0..).zip(samples) {
            let mut sum = 0.0;
            let at = [row as u32 % to[0], x];
            resampling.each_spot(from, to, at, |taps| sum += taps.value(from, |i| read(pixels[i])));
            *sample = write(sum / spots);
        }
    });
    Grid::from_vec(domain, grid.channels(), samples)
}

/// Where a resampled source stands wholly on valid samples.
pub(crate) fn validity<const D: usize>(
    exemplar: Domain<D>,
    valid: Option<&Grid<bool, D>>,
    resampling: Resampling,
) -> Result<Grid<bool, D>, Error> {
    let domain = resampling.domain(exemplar);
    let (from, to) = (last_two(exemplar), last_two(domain));
    let frame = (from[0] * from[1]) as usize;
    let mut all = try_vec(domain.len(), true)?;
    par::for_rows(&mut all, to[1] as usize, |row, all| {
        let first = row / to[0] as usize * frame;
        for (x, is_valid) in (0..).zip(all) {
            resampling.each_spot(from, to, [row as u32 % to[0], x], |taps| {
                *is_valid &= taps.is_valid(from, |j| valid.is_none_or(|v| v.samples()[first + j]));
            });
        }
    });
    Grid::from_vec(domain, 1, all)
}

/// A plane as a resampled source shows it; normals are turned with it and keep their length.
pub(crate) fn plane<const D: usize>(
    plane: &Plane<D>,
    resampling: Resampling,
    normals: NormalCoding,
) -> Result<Plane<D>, Error> {
    let integer = |v: f64, most: f64| (v + 0.5).clamp(0.0, most);
    let turned = plane.role.is_normal() && 2 <= plane.color_channels();
    // Where y points down, the other way round.
    let vectors =
        Resampling { sin: if plane.role == Role::NormalDown { -resampling.sin } else { resampling.sin }, ..resampling };
    macro_rules! shown {
        ($depth:ident, $grid:expr, $read:expr, $write:expr) => {{
            let mut grid = resample($grid, resampling, $read, $write)?;
            if turned {
                turn(&mut grid, 3 <= plane.color_channels(), vectors, normals, $read, $write);
            }
            Samples::$depth(grid)
        }};
    }
    let samples = match &plane.samples {
        Samples::U8(g) => shown!(U8, g, f64::from, |v| integer(v, 255.0) as u8),
        Samples::U16(g) => shown!(U16, g, f64::from, |v| integer(v, 65_535.0) as u16),
        Samples::F16(g) => {
            shown!(F16, g, |v| f16::from_bits(v).to_f64(), |v| f16::from_f32(v as f32).to_bits())
        }
        Samples::F32(g) => shown!(F32, g, f64::from, |v| v as f32),
    };
    Ok(Plane { role: plane.role, samples, alpha: plane.alpha, association: plane.association })
}

/// Turns the first two components (x right, y up; with `sin` negated, y down) about their zero, and makes normals with
/// a third one as long as they were: interpolation shortens them.
fn turn<T: Copy, const D: usize>(
    grid: &mut Grid<T, D>,
    has_z: bool,
    resampling: Resampling,
    normals: NormalCoding,
    read: impl Fn(T) -> f64,
    write: impl Fn(f64) -> T,
) {
    let Resampling { cos, sin, mirror, .. } = resampling;
    for i in 0..grid.domain().len() {
        let (x, y) = (read(grid.plane(0)[i]) - normals.zero, read(grid.plane(1)[i]) - normals.zero);
        let x = if mirror { -x } else { x };
        let (x, y) = (x * cos + y * sin + normals.zero, y * cos - x * sin + normals.zero);
        let stored = if has_z { normals.unit_length([x, y, read(grid.plane(2)[i])]) } else { [x, y, 0.0] };
        for (c, &v) in stored.iter().enumerate().take(if has_z { 3 } else { 2 }) {
            grid.plane_mut(c)[i] = write(v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transform;

    fn ramp(shape: [u32; 2]) -> Grid<f32, 2> {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| (10 * y + x) as f32).collect();
        Grid::from_vec(domain, 1, samples).unwrap()
    }

    fn resampled(grid: &Grid<f32, 2>, degrees: f64, scale: f64) -> Grid<f32, 2> {
        resample(grid, Resampling::new(degrees, scale, false), f64::from, |v| v as f32).unwrap()
    }

    #[test]
    fn quarter_turns_agree_with_the_exact_ones() {
        let grid = ramp([3, 5]);
        let exact = Transform::Exact { quarter_turns: 1, mirror: false };
        let turned = resampled(&grid, 90.0, 1.0);
        assert_eq!(turned.domain(), exact.domain(grid.domain()));
        for at in turned.domain().positions() {
            let expected = grid.get(0, exact.origin(turned.domain(), at));
            assert!((turned.get(0, at) - expected).abs() < 1e-4, "{at:?}");
        }
        let valid = validity(grid.domain(), None, Resampling::new(90.0, 1.0, false)).unwrap();
        assert!(valid.samples().iter().all(|&v| v));
    }

    #[test]
    fn ramps_stay_ramps_under_scale() {
        let double = resampled(&ramp([6, 8]), 0.0, 2.0);
        assert_eq!(double.domain().shape, [12, 16]);
        // Inside, neighbours differ by half the step.
        let step = double.get(0, [6, 8]) - double.get(0, [6, 7]);
        assert!((step - 0.5).abs() < 1e-5, "{step}");
        let half = resampled(&ramp([6, 8]), 0.0, 0.5);
        assert_eq!(half.domain().shape, [3, 4]);
        // The mean of the four samples under it: 22, 23, 32, 33.
        assert!((half.get(0, [1, 1]) - 27.5).abs() < 1e-4);
    }

    #[test]
    fn corners_outside_of_the_exemplar_are_not_valid() {
        let resampling = Resampling::new(45.0, 1.0, false);
        let valid = validity(Domain::open([20, 20]), None, resampling).unwrap();
        let [h, w] = valid.domain().shape;
        assert_eq!([h, w], [29, 29]);
        assert!(!valid.get(0, [0, 0]) && valid.get(0, [h / 2, w / 2]));
        let inside = valid.samples().iter().filter(|&&v| v).count();
        assert!((330..=400).contains(&inside), "{inside} of about 19 * 19");
    }

    #[test]
    fn mirrored_and_quarter_turned_is_as_exact_as_it_can_be() {
        let grid = ramp([3, 5]);
        let exact = Transform::Exact { quarter_turns: 1, mirror: true };
        let turned = resample(&grid, Resampling::new(90.0, 1.0, true), f64::from, |v| v as f32).unwrap();
        for at in turned.domain().positions() {
            let expected = grid.get(0, exact.origin(turned.domain(), at));
            assert!((turned.get(0, at) - expected).abs() < 1e-4, "{at:?}");
        }
    }

    #[test]
    fn only_axes_that_stay_as_they_are_keep_their_period() {
        let domain = Resampling::new(0.0, 2.0, false).domain(Domain::periodic([5, 8, 6]));
        assert_eq!(domain, Domain { shape: [5, 16, 12], periodic: [true, false, false] });
    }

    /// One normal, shown by a resampled source.
    fn normal(stored: [f32; 3], resampling: Resampling) -> Vec<f32> {
        shown(Role::Normal, stored, resampling)
    }

    fn shown(role: Role, stored: [f32; 3], resampling: Resampling) -> Vec<f32> {
        let grid = Grid::from_vec(Domain::open([1, 1]), 3, stored.to_vec()).unwrap();
        let normals = Plane::new(role, Samples::F32(grid));
        let coding = NormalCoding::of(&[&normals]);
        let Samples::F32(out) = plane(&normals, resampling, coding).unwrap().samples else { panic!("depth") };
        out.into_vec()
    }

    #[test]
    fn normals_turn_with_the_picture() {
        let close = |found: Vec<f32>, expected: [f32; 3]| {
            assert!(found.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-6), "{found:?}, not {expected:?}");
        };
        // Clockwise: x takes y, y takes -x.
        close(normal([-0.36, 0.48, 0.8], Resampling::new(90.0, 1.0, false)), [0.48, 0.36, 0.8]);
        close(normal([-0.36, 0.48, 0.8], Resampling::new(90.0, 1.0, true)), [0.48, -0.36, 0.8]);
        close(normal([-0.36, 0.0, 0.48], Resampling::new(0.0, 1.0, false)), [-0.6, 0.0, 0.8]);
        // With y down: upside down before and after.
        for (degrees, mirror) in [(90.0, false), (90.0, true), (270.0, true)] {
            let resampling = Resampling::new(degrees, 1.0, mirror);
            let down = shown(Role::NormalDown, [-0.36, -0.48, 0.8], resampling);
            close(normal([-0.36, 0.48, 0.8], resampling), [down[0], -down[1], down[2]]);
        }
    }
}
