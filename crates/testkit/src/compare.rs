//! Two pictures beside each other: where they differ, by how much, and a picture that shows it.

use selvedge_core::{Domain, Plane, Role, Samples};

use crate::color::encode;
use crate::picture::{describe, plane8};

/// How far two pictures of the same shape are apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Pixels that differ in any channel.
    pub pixels: usize,
    /// All pixels.
    pub of: usize,
    /// The greatest difference of each channel, in units of the samples.
    pub greatest: Vec<f64>,
    /// The first differing pixel in row order, as `[y, x]`.
    pub first: Option<[u32; 2]>,
}

/// Compares two pictures sample by sample. NaN equals NaN.
///
/// # Errors
/// A sentence if their shapes, channels or depths are not the same.
pub fn compare(expected: &Plane<2>, actual: &Plane<2>) -> Result<Difference, String> {
    if describe(expected) != describe(actual) {
        return Err(format!("{} expected, {} found", describe(expected), describe(actual)));
    }
    let domain = expected.domain();
    let channels = expected.samples.channels();
    let mut difference = Difference { pixels: 0, of: domain.len(), greatest: vec![0.0; channels], first: None };
    for i in 0..domain.len() {
        let mut differs = false;
        for (c, greatest) in difference.greatest.iter_mut().enumerate() {
            let apart = distance(expected.samples.value(c, i), actual.samples.value(c, i));
            differs |= apart > 0.0;
            *greatest = greatest.max(apart);
        }
        if differs {
            difference.pixels += 1;
            difference.first.get_or_insert(domain.position(i));
        }
    }
    Ok(difference)
}

fn distance(a: f64, b: f64) -> f64 {
    match (a.is_nan(), b.is_nan()) {
        (true, true) => 0.0,
        (false, false) if a == b => 0.0,
        (false, false) => (a - b).abs(),
        _ => f64::INFINITY,
    }
}

/// Pixels between the three pictures of a triptych.
const GUTTER: u32 = 4;
/// Colour of the gutters, and of what one picture has and the other has not.
const PAPER: [u8; 3] = [40, 40, 48];

/// Expected, difference, actual, side by side as 8-bit RGB. Where samples differ the middle is white (the greatest
/// difference) to grey (the least that there is); where they agree it is black.
pub fn triptych(expected: &Plane<2>, actual: &Plane<2>) -> Plane<2> {
    let size = |axis: usize| expected.domain().shape[axis].max(actual.domain().shape[axis]);
    let (height, width) = (size(0), size(1));
    let total = [height, 3 * width + 2 * GUTTER];
    let domain = Domain::open(total);
    let mut planes = PAPER.map(|v| vec![v; domain.len()]);
    let greatest = |c: f64, at: [u32; 2]| c.max(apart(expected, actual, at));
    let scale = Domain::open([height, width]).positions().fold(0.0, greatest);
    for at in Domain::open([height, width]).positions() {
        let apart = apart(expected, actual, at);
        let grey = if apart > 0.0 { 64 + (191.0 * (apart / scale).min(1.0)) as u8 } else { 0 };
        for (third, rgb) in [pixel(expected, at), Some([grey; 3]), pixel(actual, at)].into_iter().enumerate() {
            let to = domain.index([at[0], at[1] + third as u32 * (width + GUTTER)]);
            planes.iter_mut().zip(rgb.unwrap_or(PAPER)).for_each(|(plane, v)| plane[to] = v);
        }
    }
    plane8(Role::Color, total[1], total[0], planes.concat())
}

/// The picture as 8-bit RGB or grey, for the eye: high bytes of wide integers, floats as linear light whose highlights
/// are dimmed, no alpha.
pub fn preview(plane: &Plane<2>) -> Plane<2> {
    let [height, width] = plane.domain().shape;
    let pixels: Vec<[u8; 3]> = plane.domain().positions().filter_map(|at| pixel(plane, at)).collect();
    let channels = if plane.color_channels() == 3 { 3 } else { 1 };
    let samples = (0..channels).flat_map(|c| pixels.iter().map(move |rgb| rgb[c])).collect();
    plane8(plane.role, width, height, samples)
}

/// The greatest difference of a pixel's channels; the depth's whole range where only one of the pictures has it.
fn apart(a: &Plane<2>, b: &Plane<2>, at: [u32; 2]) -> f64 {
    let (Some(ia), Some(ib)) = (place(a, at), place(b, at)) else { return f64::MAX };
    let channels = a.samples.channels().min(b.samples.channels());
    (0..channels).map(|c| distance(a.samples.value(c, ia), b.samples.value(c, ib))).fold(0.0, f64::max)
}

fn place(plane: &Plane<2>, at: [u32; 2]) -> Option<usize> {
    plane.domain().contains(at).then(|| plane.domain().index(at))
}

/// Brightens what is dark and dims what is brighter than white; NaN is black.
fn soft(v: f64) -> f64 {
    let v = v.max(0.0);
    if v.is_infinite() { 1.0 } else { v / (1.0 + v) }
}

/// A pixel as 8-bit RGB: high bytes of wide integers, floats as linear light whose highlights are dimmed.
fn pixel(plane: &Plane<2>, at: [u32; 2]) -> Option<[u8; 3]> {
    let i = place(plane, at)?;
    let level = |c: usize| match &plane.samples {
        Samples::U8(g) => g.plane(c)[i],
        Samples::U16(g) => (g.plane(c)[i] >> 8) as u8,
        floats => encode(soft(floats.value(c, i))),
    };
    Some(if plane.color_channels() == 3 { [level(0), level(1), level(2)] } else { [level(0); 3] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::bytes;
    use crate::simple::{constant, gradient, noise};

    #[test]
    fn equal_pictures_do_not_differ() {
        let a = noise(7, 5, 3);
        let same = compare(&a, &a).expect("the same shape");
        assert_eq!((same.pixels, same.of, same.first), (0, 35, None));
    }

    #[test]
    fn the_first_and_the_greatest_difference_are_found() {
        let a = plane8(Role::Color, 3, 2, vec![0, 0, 0, 0, 0, 0]);
        let b = plane8(Role::Color, 3, 2, vec![0, 0, 0, 0, 9, 4]);
        let found = compare(&a, &b).expect("the same shape");
        assert_eq!(found, Difference { pixels: 2, of: 6, greatest: vec![9.0], first: Some([1, 1]) });
        assert!(compare(&a, &gradient(2, 3)).is_err_and(|what| what == "3x2, 1 x u8 expected, 2x3, 1 x u8 found"));
    }

    #[test]
    fn a_triptych_shows_the_differing_pixel_alone() {
        let a = plane8(Role::Color, 2, 1, vec![10, 20]);
        let b = plane8(Role::Color, 2, 1, vec![10, 30]);
        let shown = triptych(&a, &b);
        assert_eq!(shown.domain().shape, [1, 14]);
        let red = &bytes(&shown)[..14];
        assert_eq!((&red[..2], &red[6..8], &red[12..]), (&[10, 20][..], &[0, 255][..], &[10, 30][..]));
    }

    #[test]
    fn pictures_of_other_sizes_stand_beside_each_other() {
        let shown = triptych(&constant(2, 2, 9), &constant(3, 1, 9));
        assert_eq!(shown.domain().shape, [2, 17]);
        assert_eq!(bytes(&shown)[7], 0, "both have the corner");
        assert_eq!(bytes(&shown)[9], 255, "only one has the third column");
    }
}
