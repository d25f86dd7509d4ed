//! From one depth to another.

use half::f16;
use selvedge_core::{Association, Depth, Grid, Plane, Role, Samples, srgb_encode};

use crate::Warning;
use crate::alpha::straight;
use crate::conversion::{Conversion, each, to_half};
use crate::error::Problem;
use crate::linear::Linear;
use crate::metadata::Metadata;

/// Converts the samples of a plane.
///
/// - u8 to u16: times 257. u16 to u8: divided by 257, rounded to the nearest, so u8 to u16 and back changes nothing.
///   Colours of narrow range have 256 in place of 257: their white is 235 of 8 bits, and 235 times 256 of 16.
///   `[H.273 8.3]`
/// - Half to float: exact. Float to half: to the nearest, ties to even.
/// - Integers to floats: 0..1; colour is decoded into linear light as the file's tags say (sRGB where they say
///   nothing; of narrow range, from its black to its white), alpha and other roles are not.
/// - Floats to integers: the reverse, to sRGB, clipped to 0..1, rounded to the nearest, halves up; what is no number
///   becomes 0. Normals that go below 0 are taken as -1..1 and moved to 0..1 first.
///
/// Between integers and floats colours that were multiplied by alpha are divided by it, before they are decoded or
/// encoded, and stay straight.
///
/// # Errors
/// [`Problem::LightWithoutAlpha`], and [`Problem::Core`] if the system has no memory for it.
pub fn convert(plane: &Plane<2>, to: Depth, metadata: &Metadata) -> Result<Conversion, Problem> {
    let mut clipped = 0;
    let same = |samples| Plane { role: plane.role, samples, alpha: plane.alpha, association: plane.association };
    // Channels whose greatest integers are not their white.
    let narrow = 0..if is_narrow(plane, metadata) { plane.color_channels() } else { 0 };
    let kept = match (&plane.samples, to) {
        (Samples::U8(g), Depth::U16) => {
            let mut out = g.map(|v| u16::from(v) * 257)?;
            for c in narrow.clone() {
                out.plane_mut(c).iter_mut().zip(g.plane(c)).for_each(|(to, &v)| *to = u16::from(v) << 8);
            }
            Some(Samples::U16(out))
        }
        (Samples::U16(g), Depth::U8) => {
            let mut out = g.map(|v| ((u32::from(v) + 128) / 257) as u8)?;
            for c in narrow.clone() {
                let rounded = |v: u16| ((u32::from(v) + 128) >> 8).min(255) as u8;
                out.plane_mut(c).iter_mut().zip(g.plane(c)).for_each(|(to, &v)| *to = rounded(v));
            }
            Some(Samples::U8(out))
        }
        (Samples::F16(g), Depth::F32) => Some(Samples::F32(g.map(|v| f16::from_bits(v).to_f32())?)),
        (Samples::F32(g), Depth::F16) => {
            let half = |v: f32| to_half(f64::from(v), &mut clipped);
            let mut out = Grid::try_filled(g.domain(), g.channels(), 0)?;
            out.samples_mut().iter_mut().zip(g.samples().iter().copied().map(half)).for_each(|(to, v)| *to = v);
            Some(Samples::F16(out))
        }
        (same, _) if same.depth() == to => Some(same.clone()),
        _ => None,
    };
    if let Some(samples) = kept {
        return Ok(Conversion { plane: same(samples), clipped, warnings: Vec::new() });
    }
    let straight = straight(plane)?;
    let (curves, mut warnings) = Curves::new(plane, metadata);
    // An opaque picture is both.
    if plane.is_premultiplied() && !plane.is_opaque() {
        warnings.push(Warning::Unmultiplied);
    }
    let samples = match to {
        Depth::U8 => {
            Samples::U8(each(plane, |c, i| (curves.encode(c, straight(c, i), &mut clipped) * 255.0 + 0.5) as u8)?)
        }
        Depth::U16 => {
            Samples::U16(each(plane, |c, i| (curves.encode(c, straight(c, i), &mut clipped) * 65_535.0 + 0.5) as u16)?)
        }
        Depth::F16 => Samples::F16(each(plane, |c, i| to_half(curves.decode(c, |c| straight(c, i)), &mut clipped))?),
        Depth::F32 => Samples::F32(each(plane, |c, i| curves.decode(c, |c| straight(c, i)) as f32)?),
    };
    Ok(Conversion { plane: Plane { association: Association::Straight, ..same(samples) }, clipped, warnings })
}

/// True of colours whose tag says that black and white lie within the range of integers.
fn is_narrow(plane: &Plane<2>, metadata: &Metadata) -> bool {
    plane.role == Role::Color && metadata.cicp.is_some_and(|[.., full]| full == 0)
}

/// How a plane's stored values and its values between 0 and 1 go together.
struct Curves {
    /// Channels below this one are sRGB-encoded where they are integers.
    encoded: usize,
    /// The greatest integer; `None` for floats.
    max: Option<f64>,
    /// Whether -1..1 stands for 0..1.
    signed: bool,
    /// How integers become light.
    linear: Linear,
    /// Black and the steps up to white, where those are not 0 and the greatest integer.
    narrow: Option<(f64, f64)>,
}

impl Curves {
    fn new(plane: &Plane<2>, metadata: &Metadata) -> (Self, Vec<Warning>) {
        let max = match plane.samples.depth() {
            Depth::U8 => Some(255.0),
            Depth::U16 => Some(65_535.0),
            Depth::F16 | Depth::F32 => None,
        };
        let n = plane.domain().len();
        let negative = |c| (0..n).any(|i| plane.samples.value(c, i) < 0.0);
        let signed = max.is_none() && plane.role.is_normal() && (0..plane.color_channels()).any(negative);
        let encoded = if plane.role == Role::Color { plane.color_channels() } else { 0 };
        let (linear, warning) = match max {
            Some(_) if plane.role == Role::Color => Linear::of(metadata, encoded),
            _ => Linear::of(&Metadata::default(), encoded),
        };
        // 16 to 235 of eight bits, and as many bits more of all others. `[H.273 8.3]`
        let narrow = max
            .filter(|_| is_narrow(plane, metadata))
            .map(|max| (max + 1.0) / 256.0)
            .map(|one| (16.0 * one, 219.0 * one));
        let mut warnings: Vec<Warning> = warning.into_iter().collect();
        warnings.extend(narrow.map(|_| Warning::NarrowRange));
        (Self { encoded, max, signed, linear, narrow }, warnings)
    }

    /// Integers to floats; floats stay.
    fn decode(&self, channel: usize, value: impl Fn(usize) -> f64) -> f64 {
        match self.max {
            None => value(channel),
            Some(max) if channel < self.encoded => {
                let (black, steps) = self.narrow.unwrap_or((0.0, max));
                // No curve says what is below black.
                self.linear.light(channel, |c| ((value(c) - black) / steps).max(0.0))
            }
            Some(max) => value(channel) / max,
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

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    #[test]
    fn narrow_range_ends_at_its_own_black_and_white() {
        let narrow = Metadata { cicp: Some([1, 8, 0, 0]), ..Metadata::default() };
        let full = Metadata { cicp: Some([1, 8, 0, 1]), ..Metadata::default() };
        let floats = |samples, metadata: &Metadata| {
            let light = convert(&plane(Role::Color, samples), Depth::F32, metadata).unwrap();
            let Samples::F32(grid) = light.plane.samples else { panic!("floats") };
            (grid.samples().to_vec(), light.warnings)
        };
        let of = |values: Vec<u8>| Samples::U8(Grid::from_vec(Domain::open([1, 4]), 1, values).unwrap());
        let (light, warnings) = floats(of(vec![0, 16, 235, 255]), &narrow);
        assert_eq!((light[0], light[1], light[2]), (0.0, 0.0, 1.0));
        assert!(1.0 < light[3], "brighter than white");
        assert_eq!(warnings, [Warning::NarrowRange]);
        let deep = Samples::U16(Grid::from_vec(Domain::open([1, 2]), 1, vec![16 << 8, 235 << 8]).unwrap());
        assert_eq!(floats(deep, &narrow).0, [0.0, 1.0]);
        assert_eq!(floats(of(vec![0, 0, 255, 255]), &full), (vec![0.0, 0.0, 1.0, 1.0], vec![]));
        // As integers they stay as they are, with their tag where it has a place.
        let kept = convert(&plane(Role::Color, of(vec![16, 0, 0, 0])), Depth::U8, &narrow).unwrap();
        assert!(kept.warnings.is_empty());
        assert_eq!(
            Metadata { cicp: Some([1, 13, 0, 0]), ..Metadata::default() }.left_out(crate::Format::Tiff, 1),
            ["cicp tag"]
        );
        assert!(
            Metadata { cicp: Some([1, 13, 0, 1]), ..Metadata::default() }.left_out(crate::Format::Tiff, 1).is_empty()
        );
    }

    #[test]
    fn integers_of_narrow_range_keep_their_black_and_white_in_other_depths() {
        let narrow = Metadata { cicp: Some([1, 8, 0, 0]), ..Metadata::default() };
        let grid = Grid::from_vec(Domain::open([1, 4]), 2, vec![16, 235, 0, 255, 16, 235, 0, 255]).unwrap();
        let start = Plane::with_alpha(Role::Color, Samples::U8(grid));
        let deep = convert(&start, Depth::U16, &narrow).unwrap().plane;
        let Samples::U16(grid) = &deep.samples else { panic!("16 bits") };
        assert_eq!(grid.plane(0), [16 << 8, 235 << 8, 0, 255 << 8]);
        assert_eq!(grid.plane(1), [16 * 257, 235 * 257, 0, 65_535], "alpha has no narrow range");
        assert_eq!(convert(&deep, Depth::U8, &narrow).unwrap().plane, start);
        let light = |plane| convert(plane, Depth::F32, &narrow).unwrap().plane.samples.value(0, 1);
        assert_eq!((light(&start), light(&deep)), (1.0, 1.0));
        let most = plane(Role::Color, Samples::U16(Grid::from_vec(Domain::open([1, 1]), 1, vec![65_535]).unwrap()));
        assert_eq!(convert(&most, Depth::U8, &narrow).unwrap().plane.samples.value(0, 0), 255.0);
    }

    #[test]
    fn a_change_of_alphas_way_is_told() {
        let grid = Grid::from_vec(Domain::open([1, 1]), 4, vec![56, 52, 44, 128]).unwrap();
        let straight = Plane::with_alpha(Role::Color, Samples::U8(grid));
        let premultiplied = Plane { association: Association::Premultiplied, ..straight.clone() };
        let warnings = |plane: &Plane<2>, to| convert(plane, to, &Metadata::default()).unwrap().warnings;
        assert_eq!(warnings(&premultiplied, Depth::F32), [Warning::Unmultiplied]);
        assert!(warnings(&premultiplied, Depth::U16).is_empty() && warnings(&straight, Depth::F32).is_empty());
    }

    fn plane(role: Role, samples: Samples<2>) -> Plane<2> {
        Plane { alpha: samples.channels() == 2, ..Plane::new(role, samples) }
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
                let there = convert(&start, depth, &Metadata::default()).unwrap();
                let back = convert(&there.plane, Depth::U8, &Metadata::default()).unwrap();
                assert_eq!(
                    back,
                    Conversion { plane: start.clone(), clipped: 0, warnings: Vec::new() },
                    "{role:?} {depth:?}"
                );
            }
        }
    }

    #[test]
    fn sixteen_bits_survive_floats_and_round_to_the_nearest() {
        let all: Vec<u16> = (0..=u16::MAX).collect();
        let start = plane(Role::Color, Samples::U16(Grid::from_vec(Domain::open([256, 256]), 1, all.clone()).unwrap()));
        let floats = convert(&start, Depth::F32, &Metadata::default()).unwrap().plane;
        assert_eq!(convert(&floats, Depth::U16, &Metadata::default()).unwrap().plane, start);
        let Samples::U8(small) = convert(&start, Depth::U8, &Metadata::default()).unwrap().plane.samples else {
            unreachable!()
        };
        for (small, large) in small.plane(0).iter().zip(all) {
            assert!((f64::from(*small) * 257.0 - f64::from(large)).abs() <= 128.0);
        }
    }

    #[test]
    fn clipping_is_counted_and_never_infinite() {
        let start = floats(Role::Scalar, vec![-0.5, 0.0, 0.5, 1.0, 1e6, f32::NAN]);
        let out = convert(&start, Depth::U8, &Metadata::default()).unwrap();
        assert_eq!(out.clipped, 3);
        assert!(matches!(out.plane.samples, Samples::U8(g) if g.plane(0) == [0, 0, 128, 255, 255, 0]));
        let out = convert(&floats(Role::Color, vec![1e6, -1e6, 0.1]), Depth::F16, &Metadata::default()).unwrap();
        assert_eq!(out.clipped, 2);
        let Samples::F16(g) = out.plane.samples else { unreachable!() };
        assert_eq!(g.plane(0), [f16::MAX.to_bits(), f16::MIN.to_bits(), f16::from_f32(0.1).to_bits()]);
    }

    #[test]
    fn signed_normals_move_to_the_middle() {
        let out = convert(&floats(Role::Normal, vec![-1.0, 0.0, 1.0]), Depth::U16, &Metadata::default()).unwrap();
        assert!(matches!(out.plane.samples, Samples::U16(g) if g.plane(0) == [0, 32_768, 65_535]));
    }
}
