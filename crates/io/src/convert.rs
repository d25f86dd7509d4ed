//! From one depth to another.

use half::f16;
use selvedge_core::{Depth, Grid, Plane, Role, Samples, srgb_decode, srgb_encode};

use crate::error::Problem;

/// A plane in another depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// The plane.
    pub plane: Plane<2>,
    /// Samples whose value the new depth cannot hold, so that they became its greatest or least.
    pub clipped: u64,
}

/// Converts the samples of a plane.
///
/// - u8 to u16: times 257. u16 to u8: divided by 257, rounded to the nearest, so u8 to u16 and back changes nothing.
/// - Half to float: exact. Float to half: to the nearest, ties to even.
/// - Integers to floats: 0..1; colour is decoded from sRGB into linear light, alpha and other roles are not.
/// - Floats to integers: the reverse, clipped to 0..1, rounded to the nearest, halves up; what is no number becomes 0.
///   Normals that go below 0 are taken as -1..1 and moved to 0..1 first.
///
/// # Errors
/// [`Problem::Core`] if the system has no memory for it.
pub fn convert(plane: &Plane<2>, to: Depth) -> Result<Converted, Problem> {
    let mut clipped = 0;
    let samples = match (&plane.samples, to) {
        (Samples::U8(g), Depth::U16) => Samples::U16(g.map(|v| u16::from(v) * 257)?),
        (Samples::U16(g), Depth::U8) => Samples::U8(g.map(|v| ((u32::from(v) + 128) / 257) as u8)?),
        (same, _) if same.depth() == to => same.clone(),
        (_, Depth::U8) => {
            let curves = Curves::new(plane);
            Samples::U8(each(plane, |c, v| (curves.encode(c, v, &mut clipped) * 255.0 + 0.5) as u8)?)
        }
        (_, Depth::U16) => {
            let curves = Curves::new(plane);
            Samples::U16(each(plane, |c, v| (curves.encode(c, v, &mut clipped) * 65_535.0 + 0.5) as u16)?)
        }
        (_, Depth::F16) => {
            let curves = Curves::new(plane);
            Samples::F16(each(plane, |c, v| to_half(curves.decode(c, v), &mut clipped))?)
        }
        (_, Depth::F32) => {
            let curves = Curves::new(plane);
            Samples::F32(each(plane, |c, v| curves.decode(c, v) as f32)?)
        }
    };
    Ok(Converted { plane: Plane { role: plane.role, samples, alpha: plane.alpha }, clipped })
}

/// Every sample through a function of its channel and value.
fn each<T: Copy + Default>(plane: &Plane<2>, mut f: impl FnMut(usize, f64) -> T) -> Result<Grid<T, 2>, Problem> {
    let mut out = Grid::try_filled(plane.domain(), plane.samples.channels(), T::default())?;
    for c in 0..out.channels() {
        for (i, to) in out.plane_mut(c).iter_mut().enumerate() {
            *to = f(c, plane.samples.value(c, i));
        }
    }
    Ok(out)
}

/// How a plane's stored values and its values between 0 and 1 go together.
struct Curves {
    /// Channels below this one are sRGB-encoded where they are integers.
    encoded: usize,
    /// The greatest integer; `None` for floats.
    max: Option<f64>,
    /// Whether -1..1 stands for 0..1.
    signed: bool,
}

impl Curves {
    fn new(plane: &Plane<2>) -> Self {
        let max = match plane.samples.depth() {
            Depth::U8 => Some(255.0),
            Depth::U16 => Some(65_535.0),
            Depth::F16 | Depth::F32 => None,
        };
        let n = plane.domain().len();
        let negative = |c| (0..n).any(|i| plane.samples.value(c, i) < 0.0);
        let signed = max.is_none() && plane.role == Role::Normal && (0..plane.color_channels()).any(negative);
        let encoded = if plane.role == Role::Color { plane.color_channels() } else { 0 };
        Self { encoded, max, signed }
    }

    /// Integers to floats; floats stay.
    fn decode(&self, channel: usize, v: f64) -> f64 {
        match self.max {
            None => v,
            Some(max) if channel < self.encoded => srgb_decode(v / max),
            Some(max) => v / max,
        }
    }

    /// Floats to 0..1.
    fn encode(&self, channel: usize, v: f64, clipped: &mut u64) -> f64 {
        let v = if self.signed { (v + 1.0) / 2.0 } else { v };
        if !(0.0..=1.0).contains(&v) {
            *clipped += 1;
        }
        let v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        if channel < self.encoded { srgb_encode(v) } else { v }
    }
}

/// Floats beyond the range of halves would become infinite.
fn to_half(v: f64, clipped: &mut u64) -> u16 {
    let limit = f16::MAX.to_f64();
    if limit < v.abs() {
        *clipped += 1;
    }
    f16::from_f32(v.clamp(-limit, limit) as f32).to_bits()
}

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    fn plane(role: Role, samples: Samples<2>) -> Plane<2> {
        Plane { role, alpha: samples.channels() == 2, samples }
    }

    fn bytes() -> Plane<2> {
        let all = (0..=255).chain((0..=255).rev()).collect();
        plane(Role::Color, Samples::U8(Grid::from_vec(Domain::open([16, 16]), 2, all).unwrap()))
    }

    fn floats(role: Role, values: Vec<f32>) -> Plane<2> {
        plane(role, Samples::F32(Grid::from_vec(Domain::open([1, values.len() as u32]), 1, values).unwrap()))
    }

    #[test]
    fn eight_bits_survive_every_deeper_depth() {
        for role in [Role::Color, Role::Normal, Role::Scalar] {
            let start = Plane { role, ..bytes() };
            for depth in [Depth::U16, Depth::F16, Depth::F32] {
                let there = convert(&start, depth).unwrap();
                let back = convert(&there.plane, Depth::U8).unwrap();
                assert_eq!(back, Converted { plane: start.clone(), clipped: 0 }, "{role:?} {depth:?}");
            }
        }
    }

    #[test]
    fn sixteen_bits_survive_floats_and_round_to_the_nearest() {
        let all: Vec<u16> = (0..=u16::MAX).collect();
        let start = plane(Role::Color, Samples::U16(Grid::from_vec(Domain::open([256, 256]), 1, all.clone()).unwrap()));
        let floats = convert(&start, Depth::F32).unwrap().plane;
        assert_eq!(convert(&floats, Depth::U16).unwrap().plane, start);
        let Samples::U8(small) = convert(&start, Depth::U8).unwrap().plane.samples else { unreachable!() };
        for (small, large) in small.plane(0).iter().zip(all) {
            assert!((f64::from(*small) * 257.0 - f64::from(large)).abs() <= 128.0);
        }
    }

    #[test]
    fn clipping_is_counted_and_never_infinite() {
        let start = floats(Role::Scalar, vec![-0.5, 0.0, 0.5, 1.0, 1e6, f32::NAN]);
        let out = convert(&start, Depth::U8).unwrap();
        assert_eq!(out.clipped, 3);
        assert!(matches!(out.plane.samples, Samples::U8(g) if g.plane(0) == [0, 0, 128, 255, 255, 0]));
        let out = convert(&floats(Role::Color, vec![1e6, -1e6, 0.1]), Depth::F16).unwrap();
        assert_eq!(out.clipped, 2);
        let Samples::F16(g) = out.plane.samples else { unreachable!() };
        assert_eq!(g.plane(0), [f16::MAX.to_bits(), f16::MIN.to_bits(), f16::from_f32(0.1).to_bits()]);
    }

    #[test]
    fn signed_normals_move_to_the_middle() {
        let out = convert(&floats(Role::Normal, vec![-1.0, 0.0, 1.0]), Depth::U16).unwrap();
        assert!(matches!(out.plane.samples, Samples::U16(g) if g.plane(0) == [0, 32_768, 65_535]));
    }
}
