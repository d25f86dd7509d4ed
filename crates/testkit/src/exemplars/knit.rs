//! Knit: stocking stitch in melange yarn, columns of stitches that lean to each other.

use selvedge_core::Plane;

use crate::color::{along, hex, scaled};
use crate::noise::{Noise, lerp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x4217);
/// Distance between columns, and between rows, pixels; no whole numbers.
const ACROSS: f64 = 15.4;
const DOWN: f64 = 11.3;

/// Knit, 128 x 128, sRGB.
pub fn knit() -> Plane<2> {
    let light = Light {
        towards: [-0.5, -0.6, 0.7],
        sun: scaled(hex(0xfff4e4), 1.25),
        sky: scaled(hex(0xd4dcec), 0.55),
        gloss: 0.0,
    };
    Relief::of(128, 128, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let sway = NOISE.other(1);
    let (x, y) = (x + 1.5 * sway.smooth(x / 40.0, y / 40.0), y + 1.5 * sway.other(1).smooth(x / 40.0, y / 40.0));
    let column = (x / ACROSS).floor() as i32;
    let right = x / ACROSS - f64::from(column) > 0.5;
    let legs = (-1..=1).map(|k| leg(column, (y / DOWN).floor() as i32 + k, right, x, y));
    let bottom = Texel { height: -5.0, albedo: hex(0x0c1418), roughness: 1.0 };
    legs.fold(bottom, |top, leg| if top.height < leg.height { leg } else { top })
}

/// One of the two legs of a stitch: a drop that leans towards the middle of its column below.
fn leg(column: i32, row: i32, right: bool, x: f64, y: f64) -> Texel {
    let side = if right { 1.0 } else { -1.0 };
    let own = |k: u32| NOISE.other(10 + k).cell(2 * column + i32::from(right), row);
    let center = ((f64::from(column) + 0.5 + 0.25 * side) * ACROSS, (f64::from(row) + 0.5 + 0.06 * own(0)) * DOWN);
    let (dx, dy) = (side * (x - center.0), y - center.1);
    // Along the leg, which leans by 26 degrees, and across it.
    let (along_it, across) = (0.9 * dy - 0.44 * dx, 0.9 * dx + 0.44 * dy);
    let (u, v) = (across / (0.245 * ACROSS), along_it / (0.80 * DOWN));
    let inside = 1.0 - u * u - v * v;
    if inside <= 0.0 {
        return Texel { height: -9.0, albedo: [0.0; 3], roughness: 1.0 };
    }
    let strand = libm::sin(2.1 * along_it + 2.4 * across + 6.0 * own(1));
    let fibre = NOISE.other(30).layers(x / 1.6, y / 1.6, 2);
    let melange = 0.5 + 0.9 * NOISE.other(31).layers(f64::from(column) * 3.0 + y / 20.0, f64::from(row) * 2.3, 2);
    let color = along(&[hex(0x27506a), hex(0x3d7f8e), hex(0x86b3a6)], melange + 0.25 * (own(2) - 0.5));
    let shade = (1.0 + 0.10 * strand + 0.22 * fibre) * lerp(0.55, 1.05, inside.sqrt());
    let height = 3.6 * inside.sqrt() - 0.9 * v + 0.25 * strand + 0.2 * fibre;
    Texel { height, albedo: scaled(color, shade), roughness: 1.0 }
}
