//! Tiles: square and glazed, no two of one shade, in a straight bond with grey joints.

use selvedge_core::Plane;

use crate::color::{along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x711e5);
/// Distance between tiles, pixels.
const PITCH: f64 = 30.5;

/// Tiles, 128 x 128, sRGB.
pub fn tiles() -> Plane<2> {
    let light = Light {
        towards: [-0.55, -0.55, 0.8],
        sun: scaled(hex(0xfff6e8), 1.1),
        sky: scaled(hex(0xcfdcec), 0.6),
        gloss: 0.35,
    };
    Relief::of(128, 128, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let (i, j) = ((x / PITCH).floor() as i32, (y / PITCH).floor() as i32);
    let own = |k: u32| NOISE.other(k).cell(i, j);
    let inside = |v: f64, n: i32| (v - f64::from(n) * PITCH).min(f64::from(n + 1) * PITCH - v);
    let from_joint = inside(x + 0.5 * (own(0) - 0.5), i).min(inside(y + 0.5 * (own(1) - 0.5), j));
    let joint = 1.0 - ramp(0.9, 1.5, from_joint);
    let cloud = NOISE.other(5).layers(x / 12.0 + 9.0 * own(2), y / 12.0 + 9.0 * own(3), 3);
    let speck = NOISE.other(6).smooth(x / 1.2, y / 1.2);
    let hues = [hex(0x2f5f6e), hex(0x4e8a86), hex(0x86ab8f), hex(0xc2bd96), hex(0xb98a5c)];
    let glaze = scaled(along(&hues, own(4) + 0.12 * cloud), (1.0 + 0.22 * cloud) * lerp(0.85, 1.15, own(7)));
    let grout = scaled(hex(0x8f8a80), 1.0 + 0.18 * speck + 0.2 * NOISE.other(8).layers(x / 4.0, y / 4.0, 2));
    let bow = 0.5 * NOISE.other(9).smooth(x / 15.0 + 31.0 * own(2), y / 15.0);
    Texel {
        height: 2.2 * ramp(0.9, 3.2, from_joint) + bow + 0.05 * speck,
        albedo: blend(glaze, grout, joint),
        roughness: lerp(0.25, 1.0, joint),
    }
}
