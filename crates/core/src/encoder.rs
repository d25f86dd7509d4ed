//! Match space: payload of any depth becomes 8-bit features, through one encoder for everything in a run.

use crate::plane::each_depth;
use crate::{Depth, Error, Grid, Plane, Role, Samples, par};

/// Turns planes into 8-bit features. Fitted once to all exemplars; targets and guides go through the same one.
///
/// Integer samples keep their encoded value (16 bits are rounded to 8). Linear light between 0 and 1 is sRGB-encoded;
/// light beyond is put on a symmetric logarithmic curve, heights and float scalars on the exemplars' range.
#[derive(Clone, Debug, PartialEq)]
pub struct Encoder {
    curves: Vec<Curve>,
    channels: Vec<usize>,
    weights: Vec<u8>,
}

/// How one plane's values become 0..=255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Curve {
    /// Integers as they are stored; floats as linear light.
    Color,
    /// `sign(v) * ln(1 + |v| / knee)`, from `lo` to `hi`, of linear light.
    Log { knee: f64, lo: f64, hi: f64 },
    /// A straight line from `lo` to `hi`.
    Line { lo: f64, hi: f64 },
}

impl Encoder {
    /// Fits one curve a plane to all exemplars; every channel weighs 1.
    ///
    /// # Errors
    /// [`Error::NoExemplars`], [`Error::NoPlanes`], [`Error::Shape`] (planes of one exemplar differ), [`Error::Layout`]
    /// (exemplars differ), [`Error::NotFinite`].
    pub fn fit<const D: usize>(exemplars: &[&[Plane<D>]]) -> Result<Self, Error> {
        check(exemplars)?;
        let n_planes = exemplars[0].len();
        let curves = (0..n_planes).map(|p| fit_curve(&exemplars.iter().map(|e| &e[p]).collect::<Vec<_>>())).collect();
        let channels: Vec<usize> = exemplars[0].iter().map(Plane::color_channels).collect();
        let weights = vec![1; channels.iter().sum()];
        Ok(Self { curves, channels, weights })
    }

    /// The same encoder with a weight for each feature channel, in the order of the planes.
    ///
    /// # Errors
    /// [`Error::Weights`] if there are too many or too few, or all are 0.
    pub fn with_weights(mut self, weights: Vec<u8>) -> Result<Self, Error> {
        if weights.len() != self.weights.len() || weights.iter().all(|&w| w == 0) {
            return Err(Error::Weights { expected: self.weights.len(), found: weights.len() });
        }
        self.weights = weights;
        Ok(self)
    }

    /// The same encoder with a weight for each plane, which its channels share: a height of weight 1 decides as much as
    /// a colour of weight 1.
    ///
    /// # Errors
    /// [`Error::Weights`] if there are too many or too few; [`Error::GuideWeight`], [`Error::GuideProportion`] for
    /// numbers that cannot be used.
    pub fn with_plane_weights(self, weights: &[f64]) -> Result<Self, Error> {
        if weights.len() != self.channels.len() {
            return Err(Error::Weights { expected: self.channels.len(), found: weights.len() });
        }
        let ones: Vec<Vec<u8>> = self.channels.iter().map(|&n| vec![1; n]).collect();
        let parts: Vec<(f64, &[u8])> = weights.iter().zip(&ones).map(|(&weight, ones)| (weight, &ones[..])).collect();
        let weights = crate::weights::of_parts(&parts)?;
        self.with_weights(weights)
    }

    /// Weight of each feature channel.
    pub fn weights(&self) -> &[u8] {
        &self.weights
    }

    /// The features of registered planes, one channel after the other; alpha is left out.
    ///
    /// # Errors
    /// [`Error::Layout`] if they are not the planes that the encoder was fitted to, [`Error::Shape`],
    /// [`Error::NotFinite`], [`Error::Allocation`].
    pub fn encode<const D: usize>(&self, planes: &[Plane<D>]) -> Result<Grid<u8, D>, Error> {
        check(&[planes])?;
        let found: Vec<usize> = planes.iter().map(Plane::color_channels).collect();
        if found != self.channels {
            let words = |c: &[usize]| format!("{} plane(s) of {c:?} channels", c.len());
            return Err(Error::Layout { exemplar: 0, expected: words(&self.channels), found: words(&found) });
        }
        let domain = planes[0].domain();
        let mut features = Grid::try_filled(domain, self.weights.len(), 0_u8)?;
        let mut to = 0;
        for (plane, &curve) in planes.iter().zip(&self.curves) {
            for c in 0..plane.color_channels() {
                encode_channel(curve, plane, c, features.plane_mut(to));
                to += 1;
            }
        }
        Ok(features)
    }
}

impl Curve {
    /// That of colours which are stored as light; `None` for all other planes.
    pub(crate) fn of_light<const D: usize>(planes: &[&Plane<D>]) -> Option<Self> {
        let is_light = |p: &&Plane<D>| p.role == Role::Color && !matches!(p.samples.depth(), Depth::U8 | Depth::U16);
        (!planes.is_empty() && planes.iter().all(is_light)).then(|| fit_curve(planes))
    }

    /// Light where equal steps look alike.
    pub(crate) fn on(self, light: f64) -> f64 {
        match self {
            Self::Color => srgb_encode(light),
            Self::Log { knee, .. } => symmetric_log(light, knee),
            Self::Line { .. } => light,
        }
    }

    /// The light that stands there.
    pub(crate) fn off(self, v: f64) -> f64 {
        match self {
            Self::Color => srgb_decode(v),
            Self::Log { knee, .. } => (libm::expm1(v.abs()) * knee).copysign(v),
            Self::Line { .. } => v,
        }
    }
}

/// Every exemplar has planes, of one shape, finite, and of the first exemplar's layout.
fn check<const D: usize>(exemplars: &[&[Plane<D>]]) -> Result<(), Error> {
    if exemplars.is_empty() {
        return Err(Error::NoExemplars);
    }
    for (e, &planes) in exemplars.iter().enumerate() {
        let first = planes.first().ok_or(Error::NoPlanes { exemplar: e })?;
        let layout = |planes: &[Plane<D>]| planes.iter().map(|p| (p.role, p.color_channels())).collect::<Vec<_>>();
        if layout(planes) != layout(exemplars[0]) {
            let words = |planes: &[Plane<D>]| planes.iter().map(Plane::layout).collect::<Vec<_>>().join(", ");
            return Err(Error::Layout { exemplar: e, expected: words(exemplars[0]), found: words(planes) });
        }
        for (p, plane) in planes.iter().enumerate() {
            let (expected, found) = (first.domain().shape.to_vec(), plane.domain().shape.to_vec());
            if expected != found {
                return Err(Error::Shape { exemplar: e, plane: p, expected, found });
            }
            check_finite(e, p, plane)?;
        }
    }
    Ok(())
}

fn check_finite<const D: usize>(exemplar: usize, plane: usize, of: &Plane<D>) -> Result<(), Error> {
    if matches!(of.samples.depth(), Depth::U8 | Depth::U16) {
        return Ok(());
    }
    let n = of.domain().len();
    let bad = |i: &usize| !of.samples.value(i / n, i % n).is_finite();
    let Some(first) = (0..n * of.samples.channels()).find(bad) else { return Ok(()) };
    let count = (first..n * of.samples.channels()).filter(bad).count();
    let at = of.domain().position(first % n).to_vec();
    Err(Error::NotFinite { exemplar, plane, count, at })
}

fn fit_curve<const D: usize>(planes: &[&Plane<D>]) -> Curve {
    let role = planes[0].role;
    let integer = planes.iter().all(|p| matches!(p.samples.depth(), Depth::U8 | Depth::U16));
    if planes.iter().all(|p| p.samples.depth() == Depth::U8) || (integer && role != Role::Height) {
        return Curve::Color;
    }
    let (lo, hi, mean) = range(planes);
    match role {
        Role::Color if 0.0 <= lo && hi <= 1.0 => Curve::Color,
        Role::Color => {
            // The knee parts the linear foot from the logarithm: a tenth of the mean light, so shadows keep steps.
            let knee = (mean * 0.1).max(1e-6);
            Curve::Log { knee, lo: symmetric_log(lo, knee), hi: symmetric_log(hi, knee) }
        }
        Role::Normal | Role::NormalDown if lo < 0.0 => Curve::Line { lo: -1.0, hi: 1.0 },
        Role::Normal | Role::NormalDown => Curve::Line { lo: 0.0, hi: 1.0 },
        Role::Height | Role::Scalar => Curve::Line { lo, hi },
    }
}

/// Least, greatest and mean absolute value of the valid samples, integers taken as 0..1; 0 if there are none.
fn range<const D: usize>(planes: &[&Plane<D>]) -> (f64, f64, f64) {
    let (mut lo, mut hi, mut sum, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0_u64);
    for plane in planes {
        for c in 0..plane.color_channels() {
            for i in 0..plane.domain().len() {
                if !plane.shows(i) {
                    continue;
                }
                let v = unit(plane, c, i);
                (lo, hi) = (lo.min(v), hi.max(v));
                sum += v.abs();
                count += 1;
            }
        }
    }
    if count == 0 { (0.0, 0.0, 0.0) } else { (lo, hi, sum / count as f64) }
}

/// A sample with integers scaled to 0..1 and floats as they are.
fn unit<const D: usize>(plane: &Plane<D>, channel: usize, index: usize) -> f64 {
    let v = plane.samples.value(channel, index);
    match plane.samples.depth() {
        Depth::U8 => v / 255.0,
        Depth::U16 => v / 65_535.0,
        Depth::F16 | Depth::F32 => v,
    }
}

fn encode_channel<const D: usize>(curve: Curve, plane: &Plane<D>, channel: usize, to: &mut [u8]) {
    match (&plane.samples, curve) {
        (Samples::U8(g), Curve::Color) => to.copy_from_slice(g.plane(channel)),
        (Samples::U16(g), Curve::Color) => {
            for (to, &v) in to.iter_mut().zip(g.plane(channel)) {
                *to = ((u32::from(v) + 128) / 257) as u8;
            }
        }
        _ => {
            let linear = matches!(plane.samples.depth(), Depth::F16 | Depth::F32);
            let row = each_depth!(&plane.samples, g => g.domain().shape[D - 1]) as usize;
            par::for_rows(to, row.max(1), |y, to| {
                for (x, to) in to.iter_mut().enumerate() {
                    *to = encode_value(curve, unit(plane, channel, y * row + x), linear);
                }
            });
        }
    }
}

/// `linear` says whether a colour value is linear light rather than sRGB-encoded.
fn encode_value(curve: Curve, v: f64, linear: bool) -> u8 {
    let (v, lo, hi) = match curve {
        Curve::Color if linear => (srgb_encode(v), 0.0, 1.0),
        Curve::Color => (v, 0.0, 1.0),
        Curve::Log { knee, lo, hi } => (symmetric_log(if linear { v } else { srgb_decode(v) }, knee), lo, hi),
        Curve::Line { lo, hi } => (v, lo, hi),
    };
    if hi <= lo {
        return 0;
    }
    // `as` saturates, so values outside of the fitted range end at 0 and 255.
    ((v - lo) / (hi - lo) * 255.0 + 0.5) as u8
}

fn symmetric_log(v: f64, knee: f64) -> f64 {
    libm::log1p(v.abs() / knee).copysign(v)
}

/// IEC 61966-2-1, linear light to encoded value.
pub fn srgb_encode(v: f64) -> f64 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 }
}

/// IEC 61966-2-1, encoded value to linear light.
pub fn srgb_decode(v: f64) -> f64 {
    if v <= 0.040_45 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Domain;

    fn float(values: &[f32]) -> Plane<2> {
        let domain = Domain::open([1, values.len() as u32]);
        Plane::new(Role::Color, Samples::F32(Grid::from_vec(domain, 1, values.to_vec()).unwrap()))
    }

    fn features(plane: &Plane<2>) -> Vec<u8> {
        let planes = std::slice::from_ref(plane);
        Encoder::fit(&[planes]).unwrap().encode(planes).unwrap().into_vec()
    }

    #[test]
    fn bytes_stay_and_words_are_rounded() {
        let domain = Domain::open([1, 4]);
        let bytes = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, vec![0, 1, 128, 255]).unwrap()));
        assert_eq!(features(&bytes), [0, 1, 128, 255]);
        let words = Grid::from_vec(domain, 1, vec![0, 128, 129, 65_535]).unwrap();
        assert_eq!(features(&Plane::new(Role::Color, Samples::U16(words))), [0, 0, 1, 255]);
    }

    #[test]
    fn light_up_to_one_is_srgb_encoded() {
        assert_eq!(features(&float(&[0.0, 0.215_861, 1.0])), [0, 128, 255]);
        assert!((srgb_decode(srgb_encode(0.3)) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn high_dynamic_range_is_monotone_and_fills_the_range() {
        let f = features(&float(&[-0.5, 0.0, 0.01, 0.1, 1.0, 10.0, 3.0e38]));
        assert!(f.is_sorted());
        assert_eq!((f[0], f[6]), (0, 255));
    }

    #[test]
    fn values_that_are_no_numbers_are_refused() {
        let plane = float(&[0.0, f32::NAN, f32::INFINITY]);
        let error = Encoder::fit(&[std::slice::from_ref(&plane)]).unwrap_err();
        assert_eq!(error, Error::NotFinite { exemplar: 0, plane: 0, count: 2, at: vec![0, 1] });
    }

    #[test]
    fn unregistered_planes_and_different_layouts_are_refused() {
        let (a, b) = (float(&[0.0]), float(&[0.0, 1.0]));
        assert!(matches!(Encoder::fit(&[&[a.clone(), b][..]]), Err(Error::Shape { .. })));
        let c = Plane::new(Role::Scalar, a.samples.clone());
        assert!(matches!(Encoder::fit(&[&[a][..], &[c][..]]), Err(Error::Layout { exemplar: 1, .. })));
        assert!(matches!(Encoder::fit::<2>(&[]), Err(Error::NoExemplars)));
    }
}
