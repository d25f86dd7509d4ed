//! Weave: a 2/2 twill of indigo warp and undyed weft, every yarn its own width, twist and shade.

use selvedge_core::Plane;

use crate::color::{Rgb, along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0x77ea);
/// Distance between yarns, pixels: as fine as shows over, under and twist, and no whole number, so that neighbouring
/// yarns are sampled differently.
const PITCH: f64 = 9.6;

/// Weave, 192 x 192, sRGB.
pub fn weave() -> Plane<2> {
    let light = Light {
        towards: [-0.5, -0.62, 0.75],
        sun: scaled(hex(0xfff4e2), 1.2),
        sky: scaled(hex(0xdbe4f0), 0.55),
        gloss: 0.03,
    };
    Relief::of(192, 192, surface).lit(&light)
}

fn surface(x: f64, y: f64) -> Texel {
    let sway = NOISE.other(1);
    let (u, v) = (x + 1.8 * sway.layers(x / 37.0, y / 37.0, 2), y + 1.8 * sway.other(1).layers(x / 37.0, y / 37.0, 2));
    let warp = yarn(u, v, false);
    let weft = yarn(v, u, true);
    if warp.height > weft.height { warp } else { weft }
}

/// The yarn that runs along `along`, seen at `across`.
fn yarn(across: f64, along_it: f64, weft: bool) -> Texel {
    let noise = NOISE.other(if weft { 200 } else { 100 });
    let which = (across / PITCH).floor() as i32;
    let own = |k: u32| noise.other(k).cell(which, 7);
    let bend = noise.other(20).smooth(f64::from(which) * 7.3, along_it / 19.0);
    let center = (f64::from(which) + 0.5) * PITCH + 0.7 * bend + 0.6 * (own(0) - 0.5);
    let slub = noise.other(21).layers(f64::from(which) * 3.1, along_it / 24.0, 2);
    let half = PITCH * (0.52 + 0.05 * (own(1) - 0.5) + 0.10 * slub);
    let side = (across - center) / half;
    if side.abs() >= 1.0 {
        return Texel { height: -6.0, albedo: hex(0x120f12), roughness: 1.0 };
    }
    let round = (1.0 - side * side).sqrt();
    let lift = over(which, along_it, weft);
    let (fiber, strand) = twist(noise, which, side, along_it, own(2));
    let height = 1.5 * lift + 3.4 * round + (0.22 * strand + 0.25 * fiber) * round * ramp(-0.6, 0.6, lift);
    let mut color = color_of(weft, own(3), slub);
    color = scaled(
        color,
        (1.0 + 0.11 * strand + 0.30 * fiber) * lerp(0.55, 1.0, round) * lerp(0.6, 1.0, (lift + 1.0) / 2.0),
    );
    let worn = ramp(0.6, 1.4, lift * round + 0.5 * fiber);
    Texel { height, albedo: blend(color, hex(0xd9d3c4), 0.14 * worn), roughness: 0.8 }
}

/// Height of the yarn's middle, -1 under to 1 over: two over, two under, one further each row.
fn over(which: i32, along_it: f64, weft: bool) -> f64 {
    let at = along_it / PITCH - 0.5;
    let crossing = at.floor() as i32;
    let up = |k: i32| {
        let (row, column) = if weft { (which, k) } else { (k, which) };
        let warp_is_over = (row - column).rem_euclid(4) < 2;
        if warp_is_over != weft { 1.0 } else { -1.0 }
    };
    lerp(up(crossing), up(crossing + 1), ramp(0.12, 0.88, at - f64::from(crossing)))
}

/// Fine fibres and the coarser strands they form, both running round the yarn at an angle.
fn twist(noise: Noise, which: i32, side: f64, along_it: f64, phase: f64) -> (f64, f64) {
    let turn = along_it + 3.0 * side + 0.9 * noise.other(30).smooth(along_it / 6.0, f64::from(which) * 5.0);
    let strand = libm::sin(turn * (std::f64::consts::TAU / 3.3) + phase * std::f64::consts::TAU);
    let fiber = noise.other(31).layers(turn / 0.95, side * 1.1 + f64::from(which) * 9.0, 2);
    (fiber, strand)
}

fn color_of(weft: bool, shade: f64, slub: f64) -> Rgb {
    if weft {
        along(&[hex(0x9c7f57), hex(0xc2a97e), hex(0xd6c5a1)], shade + 0.35 * slub)
    } else {
        along(&[hex(0x16263f), hex(0x24446e), hex(0x3f6a97)], 0.15 + 0.7 * shade + 0.35 * slub)
    }
}
