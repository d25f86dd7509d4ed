//! Flows that are built in. `[Kwatra05 fig. 6]`

use std::f64::consts::PI;

use selvedge_core::{Domain, Error, Flow, Grid, Seed};

/// Waves whose sum is the potential of curl noise: with fewer they show one by one, more average each other away.
const WAVES: u64 = 12;
/// Periods of the fastest wave over the shorter side: whirls stay larger than the texture. A guess.
const FASTEST: u32 = 3;
/// The part of the shorter side within which sinks and vortices are slower: without it their middles would tear.
const MIDDLE: f64 = 0.125;

/// A field's shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Towards the middle.
    Sink,
    /// Away from the middle.
    Source,
    /// Around the middle, clockwise.
    Vortex,
    /// Around the middle and towards it.
    Spiral,
    /// To the right below the middle, to the left above it, the faster the further.
    Shear,
    /// Everywhere the same way.
    Uniform,
    /// Eddies that neither begin nor end anywhere, drawn by the seed.
    CurlNoise,
}

impl Field {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Sink, Self::Source, Self::Vortex, Self::Spiral, Self::Shear, Self::Uniform, Self::CurlNoise];
}

/// A field and how it is laid over an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The field.
    pub field: Field,
    /// Samples a frame, where it is fastest.
    pub speed: f64,
    /// Row and column of its middle; `None` for that of the output.
    pub center: Option<[f64; 2]>,
    /// Degrees from the right, clockwise: where [`Field::Uniform`] goes.
    pub angle: f64,
}

impl Motion {
    /// The forward field over an output.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn flow(&self, domain: Domain<2>, seed: Seed) -> Result<Flow, Error> {
        let middle = self.center.unwrap_or_else(|| domain.shape.map(|n| f64::from(n.saturating_sub(1)) / 2.0));
        let least = f64::from(domain.shape[0].min(domain.shape[1]));
        let waves = if self.field == Field::CurlNoise { waves(domain, seed) } else { Vec::new() };
        // From a middle that is off the output's, or beyond its border, its far side is fastest.
        let [last, half] = [f64::from(domain.shape[0].saturating_sub(1)), f64::from(domain.shape[0]) / 2.0];
        let reach = half.max(middle[0].abs()).max((last - middle[0]).abs());
        let mut by = Grid::try_filled(domain, 2, 0.0)?;
        let mut fastest = 0.0_f64;
        for (i, at) in domain.positions().enumerate() {
            let from = [0, 1].map(|axis| f64::from(at[axis]) - middle[axis]);
            let slowed = MIDDLE * least;
            let far = (from[0] * from[0] + from[1] * from[1] + slowed * slowed).sqrt().max(1.0);
            let out = [from[0] / far, from[1] / far];
            let around = [out[1], -out[0]];
            let [y, x] = match self.field {
                Field::Sink => [-out[0], -out[1]],
                Field::Source => out,
                Field::Vortex => around,
                // Both are at right angles.
                Field::Spiral => [0, 1].map(|axis| (around[axis] - out[axis]) * std::f64::consts::FRAC_1_SQRT_2),
                Field::Shear => [0.0, from[0] / reach],
                Field::Uniform => {
                    let angle = self.angle * PI / 180.0;
                    [libm::sin(angle), libm::cos(angle)]
                }
                Field::CurlNoise => curl(&waves, at),
            };
            fastest = fastest.max((y * y + x * x).sqrt());
            let speed = self.speed;
            (by.plane_mut(0)[i], by.plane_mut(1)[i]) = ((speed * y) as f32, (speed * x) as f32);
        }
        if self.field == Field::CurlNoise && 0.0 < fastest {
            by.samples_mut().iter_mut().for_each(|v| *v = (f64::from(*v) / fastest) as f32);
        }
        Ok(Flow { by, known: None })
    }
}

/// A plane wave: angles a sample down and across, and where it begins.
struct Wave {
    by: [f64; 2],
    phase: f64,
}

/// Whole periods over the output, so that it closes around periodic axes.
fn waves(domain: Domain<2>, seed: Seed) -> Vec<Wave> {
    let one = |number: u64| {
        let mut rng = seed.derive("texture-optimization/curl-noise", number).rng();
        let mut periods = || i64::from(rng.below(2 * FASTEST + 1)) - i64::from(FASTEST);
        let periods = [periods(), periods()];
        let by = [0, 1].map(|axis| 2.0 * PI * periods[axis] as f64 / f64::from(domain.shape[axis].max(1)));
        Wave { by, phase: 2.0 * PI * f64::from(rng.below(1 << 16)) / f64::from(1 << 16) }
    };
    let still = |wave: &Wave| wave.by == [0.0; 2];
    (0..WAVES).map(one).filter(|wave| !still(wave)).collect()
}

/// The curl of the potential `sum of sin(by . at + phase) / |by|`: divergence is 0 by construction.
fn curl(waves: &[Wave], at: [u32; 2]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for Wave { by: [y, x], phase } in waves {
        let slope = libm::cos(y * f64::from(at[0]) + x * f64::from(at[1]) + phase) / (y * y + x * x).sqrt();
        (sum[0], sum[1]) = (sum[0] - x * slope, sum[1] + y * slope);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(field: Field, domain: Domain<2>) -> Grid<f32, 2> {
        Motion { field, speed: 2.0, center: None, angle: 90.0 }.flow(domain, Seed(3)).unwrap().by
    }

    #[test]
    fn fields_go_where_their_names_say_at_the_speed_asked_for() {
        let domain = Domain::open([65, 65]);
        let at = |field: Field, at: [u32; 2]| [0, 1].map(|c| of(field, domain).get(c, at));
        let right = [32, 60];
        assert!(at(Field::Sink, right)[1] < -1.8 && 1.8 < at(Field::Source, right)[1]);
        assert!(1.8 < at(Field::Vortex, right)[0], "clockwise: down at the right");
        let [down, across] = at(Field::Spiral, right);
        assert!(1.2 < down && across < -1.2);
        assert!(at(Field::Shear, [0, 5])[1] < -1.9 && 1.9 < at(Field::Shear, [64, 5])[1]);
        assert!(at(Field::Uniform, [7, 7]).map(|v| (v * 1e6).round() / 1e6) == [2.0, 0.0]);
        for field in Field::ALL {
            let by = of(field, domain);
            let speed = by.plane(0).iter().zip(by.plane(1)).map(|(y, x)| (y * y + x * x).sqrt()).fold(0.0, f32::max);
            assert!((1.8..=2.001).contains(&speed), "{field:?}: {speed}");
        }
    }

    #[test]
    fn shear_is_as_fast_as_asked_for_from_any_middle() {
        for middle in [-40.0, 0.0, 20.0, 64.0, 1e6] {
            let motion = Motion { field: Field::Shear, speed: 2.0, center: Some([middle, 0.0]), angle: 0.0 };
            let by = motion.flow(Domain::open([65, 9]), Seed(0)).unwrap().by;
            let speed = by.plane(1).iter().fold(0.0_f32, |most, v| most.max(v.abs()));
            assert!((1.99..=2.0).contains(&speed), "{middle}: {speed}");
        }
    }

    #[test]
    fn curl_noise_closes_and_nothing_gathers_in_it() {
        let domain = Domain::periodic([60, 48]);
        let by = of(Field::CurlNoise, domain);
        for at in domain.positions() {
            let beside = |axis: usize, by: i32| domain.step(at, if axis == 0 { [by, 0] } else { [0, by] }).unwrap();
            let slope = |axis: usize| (by.get(axis, beside(axis, 1)) - by.get(axis, beside(axis, -1))) / 2.0;
            assert!((slope(0) + slope(1)).abs() < 0.02, "{at:?}");
        }
    }
}
