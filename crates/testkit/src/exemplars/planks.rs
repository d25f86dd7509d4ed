//! Planks: boards one below the other, each of its own shade, which drifts along it; ring lines, pores, dark gaps.

use selvedge_core::Plane;

use crate::color::{along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0xb0a2d);
/// Height of a board, pixels; three to a picture, so that what fits below one fits below few others.
const BOARD: f64 = 36.0;

/// Planks, 128 x 128, sRGB.
pub fn planks() -> Plane<2> {
    let light = Light {
        towards: [-0.3, -0.6, 0.9],
        sun: scaled(hex(0xfff1dc), 1.1),
        sky: scaled(hex(0xd6e2f0), 0.5),
        gloss: 0.06,
    };
    Relief::of(128, 128, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let board = (y / BOARD).floor() as i32;
    let own = |k: u32| NOISE.other(k).cell(board, 3);
    let from_gap = (y - f64::from(board) * BOARD).min(f64::from(board + 1) * BOARD - y);
    // Rings are long along the board: a shift along it is hardly seen, a shift across it at once.
    let (u, v) = (x / 90.0, y / 2.6 + 1.1 * NOISE.other(9).layers(x / 60.0, f64::from(board) * 5.0, 2));
    let ring = NOISE.other(10).layers(u + 7.0 * own(0), v, 3);
    let pores = NOISE.other(11).smooth(x / 3.5, y * 1.2);
    let drift = NOISE.other(12).layers(x / 48.0, f64::from(board) * 11.0, 2);
    let shade = 0.25 + 0.5 * own(1) + 0.45 * drift;
    let color = along(&[hex(0x6a3d1c), hex(0x9a6430), hex(0xc08a4a)], shade);
    let color = scaled(color, (1.0 + 0.28 * ring - 0.10 * ramp(0.3, 0.9, pores)) * lerp(0.85, 1.15, own(2)));
    let gap = 1.0 - ramp(0.5, 1.6, from_gap);
    let height = 1.2 * ramp(0.6, 3.0, from_gap) + 0.12 * ring - 4.0 * gap;
    Texel { height, albedo: blend(color, hex(0x140c06), gap), roughness: 0.7 }
}
