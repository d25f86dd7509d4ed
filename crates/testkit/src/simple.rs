//! Pictures of one idea each, for tests: what the right answer is can be seen from the code. All 8-bit.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::noise::Noise;
use crate::picture::plane8;

/// Every pixel `value`: all patches tie.
pub fn constant(width: u32, height: u32, value: u8) -> Plane<2> {
    grey(width, height, |_, _| value)
}

/// RGB and alpha, all 0: nothing in it is valid.
pub fn transparent(width: u32, height: u32) -> Plane<2> {
    let nothing = Grid::try_filled(Domain::open([height, width]), 4, 0).expect("small");
    Plane::with_alpha(Role::Color, Samples::U8(nothing))
}

/// Black and white squares of `cell` pixels; the pixel `(0, 0)` is black.
///
/// # Panics
/// If `cell` is 0.
pub fn checker(width: u32, height: u32, cell: u32) -> Plane<2> {
    grey(width, height, |x, y| if (x / cell + y / cell).is_multiple_of(2) { 0 } else { 255 })
}

/// Upright stripes, `period` pixels from one to the next, the left half of each black.
///
/// # Panics
/// If `period` is 0.
pub fn stripes(width: u32, height: u32, period: u32) -> Plane<2> {
    grey(width, height, |x, _| if x % period * 2 < period { 0 } else { 255 })
}

/// From black on the left to white on the right; one column is black.
pub fn gradient(width: u32, height: u32) -> Plane<2> {
    let last = width.saturating_sub(1).max(1);
    grey(width, height, |x, _| (x * 255 / last) as u8)
}

/// Independent random pixels, grey.
pub fn noise(width: u32, height: u32, seed: u32) -> Plane<2> {
    let noise = Noise::new(seed);
    grey(width, height, |x, y| (noise.bits(x as i32, y as i32) >> 24) as u8)
}

/// Independent random pixels, RGB.
pub fn noise_rgb(width: u32, height: u32, seed: u32) -> Plane<2> {
    let planes = [0, 1, 2].map(|c| Noise::new(seed).other(c));
    let samples = planes.iter().flat_map(|n| samples(width, height, |x, y| (n.bits(x as i32, y as i32) >> 24) as u8));
    plane8(Role::Color, width, height, samples.collect())
}

/// Smooth random spots about `size` pixels wide, RGB: a texture whose patches fit together many ways.
pub fn spots(width: u32, height: u32, size: u32, seed: u32) -> Plane<2> {
    let scale = 1.0 / f64::from(size.max(1));
    let level = |n: Noise, x: u32, y: u32| 127.5 + 127.5 * n.smooth(f64::from(x) * scale, f64::from(y) * scale);
    let planes = [0, 1, 2].map(|c| Noise::new(seed).other(c));
    let samples = planes.iter().flat_map(|n| samples(width, height, |x, y| level(*n, x, y).round() as u8));
    plane8(Role::Color, width, height, samples.collect())
}

fn grey(width: u32, height: u32, at: impl Fn(u32, u32) -> u8) -> Plane<2> {
    plane8(Role::Color, width, height, samples(width, height, at).collect())
}

fn samples(width: u32, height: u32, at: impl Fn(u32, u32) -> u8) -> impl Iterator<Item = u8> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y))).map(move |(x, y)| at(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::bytes;

    #[track_caller]
    fn check(picture: &Plane<2>, expected: &[u8]) {
        assert_eq!(bytes(picture), expected);
    }

    #[test]
    fn simple_pictures_are_what_they_say() {
        check(&checker(4, 2, 1), &[0, 255, 0, 255, 255, 0, 255, 0]);
        check(&stripes(6, 1, 3), &[0, 0, 255, 0, 0, 255]);
        check(&gradient(3, 2), &[0, 127, 255, 0, 127, 255]);
        check(&gradient(1, 1), &[0]);
        check(&constant(2, 1, 7), &[7, 7]);
    }

    #[test]
    fn noise_fills_the_range_and_hangs_on_its_seed() {
        let picture = noise(64, 64, 1);
        let samples = bytes(&picture);
        let mean = samples.iter().map(|&v| f64::from(v)).sum::<f64>() / 4096.0;
        assert!((mean - 127.5).abs() < 5.0, "mean {mean}");
        assert!(samples.contains(&0) && samples.contains(&255));
        assert_ne!(noise(64, 64, 1), noise(64, 64, 2));
    }
}
