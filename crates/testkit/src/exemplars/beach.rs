//! A beach: waves run up the sand, slow down, and dissolve where they end.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::color::{along, blend, encode, hex};
use crate::noise::Noise;

const NOISE: Noise = Noise::new(0xbeac);
/// By wave, the frame in which its foam comes into the picture, and how much of its height it runs over.
const WAVES: [(f64, f64); 5] = [(-34.0, 0.62), (9.0, 0.9), (41.0, 0.5), (58.0, 0.75), (88.0, 0.6)];
/// Frames in which a wave runs, and in which its foam dissolves after it.
const RUN: f64 = 40.0;
const DISSOLVE: f64 = 20.0;

/// A clip of `[frames, height, width]`, sRGB, the sea at the top. No wave is like another, and each is gone after 60
/// frames: no two of the first hundred are alike, and what is cut between two of them ends a wave where none ends.
/// `[Kwatra03 7A]`
///
/// # Panics
/// If there is too little memory.
pub fn beach(shape: [u32; 3]) -> Plane<3> {
    let domain = Domain::open(shape);
    let at = |[t, y, x]: [u32; 3]| color(t.into(), y.into(), x.into(), shape[1].into());
    let colors: Vec<[u8; 3]> = domain.positions().map(at).collect();
    let samples = (0..3).flat_map(|c| colors.iter().map(move |rgb| rgb[c])).collect();
    Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples).expect("three channels")))
}

fn color(t: f64, y: f64, x: f64, height: f64) -> [u8; 3] {
    let down = y / height;
    let grain = NOISE.other(1).layers(x / 3.0, y / 3.0, 3);
    let (mut foam, mut water) = (0.0_f64, 0.0_f64);
    for (wave, (begin, reach)) in (2..).zip(WAVES) {
        let age = (t - begin) / RUN;
        if age <= 0.0 {
            continue;
        }
        // It runs ever slower, along a front of its own.
        let slow = 1.0 - age.min(1.0);
        let front = reach * (1.0 - slow * slow) + 0.05 * NOISE.other(wave).smooth(x / 24.0, age);
        let behind = front - down;
        let gone = ((t - begin - RUN) / DISSOLVE).clamp(0.0, 1.0);
        // Bubbles move with the front, and burst one after the other.
        let bubbles = 0.5 + 0.5 * NOISE.other(wave + 20).layers(x / 5.0, behind * height / 5.0, 3);
        let edge = (behind * 40.0).clamp(0.0, 1.0) * (1.0 - behind * 6.0).clamp(0.0, 1.0);
        foam = foam.max(edge * ((bubbles - gone) * 4.0).clamp(0.0, 1.0));
        water = water.max((behind * 20.0).clamp(0.0, 1.0) * (1.0 - 0.8 * gone));
    }
    let ripple = NOISE.other(9).layers(x / 9.0, y / 4.0 - t / 12.0, 2);
    let sea = (1.0 - down * 7.0).clamp(0.0, 1.0).max(water);
    let sand = 0.62 + 0.18 * grain;
    let level = sand * (1.0 - sea) + sea * (0.28 + 0.1 * ripple);
    let palette = [hex(0x123a4c), hex(0x3f7f8c), hex(0xb09468), hex(0xe0c898)];
    let shade = along(&palette, level.clamp(0.0, 1.0));
    blend(shade, [0.9; 3], foam).map(encode)
}
