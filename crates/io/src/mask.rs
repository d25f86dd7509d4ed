//! Masks: pictures that say which samples to use.

use std::path::Path;

use selvedge_core::{Depth, Grid, Plane};

use crate::error::{Error, Problem};
use crate::options::ReadOptions;
use crate::read::read;

/// What of a picture makes the mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaskChannel {
    /// How light it is, over black where it is transparent: white is used, black and transparent are not.
    #[default]
    Light,
    /// The first colour channel.
    Red,
    /// The second colour channel.
    Green,
    /// The third colour channel.
    Blue,
    /// Alpha: opaque is used.
    Alpha,
}

/// Reads a mask: true where the picture is at least half light, or half opaque.
///
/// # Errors
/// Those of [`read()`](crate::read()), and [`Problem::NoChannel`].
pub fn read_mask(path: impl AsRef<Path>, channel: MaskChannel, options: &ReadOptions) -> Result<Grid<bool, 2>, Error> {
    let path = path.as_ref();
    mask(&read(path, options)?.plane, channel).map_err(|p| Error::new(path, p))
}

/// The mask that a picture is: true from half of the greatest integer, or from 0.5, on. Lightness is 77, 150 and 29 of
/// 256 parts of red, green and blue, as stored.
///
/// # Errors
/// [`Problem::NoChannel`] if it has no such channel.
pub fn mask(plane: &Plane<2>, channel: MaskChannel) -> Result<Grid<bool, 2>, Problem> {
    let colors = plane.color_channels();
    let max = match plane.samples.depth() {
        Depth::U8 => 255.0,
        Depth::U16 => 65_535.0,
        Depth::F16 | Depth::F32 => 1.0,
    };
    let (wanted, place) = match channel {
        MaskChannel::Light => ("light", Some(0)),
        MaskChannel::Red => ("red", Some(0)),
        MaskChannel::Green => ("green", Some(1).filter(|c| *c < colors)),
        MaskChannel::Blue => ("blue", Some(2).filter(|c| *c < colors)),
        MaskChannel::Alpha => ("alpha", plane.alpha.then_some(colors)),
    };
    let place = place.ok_or_else(|| Problem::NoChannel {
        wanted: format!("{wanted} channel"),
        found: format!("{colors} channel(s){}", if plane.alpha { " and alpha" } else { "" }),
    })?;
    let value = |c: usize, i: usize| plane.samples.value(c, i) / max;
    let light = |i: usize| {
        let sum = if colors < 3 {
            value(0, i)
        } else {
            (77.0 * value(0, i) + 150.0 * value(1, i) + 29.0 * value(2, i)) / 256.0
        };
        if plane.alpha && !plane.is_premultiplied() { sum * value(colors, i) } else { sum }
    };
    let mut mask = Grid::try_filled(plane.domain(), 1, false)?;
    for (i, used) in mask.plane_mut(0).iter_mut().enumerate() {
        *used = 0.5 <= if channel == MaskChannel::Light { light(i) } else { value(place, i) };
    }
    Ok(mask)
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Role, Samples};

    use super::*;

    fn used(samples: Samples<2>, alpha: bool, channel: MaskChannel) -> Option<Vec<bool>> {
        let plane = Plane { alpha, ..Plane::new(Role::Scalar, samples) };
        mask(&plane, channel).ok().map(Grid::into_vec)
    }

    fn bytes(channels: usize, values: &[u8]) -> Samples<2> {
        let width = (values.len() / channels) as u32;
        Samples::U8(Grid::from_vec(Domain::open([1, width]), channels, values.to_vec()).unwrap())
    }

    #[test]
    fn white_is_used_from_half_on() {
        assert_eq!(
            used(bytes(1, &[0, 127, 128, 255]), false, MaskChannel::Light),
            Some(vec![false, false, true, true])
        );
        let words = Grid::from_vec(Domain::open([1, 2]), 1, vec![32_767, 32_768]).unwrap();
        assert_eq!(used(Samples::U16(words), false, MaskChannel::Light), Some(vec![false, true]));
        let floats = Grid::from_vec(Domain::open([1, 3]), 1, vec![0.4999, 0.5, 9.0]).unwrap();
        assert_eq!(used(Samples::F32(floats), false, MaskChannel::Light), Some(vec![false, true, true]));
    }

    #[test]
    fn transparent_is_not_used() {
        let grey_alpha = bytes(2, &[255, 255, 0, 255, 0, 255]);
        assert_eq!(used(grey_alpha.clone(), true, MaskChannel::Light), Some(vec![true, false, false]));
        assert_eq!(used(grey_alpha, true, MaskChannel::Alpha), Some(vec![true, false, true]));
    }

    #[test]
    fn channels_are_chosen_or_missing() {
        let rgb = bytes(3, &[255, 0, 0, 255, 255, 0]);
        assert_eq!(used(rgb.clone(), false, MaskChannel::Red), Some(vec![true, false]));
        assert_eq!(used(rgb.clone(), false, MaskChannel::Green), Some(vec![false, true]));
        assert_eq!(used(rgb.clone(), false, MaskChannel::Light), Some(vec![false, true]), "red and blue are dark");
        assert_eq!(used(rgb, false, MaskChannel::Alpha), None);
        assert_eq!(used(bytes(1, &[1]), false, MaskChannel::Blue), None);
    }
}
