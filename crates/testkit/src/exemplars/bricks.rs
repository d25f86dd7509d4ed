//! Bricks: a weathered running bond as a material of four registered planes.

use selvedge_core::Plane;

use crate::color::{Rgb, along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::relief::{Relief, Texel};

const NOISE: Noise = Noise::new(0xb41c);
/// Brick and joint, pixels: some five bricks and eleven courses in a picture. Neither divides its side, and a lattice
/// of whole samples drifts off the courses.
const LENGTH: f64 = 43.0;
const COURSE: f64 = 17.5;

/// The planes of one wall, sample upon sample.
#[derive(Debug)]
pub struct Bricks {
    /// Colour without light, sRGB, 8 bits.
    pub albedo: Plane<2>,
    /// Tangent-space normals, x right, y up, z out, 8 bits.
    pub normal: Plane<2>,
    /// Height, 16-bit grey.
    pub height: Plane<2>,
    /// Roughness, 8-bit grey.
    pub roughness: Plane<2>,
}

/// Bricks, 192 x 192.
pub fn bricks() -> Bricks {
    let wall = Relief::of(192, 192, surface);
    Bricks {
        albedo: wall.albedo(),
        normal: wall.normal(),
        height: wall.height16(-4.0, 6.0),
        roughness: wall.roughness(),
    }
}

fn surface(x: f64, y: f64) -> Texel {
    let sag = NOISE.other(1);
    let y2 = y + 1.0 * sag.smooth(x / 70.0, y / 50.0);
    let brick = brick_texel(x + 0.6 * sag.other(1).smooth(x / 9.0, y / 9.0), y2, (x, y));
    let mortar = mortar_texel(x, y);
    if brick.height > mortar.height { brick } else { mortar }
}

/// The joint left of brick `i` in a course: half a brick further each course, never quite.
fn joint(i: i32, course: i32) -> f64 {
    let bond = if course.rem_euclid(2) == 0 { 0.0 } else { 0.5 };
    (f64::from(i) + bond + 0.13 * NOISE.other(2).signed(i, course)) * LENGTH
}

fn brick_texel(x: f64, y: f64, at: (f64, f64)) -> Texel {
    let course = (y / COURSE).floor() as i32;
    let guess = (x / LENGTH).floor() as i32;
    let i = (guess - 2..=guess + 1).rev().find(|&i| joint(i, course) <= x).unwrap_or(guess - 2);
    let own = |k: u32| NOISE.other(40 + k).cell(i, course);
    let (left, right) = (joint(i, course), joint(i + 1, course));
    let middle = (f64::from(course) + 0.5) * COURSE + 1.0 * (own(0) - 0.5);
    let half = ((right - left) / 2.0 - 1.5 - 0.7 * own(1), COURSE / 2.0 - 1.5 - 0.7 * own(2));
    let (u, v) = (x - (left + right) / 2.0, y - middle);
    let turn = 0.035 * (own(3) - 0.5);
    let rough = 0.9 * NOISE.other(3).layers(at.0 / 6.0, at.1 / 6.0, 3);
    let chips = 3.4 * ramp(0.42, 0.75, NOISE.other(4).layers(at.0 / 9.0, at.1 / 9.0, 2));
    let inside = rounded(u + turn * v, v - turn * u, half) + rough * 0.6 - chips;
    if inside <= 0.0 {
        return Texel { height: -9.0, ..Texel::default() };
    }
    let t = (inside / 2.6).min(1.0);
    let pits = ramp(0.45, 0.75, NOISE.other(5).layers(at.0 / 3.2, at.1 / 3.2, 2));
    let grain = NOISE.other(6).layers(at.0 / 1.8, at.1 / 1.8, 2);
    let swell = NOISE.other(7).layers(at.0 / 15.0 + 9.0 * own(4), at.1 / 15.0, 3);
    let tilt = 0.03 * (own(5) - 0.5) * u + 0.08 * (own(6) - 0.5) * v;
    let height = 3.2 * (1.0 - (1.0 - t) * (1.0 - t)).sqrt() + 0.7 * swell + 0.22 * grain - 1.1 * pits
        + tilt
        + 1.1 * (own(7) - 0.5);
    let albedo = brick_color((own(8), own(9), own(10)), u / half.0, at, (swell, grain, pits), t);
    Texel { height, albedo, roughness: 0.74 + 0.10 * grain + 0.12 * pits - 0.22 * ramp(0.9, 1.0, own(8)) }
}

/// Inside distance of a box with rounded corners.
fn rounded(u: f64, v: f64, half: (f64, f64)) -> f64 {
    const R: f64 = 2.6;
    let (dx, dy) = (u.abs() - half.0 + R, v.abs() - half.1 + R);
    let corner = (dx.max(0.0) * dx.max(0.0) + dy.max(0.0) * dy.max(0.0)).sqrt();
    R - corner - dx.max(dy).min(0.0)
}

fn brick_color(own: (f64, f64, f64), u: f64, at: (f64, f64), (swell, grain, pits): (f64, f64, f64), t: f64) -> Rgb {
    let clay = along(&[hex(0x7c3526), hex(0x9c4a32), hex(0xb3603f), hex(0xc0794f), hex(0xa4523a)], own.0);
    let burnt = ramp(0.80, 0.86, own.1);
    let mut color = blend(clay, hex(0x4d3230), 0.8 * burnt);
    // Heat left a darker belly on some bricks and paler ends on others.
    color = scaled(color, 1.0 + (own.2 - 0.5) * 0.7 * (1.0 - 2.0 * u * u));
    color = blend(color, hex(0xc98d63), 0.35 * ramp(0.1, 0.7, swell));
    color = scaled(color, 1.0 + 0.22 * grain + 0.18 * swell - 0.35 * pits);
    let lime = ramp(0.22, 0.75, NOISE.other(8).layers(at.0 / 34.0, at.1 / 24.0, 4) + 0.18 * grain);
    color = blend(color, hex(0xcfc4b2), 0.42 * lime);
    let soot = ramp(0.25, 0.9, NOISE.other(9).layers(at.0 / 50.0, at.1 / 38.0, 3));
    blend(color, hex(0x3a2c27), 0.4 * soot + 0.25 * (1.0 - t))
}

fn mortar_texel(x: f64, y: f64) -> Texel {
    let grain = NOISE.other(20).smooth(x / 1.2, y / 1.2);
    let lumps = NOISE.other(21).layers(x / 7.0, y / 7.0, 3);
    let wet = ramp(0.0, 0.8, NOISE.other(22).layers(x / 40.0, y / 40.0, 3));
    let shade = along(&[hex(0x8d8371), hex(0xb3a893), hex(0xcbc1ad)], 0.5 + 0.5 * lumps - 0.35 * wet);
    Texel {
        height: lerp(-0.6, 0.5, 0.5 + 0.8 * lumps) + 0.3 * grain,
        albedo: scaled(shade, 1.0 + 0.22 * grain),
        roughness: 0.93,
    }
}
