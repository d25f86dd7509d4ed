//! Scales: overlapping rows with a keel each, green to copper, glossy, no two alike.

use selvedge_core::Plane;

use crate::color::{Rgb, along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x5ca1e);
/// Distance between scales in a row, and between rows, pixels. Rows are moved by half a scale, so that the lattice is
/// oblique; half a pixel in a row's height keeps it from being one of whole samples.
const ACROSS: f64 = 22.0;
const DOWN: f64 = 11.5;

/// Scales, 192 x 192, sRGB.
pub fn scales() -> Plane<2> {
    Relief::of(192, 192, surface).lit(&daylight())
}

/// A piece of the same scales under a hard sun, 96 x 96, linear half floats; highlights are many times white.
pub fn scales_hdr() -> Plane<2> {
    let sun = daylight();
    let light = Light { sun: scaled(sun.sun, 2.5), gloss: 6.0, ..sun };
    Relief::of(96, 96, |x, y| surface(x + 48.0, y + 40.0)).lit_linear(&light)
}

fn daylight() -> Light {
    Light {
        towards: [-0.45, -0.7, 0.62],
        sun: scaled(hex(0xfff3dd), 1.6),
        sky: scaled(hex(0xc2d6e6), 0.65),
        gloss: 0.55,
    }
}

fn surface(x: f64, y: f64) -> Texel {
    let sway = NOISE.other(1);
    let (x2, y2) = (x + 3.0 * sway.smooth(x / 60.0, y / 60.0), y + 3.0 * sway.other(1).smooth(x / 60.0, y / 60.0));
    let row = (y2 / DOWN).floor() as i32;
    // The tip of an upper row lies on the roots of the lower: the uppermost row that reaches here is seen.
    for row in row - 3..=row {
        let shift = if row.rem_euclid(2) == 0 { 0.0 } else { 0.5 };
        let column = (x2 / ACROSS - shift).floor() as i32;
        let near = (column - 1..=column + 1).filter_map(|c| scale_texel(row, c, shift, x2, y2));
        if let Some(texel) = near.max_by(|a, b| a.height.total_cmp(&b.height)) {
            return texel;
        }
    }
    Texel { height: -4.0, albedo: hex(0x101410), roughness: 0.9 }
}

/// The scale `(row, column)` at a point, or nothing where it does not reach.
fn scale_texel(row: i32, column: i32, shift: f64, x: f64, y: f64) -> Option<Texel> {
    let own = |k: u32| NOISE.other(50 + k).cell(column, row);
    let center = (f64::from(column) + 0.5 + shift + 0.10 * (own(0) - 0.5)) * ACROSS;
    let root = (f64::from(row) + 0.16 * (own(1) - 0.5)) * DOWN;
    let (half, length) = (ACROSS * lerp(0.53, 0.60, own(2)), DOWN * lerp(2.25, 2.6, own(3)));
    let lean = 0.16 * (own(4) - 0.5);
    let v = (y - root) / length;
    let u = (x - center) / half - lean * v;
    let edge = outline(u, v) + 0.02 * NOISE.other(2).smooth(x / 3.0, y / 3.0);
    if edge <= 0.0 || v < 0.0 {
        return None;
    }
    let rim = 1.0 - ramp(0.0, 0.13, edge);
    let keel = libm::exp(-(u * u) / 0.010) * ramp(0.95, 0.55, v);
    let rays = libm::sin(u / (0.35 + v) * 16.0 + 6.0 * own(5));
    let grain = NOISE.other(3).layers(x / 2.2, y / 2.2, 2);
    let dome = 1.0 - u * u;
    let height =
        5.2 * v + 2.4 * dome + 0.9 * keel - 0.9 * rim * rim + 0.14 * rays * v + 0.2 * grain + 0.8 * (own(6) - 0.5);
    let mut albedo = color(u, v, (own(7), own(8)), (x, y));
    albedo = scaled(albedo, (1.0 + 0.10 * rays + 0.16 * grain) * lerp(0.75, 1.2, own(9)));
    albedo = blend(albedo, hex(0x1d1a10), 0.55 * rim);
    Some(Texel { height, albedo, roughness: (0.36 + 0.2 * own(10) + 0.12 * grain).clamp(0.1, 1.0) })
}

/// Positive inside: straight flanks above, a blunt arch at the tip.
fn outline(u: f64, v: f64) -> f64 {
    let arch = ((v - 0.42) / 0.58).max(0.0);
    1.0 - (u * u + arch * arch).sqrt().max(u.abs())
}

/// Deep teal at the root over green to a warm tip, with drifts of colour over many scales.
fn color(u: f64, v: f64, (hue, tint): (f64, f64), (x, y): (f64, f64)) -> Rgb {
    let drift = NOISE.other(4).layers(x / 75.0, y / 75.0, 2);
    let body = along(
        &[hex(0x1d4a50), hex(0x2c6b52), hex(0x5d8a3e), hex(0x9aa044)],
        0.30 + 0.45 * (hue - 0.5) + 0.55 * drift + 0.35 * (v - 0.5),
    );
    let tip = along(&[hex(0xb7833a), hex(0xa9552d)], tint);
    blend(body, tip, ramp(0.62, 1.0, v + 0.25 * u * u + 0.25 * (tint - 0.5)) * 0.75)
}
