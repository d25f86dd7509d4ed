//! Sources mirrored, turned by any angle and scaled: the only transforms that do not copy samples bit for bit.

use half::f16;

use crate::plane::Samples;
use crate::{Domain, Error, Grid, NormalCoding, Plane, Role, par, try_vec};

/// A mirror, a turn about the centre and a magnification, over the last two axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resampling {
    /// Cosine and sine of the clockwise angle.
    cos: f64,
    sin: f64,
    scale: f64,
    mirror: bool,
}

/// Where a sample comes from: a place between exemplar samples, on the last two axes.
struct Taps {
    first: [i64; 2],
    weights: [[f64; 4]; 2],
}

impl Resampling {
    pub(crate) fn new(degrees: f64, scale: f64, mirror: bool) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Self { cos, sin, scale, mirror }
    }

    /// The box around the turned and scaled exemplar. Only axes that stay as they are keep their period.
    pub(crate) fn domain<const D: usize>(&self, mut exemplar: Domain<D>) -> Domain<D> {
        let [h, w] = [D - 2, D - 1].map(|a| f64::from(exemplar.shape[a]) * self.scale);
        let (cos, sin) = (self.cos.abs(), self.sin.abs());
        // The rounding errors of sines must not add a sample.
        let side = |v: f64| ((v - 1e-6).ceil() as u32).max(1);
        (exemplar.shape[D - 2], exemplar.shape[D - 1]) = (side(h * cos + w * sin), side(w * cos + h * sin));
        (exemplar.periodic[D - 2], exemplar.periodic[D - 1]) = (false, false);
        exemplar
    }

    /// The exemplar's place under a place of the source, both in samples with the first at 0.
    fn place(&self, exemplar: [u32; 2], source: [u32; 2], at: [f64; 2]) -> [f64; 2] {
        let centre = |shape: [u32; 2]| shape.map(|n| (f64::from(n) - 1.0) / 2.0);
        let (to, from) = (centre(exemplar), centre(source));
        let [y, x] = self.undo([at[0] - from[0], at[1] - from[1]]);
        [to[0] + y, to[1] + x]
    }

    /// Where a place of the source lies in the exemplar, both from their centres.
    pub(crate) fn undo(&self, at: [f64; 2]) -> [f64; 2] {
        let (y, x) = (at[0] / self.scale, at[1] / self.scale);
        // Undoing a clockwise turn of a picture whose y axis points down.
        let across = x * self.cos + y * self.sin;
        [y * self.cos - x * self.sin, if self.mirror { -across } else { across }]
    }

    /// Places averaged to one sample along an axis: more where the exemplar shrinks.
    fn spots(&self) -> u32 {
        ((1.0 / self.scale).ceil() as u32).clamp(1, 16)
    }

    /// Calls `f` with the taps of each spot of a sample.
    fn each_spot(&self, exemplar: [u32; 2], source: [u32; 2], at: [u32; 2], mut f: impl FnMut(&Taps)) {
        let n = self.spots();
        let inside = |spot: u32| (f64::from(spot) + 0.5) / f64::from(n) - 0.5;
        for spot in 0..n * n {
            let at = [f64::from(at[0]) + inside(spot / n), f64::from(at[1]) + inside(spot % n)];
            f(&Taps::at(self.place(exemplar, source, at)));
        }
    }
}

impl Taps {
    /// Catmull and Rom's cubic through four samples an axis.
    fn at(place: [f64; 2]) -> Self {
        let mut taps = Self { first: [0; 2], weights: [[0.0; 4]; 2] };
        for (axis, p) in place.into_iter().enumerate() {
            let floor = p.floor();
            let t = p - floor;
            taps.first[axis] = floor as i64 - 1;
            taps.weights[axis] = [
                0.5 * t * (t * (2.0 - t) - 1.0),
                0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
                0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
                0.5 * t * t * (t - 1.0),
            ];
        }
        taps
    }

    /// The place along an axis of a tap, moved inside.
    fn along(&self, axis: usize, tap: usize, side: u32) -> usize {
        (self.first[axis] + tap as i64).clamp(0, i64::from(side) - 1) as usize
    }

    /// The value between the samples; never beyond the four around it, so that edges do not ring.
    fn value(&self, shape: [u32; 2], sample: impl Fn(usize) -> f64) -> f64 {
        let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
        for ty in 0..4 {
            for tx in 0..4 {
                let v = sample(self.along(0, ty, shape[0]) * shape[1] as usize + self.along(1, tx, shape[1]));
                sum += v * self.weights[0][ty] * self.weights[1][tx];
                if (1..3).contains(&ty) && (1..3).contains(&tx) {
                    (low, high) = (low.min(v), high.max(v));
                }
            }
        }
        sum.clamp(low, high)
    }

    /// True if the samples around the place exist and are valid; outside of it, only weights that are not 0 count.
    fn is_valid(&self, shape: [u32; 2], valid: impl Fn(usize) -> bool) -> bool {
        (1..3).all(|ty| {
            (1..3).all(|tx| {
                let needed = self.weights[0][ty].abs() * self.weights[1][tx].abs() > 1e-9;
                let at = [self.first[0] + ty as i64, self.first[1] + tx as i64];
                let inside = (0..2).all(|a| 0 <= at[a] && at[a] < i64::from(shape[a]));
                !needed || inside && valid(at[0] as usize * shape[1] as usize + at[1] as usize)
            })
        })
    }
}

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

/// Turns the first two components (x right, y up; with `sin` negated, y down) about their zero, and makes normals with a third one as long as they
/// were: interpolation shortens them.
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
