//! Cobbles: rounded stones of many colours, sand and moss in the joints, low sun from the upper left.

use selvedge_core::{Grid, Plane, Role, Samples};

use crate::color::{Rgb, along, blend, hex, scaled};
use crate::noise::{Noise, lerp, ramp};
use crate::picture::bytes;
use crate::relief::{Light, Relief, Texel};

const NOISE: Noise = Noise::new(0xc0bb);
/// Mean distance between stones, pixels: some sixty stones in a picture.
const PITCH: f64 = 25.0;

/// Cobbles, 192 x 192, sRGB.
pub fn cobbles() -> Plane<2> {
    street(192)
}

/// Cobbles, 128 x 128, with a hole: alpha is 0 in a disc, whose colour is a magenta that no stone has.
pub fn cobbles_with_hole() -> Plane<2> {
    let opaque = street(128);
    let mut samples = bytes(&opaque).to_vec();
    samples.resize(samples.len() / 3 * 4, 255);
    let mut grid = Grid::from_vec(opaque.domain(), 4, samples).expect("three planes and one of alpha");
    for at in opaque.domain().positions() {
        let from_center = |i: usize| f64::from(at[i]) - 70.0;
        if from_center(0) * from_center(0) + from_center(1) * from_center(1) < 26.0 * 26.0 {
            for (channel, value) in [255, 0, 255, 0].into_iter().enumerate() {
                grid.set(channel, at, value);
            }
        }
    }
    Plane::with_alpha(Role::Color, Samples::U8(grid))
}

fn street(side: u32) -> Plane<2> {
    let light = Light {
        towards: [-0.62, -0.55, 0.62],
        sun: scaled(hex(0xfff0d8), 1.75),
        sky: scaled(hex(0xbcd0ea), 0.62),
        gloss: 0.05,
    };
    Relief::of(side, side, surface).lit(&light)
}

/// The stone under a point: its cell, and how far the point is from the nearest joint.
struct Stone {
    cell: (i32, i32),
    from_center: (f64, f64),
    inside: f64,
}

fn surface(x: f64, y: f64) -> Texel {
    let wobble = NOISE.other(1);
    let stone = stone_at(
        x + 1.7 * wobble.layers(x / 14.0, y / 14.0, 3),
        y + 1.7 * wobble.other(1).layers(x / 14.0, y / 14.0, 3),
    );
    let top = stone_texel(&stone, x, y);
    let joint = joint_texel(x, y);
    if top.height > joint.height { top } else { joint }
}

fn stone_texel(stone: &Stone, x: f64, y: f64) -> Texel {
    let (i, j) = stone.cell;
    let own = |k: u32| NOISE.other(100 + k).cell(i, j);
    let (dx, dy) = stone.from_center;
    let gap = 1.1 + 1.4 * own(0);
    let t = ((stone.inside - gap) / (6.0 + 3.0 * own(1))).clamp(0.0, 1.0);
    let dome = (1.0 - (1.0 - t) * (1.0 - t)).sqrt();
    let grain = NOISE.other(2).layers(x / 3.0, y / 3.0, 3);
    let swell = NOISE.other(3).layers(x / 11.0 + 31.0 * own(2), y / 11.0, 3);
    let tilt = 0.07 * ((2.0 * own(3) - 1.0) * dx + (2.0 * own(4) - 1.0) * dy);
    let height = if t > 0.0 { 6.2 * dome + tilt + 0.45 * grain * t + 0.9 * swell * t + 1.6 * own(5) } else { -9.0 };

    let mottle = NOISE.other(4).layers(x / 7.0 + 17.0 * own(6), y / 7.0, 4);
    let speck = NOISE.other(5).smooth(x * 0.9, y * 0.9);
    let mut color = blend(stone_color(own(7), own(8)), hex(0x6b6257), 0.25 * ramp(0.1, 0.7, mottle));
    color = scaled(color, (1.0 + 0.34 * mottle + 0.16 * speck) * lerp(0.78, 1.22, own(9)));
    let dirt = 1.0 - ramp(0.0, 6.0, stone.inside - gap);
    color = blend(color, hex(0x3c3228), 0.45 * dirt);
    let moss = ramp(0.25, 0.6, NOISE.other(6).layers(x / 40.0, y / 40.0, 3) + 0.5 * dirt - 0.15);
    color = blend(color, hex(0x4d5a25), 0.4 * moss * (0.5 + 0.5 * dirt));
    Texel { height, albedo: color, roughness: 0.55 + 0.3 * own(10) }
}

/// Greys warm and cool, tan, slate and a little red: the first number picks the family, the second a shade of it.
fn stone_color(family: f64, shade: f64) -> Rgb {
    let pair = match (family * 10.0) as u32 {
        0..=2 => [hex(0x8d8578), hex(0xa89f92)],
        3 | 4 => [hex(0x6f7780), hex(0x939ba3)],
        5 | 6 => [hex(0xa08a68), hex(0xbfa681)],
        7 => [hex(0x55595f), hex(0x6f6f70)],
        8 => [hex(0x94705c), hex(0xab8872)],
        _ => [hex(0xb5afa2), hex(0xc9c3b4)],
    };
    along(&pair, shade)
}

fn joint_texel(x: f64, y: f64) -> Texel {
    let grain = NOISE.other(20).smooth(x / 1.1, y / 1.1);
    let lumps = NOISE.other(21).layers(x / 5.0, y / 5.0, 3);
    let moss = ramp(-0.05, 0.35, NOISE.other(6).layers(x / 40.0, y / 40.0, 3) + 0.3 * lumps);
    let sand = scaled(along(&[hex(0x4a3f31), hex(0x7a6a52)], 0.5 + 0.6 * lumps), 1.0 + 0.35 * grain);
    let green = scaled(along(&[hex(0x2f3a12), hex(0x66762a)], 0.5 + 0.9 * grain), 1.0 + 0.3 * lumps);
    Texel { height: 0.2 + 0.35 * grain + 0.7 * lumps + 1.5 * moss, albedo: blend(sand, green, moss), roughness: 0.97 }
}

/// Cells of a jittered grid whose joints run half way between neighbouring centres, corners rounded.
fn stone_at(x: f64, y: f64) -> Stone {
    let (ci, cj) = ((x / PITCH).floor() as i32, (y / PITCH).floor() as i32);
    let mut centers = [((0, 0), (0.0, 0.0)); 25];
    for (k, center) in centers.iter_mut().enumerate() {
        let (i, j) = (ci + k as i32 % 5 - 2, cj + k as i32 / 5 - 2);
        let shift = if j.rem_euclid(2) == 0 { 0.25 } else { -0.25 };
        let cx = (f64::from(i) + 0.5 + shift + 0.33 * NOISE.other(30).signed(i, j)) * PITCH;
        let cy = (f64::from(j) + 0.5 + 0.33 * NOISE.other(31).signed(i, j)) * PITCH;
        *center = ((i, j), (cx - x, cy - y));
    }
    let far = |(dx, dy): (f64, f64)| dx * dx + dy * dy;
    let own = *centers.iter().min_by(|a, b| far(a.1).total_cmp(&far(b.1))).expect("25 centres");
    // A soft minimum over the joints rounds the corners.
    let mut sum = 0.0;
    for (cell, to) in centers {
        if cell != own.0 {
            let between = (far(to) - far(own.1)) / 2.0;
            let apart = far((to.0 - own.1.0, to.1 - own.1.1)).sqrt();
            sum += libm::exp(-between / apart / 1.6);
        }
    }
    Stone { cell: own.0, from_center: (-own.1.0, -own.1.1), inside: -1.6 * libm::log(sum) }
}
