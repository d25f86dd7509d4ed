//! From encoded integers to linear light, as a file's colour tags say.

use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve};
use selvedge_core::srgb_decode;

use crate::metadata::{Metadata, is_usual};
use crate::{Depth, Warning};

/// How integers of one file become light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Linear {
    /// One a channel, or one for all.
    curves: Vec<Curve>,
    /// From the file's primaries to those of sRGB, rows of sums; `None` where they are kept.
    matrix: Option<[[f64; 3]; 3]>,
}

#[derive(Clone, Debug, PartialEq)]
enum Curve {
    Srgb,
    /// BT.709's, backwards.
    Broadcast,
    Power(f64),
    /// Values between 0 and 65,535 at equal distances.
    Table(Vec<u16>),
    /// `g a b c d e f` of ICC.1 10.18; fewer are one of its shorter kinds.
    Parametric(Vec<f64>),
}

impl Curve {
    fn light(&self, v: f64) -> f64 {
        match self {
            Self::Srgb => srgb_decode(v),
            Self::Broadcast => {
                if v < 0.081 {
                    v / 4.5
                } else {
                    libm::pow((v + 0.099) / 1.099, 1.0 / 0.45)
                }
            }
            Self::Power(exponent) => libm::pow(v, *exponent),
            Self::Table(values) => {
                let at = v.clamp(0.0, 1.0) * (values.len() - 1) as f64;
                let (low, part) = (at as usize, at - (at as usize) as f64);
                let [a, b] = [low, (low + 1).min(values.len() - 1)].map(|i| f64::from(values[i]) / 65_535.0);
                a + (b - a) * part
            }
            Self::Parametric(p) => {
                let p = |i: usize| p.get(i).copied().unwrap_or(0.0);
                let (g, a, b, c, d, e, f) = (p(0), p(1), p(2), p(3), p(4), p(5), p(6));
                if v < d { c * v + f } else { libm::pow((a * v + b).max(0.0), g) + e }
            }
        }
    }

    fn of_profile(curve: &ToneReprCurve) -> Option<Self> {
        Some(match curve {
            ToneReprCurve::Lut(values) if values.is_empty() => Self::Power(1.0),
            // One value is an exponent in 8 bits before and 8 after the point.
            ToneReprCurve::Lut(values) if values.len() == 1 => Self::Power(f64::from(values[0]) / 256.0),
            ToneReprCurve::Lut(values) => Self::Table(values.clone()),
            ToneReprCurve::Parametric(p) => {
                let p: Vec<f64> = p.iter().map(|v| f64::from(*v)).collect();
                match p[..] {
                    [g] => Self::Power(g),
                    // Below -b/a it is nothing; with c more it is c.
                    [g, a, b] if a != 0.0 => Self::Parametric(vec![g, a, b, 0.0, -b / a, 0.0, 0.0]),
                    [g, a, b, c] if a != 0.0 => Self::Parametric(vec![g, a, b, 0.0, -b / a, c, c]),
                    [_, _, _, _, _] | [_, _, _, _, _, _, _] => Self::Parametric(p),
                    _ => return None,
                }
            }
        })
    }
}

/// From XYZ at D50 to linear sRGB, whose white is D65: the inverse of its colorants, adapted by Bradford's method.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.133_856_1, -1.616_866_7, -0.490_614_6],
    [-0.978_768_4, 1.916_141_5, 0.033_454],
    [0.071_945_3, -0.228_991_4, 1.405_242_7],
];

impl Linear {
    /// What the tags say, in the order of PNG: cICP, profile, sRGB, gamma. Where they cannot be followed, sRGB, and
    /// what was not followed.
    pub(crate) fn of(metadata: &Metadata, colors: usize) -> (Self, Option<Warning>) {
        let with = |curve| Self { curves: vec![curve], matrix: None };
        let found = if let Some([_, transfer, _, _]) = metadata.cicp {
            match transfer {
                1 | 6 | 14 | 15 => Ok(with(Curve::Broadcast)),
                4 => Ok(with(Curve::Power(2.2))),
                5 => Ok(with(Curve::Power(2.8))),
                8 => Ok(with(Curve::Power(1.0))),
                2 | 13 => Ok(with(Curve::Srgb)),
                _ => Err("cicp tag"),
            }
        } else if metadata.icc.is_some() {
            Self::of_profile(metadata, colors).ok_or("colour profile")
        } else {
            Ok(with(match metadata.gamma {
                Some(gamma) if metadata.srgb.is_none() && !is_usual(gamma) => {
                    Curve::Power(100_000.0 / f64::from(gamma))
                }
                _ => Curve::Srgb,
            }))
        };
        match found {
            Ok(linear) => (linear, None),
            Err(tag) => (with(Curve::Srgb), Some(Warning::TagNotFollowed { tag })),
        }
    }

    /// A profile of curves and primaries; `None` for one of tables, or of another number of channels.
    fn of_profile(metadata: &Metadata, colors: usize) -> Option<Self> {
        let profile = ColorProfile::new_from_slice(metadata.icc_for(colors)?).ok()?;
        if profile.lut_a_to_b_perceptual.is_some() || profile.lut_a_to_b_colorimetric.is_some() {
            return None;
        }
        if profile.color_space == DataColorSpace::Gray {
            return Some(Self { curves: vec![Curve::of_profile(profile.gray_trc.as_ref()?)?], matrix: None });
        }
        let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
        let curves = curves.map(|c| c.as_ref().and_then(Curve::of_profile)).into_iter().collect::<Option<Vec<_>>>()?;
        let colorants = [profile.red_colorant, profile.green_colorant, profile.blue_colorant].map(|c| [c.x, c.y, c.z]);
        let matrix = FROM_XYZ.map(|row| colorants.map(|c| row[0] * c[0] + row[1] * c[1] + row[2] * c[2]));
        // Profiles round their primaries to 16 bits: those of sRGB itself are to change nothing.
        let nearly = |r: usize, c: usize| (matrix[r][c] - f64::from(u8::from(r == c))).abs() < 2e-3;
        let same = (0..9).all(|i| nearly(i / 3, i % 3));
        Some(Self { curves, matrix: (!same).then_some(matrix) })
    }

    /// Whether the primaries become those of sRGB.
    pub(crate) fn moves_primaries(&self) -> bool {
        self.matrix.is_some()
    }

    /// One channel of light, from a function of the values of all channels.
    pub(crate) fn light(&self, channel: usize, value: impl Fn(usize) -> f64) -> f64 {
        let one = |c: usize| self.curves[c.min(self.curves.len() - 1)].light(value(c));
        match &self.matrix {
            Some(matrix) => (0..3).map(|c| matrix[channel][c] * one(c)).sum(),
            None => one(channel),
        }
    }
}

/// The primaries of a code point [ITU-T H.273, table 2] that are in use and not sRGB's.
fn primaries_of(code: u8) -> Option<[f64; 8]> {
    Some(match code {
        9 => [0.3127, 0.329, 0.708, 0.292, 0.17, 0.797, 0.131, 0.046],
        11 => [0.314, 0.351, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06],
        12 => [0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06],
        _ => return None,
    })
}

impl Metadata {
    /// What still holds when samples change their depth: integers are encoded and floats are linear light, so a
    /// profile, sRGB or a gamma for the one says nothing of the other.
    #[must_use]
    pub fn converted(&self, from: Depth, to: Depth) -> Self {
        let float = |depth| matches!(depth, Depth::F16 | Depth::F32);
        let mut metadata = self.clone();
        if float(from) != float(to) {
            // The primaries of a profile became those of sRGB with its curves; others are told as chromaticities.
            let moved = float(to) && self.icc.is_some() && Linear::of(self, 3).0.moves_primaries();
            let named = self.cicp.and_then(|[primaries, ..]| primaries_of(primaries));
            metadata.chromaticities = if moved { None } else { named.or(self.chromaticities) };
            (metadata.icc, metadata.srgb, metadata.gamma, metadata.cicp) = (None, None, None, None);
        }
        metadata
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_those_of_their_standards() {
        let near = |curve: Curve, v: f64, light: f64| assert!((curve.light(v) - light).abs() < 1e-4, "{curve:?}");
        near(Curve::Power(2.2), 0.5, 0.217_638);
        near(Curve::Broadcast, 0.5, 0.259_589);
        near(Curve::Table(vec![0, 65_535]), 0.25, 0.25);
        // sRGB as profiles of version 4 have it.
        let parametric = vec![2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045];
        near(Curve::Parametric(parametric.clone()), 0.5, srgb_decode(0.5));
        near(Curve::Parametric(parametric), 0.02, srgb_decode(0.02));
    }

    #[test]
    fn tags_are_followed_in_their_order() {
        let curve = |metadata: &Metadata| Linear::of(metadata, 3).0.light(0, |_| 0.5);
        let none = Metadata::default();
        assert_eq!(curve(&none), srgb_decode(0.5));
        let gamma = Metadata { gamma: Some(100_000), ..none.clone() };
        assert_eq!(curve(&gamma), 0.5);
        assert_eq!(curve(&Metadata { srgb: Some(0), ..gamma.clone() }), srgb_decode(0.5));
        assert_eq!(curve(&Metadata { cicp: Some([1, 13, 0, 1]), ..gamma }), srgb_decode(0.5));
        let pq = Metadata { cicp: Some([9, 16, 0, 1]), ..none.clone() };
        assert_eq!(Linear::of(&pq, 3).1, Some(Warning::TagNotFollowed { tag: "cicp tag" }));
        let broken = Metadata { icc: Some(vec![1; 200]), ..none };
        assert_eq!(Linear::of(&broken, 3).1, Some(Warning::TagNotFollowed { tag: "colour profile" }));
    }

    #[test]
    fn profiles_of_curves_and_primaries_are_followed() {
        let of = |profile: ColorProfile| {
            let metadata = Metadata { icc: Some(profile.encode().unwrap()), ..Metadata::default() };
            let (linear, warning) = Linear::of(&metadata, 3);
            assert_eq!(warning, None);
            linear
        };
        let srgb = of(ColorProfile::new_srgb());
        assert!(!srgb.moves_primaries());
        assert!((srgb.light(1, |_| 0.5) - srgb_decode(0.5)).abs() < 1e-3);
        // Adobe RGB: gamma 563/256, and a green beyond sRGB's, by its own published colorants.
        let adobe = of(ColorProfile::new_adobe_rgb());
        let green = [0, 1, 2].map(|c| adobe.light(c, |k| f64::from(u8::from(k == 1))));
        assert!(green[0] < -0.3 && (green[1] - 1.0).abs() < 2e-2 && green[2] < 0.0, "{green:?}");
        let white = [0, 1, 2].map(|c| adobe.light(c, |_| 1.0));
        assert!(white.iter().all(|v| (v - 1.0).abs() < 2e-3), "{white:?}");
    }
}
