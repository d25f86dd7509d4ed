//! Letters: lines of print in an invented hand, words of unlike lengths, black on paper.

use selvedge_core::Plane;

use crate::color::{blend, hex, scaled};
use crate::noise::{Noise, ramp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x7e87);
/// Distance between lines and width of a letter, pixels.
const LINE: f64 = 15.0;
const LETTER: f64 = 8.0;
/// Letters of the alphabet; each is of three strokes between the points of a grid of 3 by 3.
const LETTERS: u32 = 19;
/// Half the width of a stroke, pixels.
const STROKE: f64 = 0.75;

/// Letters, 128 x 128, sRGB.
pub fn letters() -> Plane<2> {
    let light = Light { towards: [0.0, -0.4, 1.0], sun: hex(0xffffff), sky: scaled(hex(0xf4f6ff), 0.2), gloss: 0.0 };
    Relief::of(128, 128, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let line = (y / LINE).floor() as i32;
    let column = ((x + f64::from(line.rem_euclid(3)) * 2.5) / LETTER).floor() as i32;
    let at = (
        x + f64::from(line.rem_euclid(3)) * 2.5 - f64::from(column) * LETTER,
        y - f64::from(line) * LINE - 0.5 * (LINE - 9.0),
    );
    let paper = scaled(hex(0xe9e2cf), 0.95 + 0.05 * NOISE.other(1).layers(x / 9.0, y / 9.0, 3));
    let blank = NOISE.other(2).cell(column, line) < 0.17;
    let ink = if blank { 0.0 } else { ink(NOISE.other(3).bits(column, line) % LETTERS, at) };
    let worn = 0.9 + 0.1 * NOISE.other(4).smooth(x / 2.0, y / 2.0);
    Texel { height: 0.0, albedo: blend(paper, hex(0x1c1a18), ink * worn), roughness: 1.0 }
}

/// How black a letter is at a point of its box.
fn ink(letter: u32, at: (f64, f64)) -> f64 {
    let node = |k: u32| {
        let place = NOISE.other(20).bits(letter as i32, k as i32) % 9;
        (1.0 + 2.2 * f64::from(place % 3), 0.8 + 3.6 * f64::from(place / 3))
    };
    // One upright or bow to each letter, so that none is a crumb.
    let spine = if letter.is_multiple_of(2) { (1.0, 1.0) } else { (5.4, 1.0) };
    let strokes = [(spine, (spine.0, 8.0)), (node(0), node(1)), (node(1), node(2))];
    let nearest = strokes.iter().map(|&(a, b)| distance(at, a, b)).fold(f64::INFINITY, f64::min);
    1.0 - ramp(STROKE - 0.35, STROKE + 0.35, nearest)
}

/// From a point to the stroke between two.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (along, to) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
    let length = along.0 * along.0 + along.1 * along.1;
    let t = if length > 0.0 { ((along.0 * to.0 + along.1 * to.1) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off = (to.0 - t * along.0, to.1 - t * along.1);
    (off.0 * off.0 + off.1 * off.1).sqrt()
}
