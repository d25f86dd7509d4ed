//! Straight colours and those that were multiplied by alpha.

use selvedge_core::{Association, Depth, Plane, Samples};

use crate::Format;
use crate::conversion::{Conversion, each, to_float, to_half};
use crate::error::Problem;

impl Format {
    /// How colour and alpha go together where a file does not say it, and in what is written; `None` where there is no
    /// alpha, or all files say it.
    pub fn association(self) -> Option<Association> {
        match self {
            Self::Exr => Some(Association::Premultiplied),
            Self::Png | Self::Webp | Self::Tga | Self::Gif | Self::Bmp => Some(Association::Straight),
            Self::Tiff | Self::Jpeg | Self::Hdr => None,
        }
    }
}

/// A plane whose colours stand to alpha in this way: as it is where they do, or where it has no alpha. Colours are
/// multiplied or divided as they are stored, so floats in linear light; integers are rounded to the nearest.
///
/// # Errors
/// [`Problem::LightWithoutAlpha`] where nothing can be divided, [`Problem::Core`] if the system has no memory for it.
pub fn associate(plane: &Plane<2>, to: Association) -> Result<Conversion, Problem> {
    let mut clipped = 0;
    if !plane.alpha || plane.association == to {
        let plane = Plane { association: to, ..plane.clone() };
        return Ok(Conversion { plane, clipped, warnings: Vec::new() });
    }
    let straight = straight(plane)?;
    let colors = plane.color_channels();
    let multiplied = to == Association::Premultiplied;
    let value = |c: usize, i: usize| straight(c, i) * if multiplied && c < colors { alpha(plane, i) } else { 1.0 };
    let mut rounded = |c: usize, i: usize, max: f64| {
        let v = value(c, i);
        clipped += u64::from(max < v);
        (v + 0.5).clamp(0.0, max)
    };
    let samples = match plane.samples.depth() {
        Depth::U8 => Samples::U8(each(plane, |c, i| rounded(c, i, 255.0) as u8)?),
        Depth::U16 => Samples::U16(each(plane, |c, i| rounded(c, i, 65_535.0) as u16)?),
        Depth::F16 => Samples::F16(each(plane, |c, i| to_half(value(c, i), &mut clipped))?),
        Depth::F32 => Samples::F32(each(plane, |c, i| to_float(value(c, i), &mut clipped))?),
    };
    let plane = Plane { role: plane.role, samples, alpha: true, association: to };
    Ok(Conversion { plane, clipped, warnings: Vec::new() })
}

/// Values as stored, but colours before they were multiplied.
pub(crate) fn straight(plane: &Plane<2>) -> Result<impl Fn(usize, usize) -> f64 + '_, Problem> {
    let (colors, divided) = (plane.color_channels(), plane.is_premultiplied());
    if divided {
        let lit = |i: &usize| alpha(plane, *i) == 0.0 && (0..colors).any(|c| plane.samples.value(c, *i) != 0.0);
        if let Some(first) = (0..plane.domain().len()).find(lit) {
            let count = (first..plane.domain().len()).filter(lit).count() as u64;
            let [y, x] = plane.domain().position(first);
            return Err(Problem::LightWithoutAlpha { count, x, y });
        }
    }
    Ok(move |c: usize, i: usize| {
        let v = plane.samples.value(c, i);
        // Where nothing shows there is nothing to divide, and 0 stays 0.
        if divided && c < colors && v != 0.0 { v / alpha(plane, i) } else { v }
    })
}

/// Pixels of integers whose colours are more than the alpha that they were multiplied by. Of floats such a pixel is
/// light, and as it should be.
pub(crate) fn beyond_alpha(plane: &Plane<2>) -> u64 {
    if !plane.is_premultiplied() || matches!(plane.samples.depth(), Depth::F16 | Depth::F32) {
        return 0;
    }
    let (colors, value) = (plane.color_channels(), |c: usize, i: usize| plane.samples.value(c, i));
    let beyond = |i: &usize| (0..colors).any(|c| value(colors, *i) < value(c, *i));
    (0..plane.domain().len()).filter(beyond).count() as u64
}

/// Alpha from 0 to 1.
fn alpha(plane: &Plane<2>, i: usize) -> f64 {
    let max = match plane.samples.depth() {
        Depth::U8 => 255.0,
        Depth::U16 => 65_535.0,
        Depth::F16 | Depth::F32 => 1.0,
    };
    plane.samples.value(plane.color_channels(), i) / max
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Grid, Role};

    use super::*;

    fn rgba(association: Association, values: [u8; 4]) -> Plane<2> {
        let grid = Grid::from_vec(Domain::open([1, 1]), 4, values.to_vec()).unwrap();
        Plane { association, ..Plane::with_alpha(Role::Color, Samples::U8(grid)) }
    }

    fn values(plane: &Plane<2>) -> Vec<f64> {
        (0..4).map(|c| plane.samples.value(c, 0)).collect()
    }

    #[test]
    fn what_was_multiplied_is_divided() {
        let associated = rgba(Association::Premultiplied, [56, 52, 44, 128]);
        let straight = associate(&associated, Association::Straight).unwrap();
        assert_eq!(values(&straight.plane), [112.0, 104.0, 88.0, 128.0]);
        let back = associate(&straight.plane, Association::Premultiplied).unwrap();
        assert_eq!(back.plane, associated);
        let beyond = associate(&rgba(Association::Premultiplied, [200, 0, 0, 100]), Association::Straight).unwrap();
        assert_eq!((values(&beyond.plane)[0], beyond.clipped), (255.0, 1));
        let counts = [
            rgba(Association::Premultiplied, [200, 0, 0, 100]),
            rgba(Association::Premultiplied, [100, 0, 99, 100]),
            rgba(Association::Straight, [200, 0, 0, 100]),
        ];
        assert_eq!(counts.map(|plane| beyond_alpha(&plane)), [1, 0, 0]);
    }

    #[test]
    fn light_without_alpha_is_refused_and_nothing_is_divided_by_nothing() {
        let lit = associate(&rgba(Association::Premultiplied, [0, 9, 0, 0]), Association::Straight);
        assert!(matches!(lit, Err(Problem::LightWithoutAlpha { count: 1, x: 0, y: 0 })));
        let dark = associate(&rgba(Association::Premultiplied, [0; 4]), Association::Straight).unwrap();
        assert_eq!(values(&dark.plane), [0.0; 4]);
        let hidden = rgba(Association::Straight, [1, 2, 3, 0]);
        assert_eq!(associate(&hidden, Association::Straight).unwrap().plane, hidden, "to the bit");
    }
}
