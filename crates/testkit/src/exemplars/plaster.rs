//! Plaster: rough grain in the light of one lamp, bright on one side and dark on the other.

use selvedge_core::Plane;

use crate::color::{along, hex, scaled};
use crate::noise::Noise;
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x91a5);
/// Side of the picture, pixels.
const SIDE: u32 = 128;

/// Plaster, 128 x 128, sRGB.
pub fn plaster() -> Plane<2> {
    let light = Light {
        towards: [-0.6, -0.5, 0.6],
        sun: scaled(hex(0xfff0d6), 1.2),
        sky: scaled(hex(0xccd8e8), 0.5),
        gloss: 0.0,
    };
    Relief::of(SIDE, SIDE, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let lumps = NOISE.other(1).layers(x / 9.0, y / 9.0, 4);
    let pits = NOISE.other(2).smooth(x / 5.0, y / 5.0);
    let height = 3.2 * lumps - 1.6 * (pits - 0.35).max(0.0);
    let color =
        along(&[hex(0xa08a6e), hex(0xc9b592), hex(0xe0d3b6)], 0.5 + 0.5 * NOISE.other(3).layers(x / 6.0, y / 6.0, 3));
    // The lamp stands left of the picture and above it: three times as bright near it as far from it.
    let side = f64::from(SIDE);
    let far = ((x + 0.4 * side) * (x + 0.4 * side) + (y + 0.5 * side) * (y + 0.5 * side)) / (side * side);
    Texel { height, albedo: scaled(color, 1.6 / (0.7 + far)), roughness: 1.0 }
}
