//! A surface as a function of position, sampled, lit, and turned into material planes.
//!
//! Lengths are in output pixels, x to the right, y down, z towards the eye. Colours are linear light.

use half::f16;
use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::color::{Rgb, encode};
use crate::field::Field;
use crate::picture::{plane8, plane16};

/// What the surface is at one point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Texel {
    /// Height in pixels.
    pub height: f64,
    /// Share of light that is scattered, per channel, linear.
    pub albedo: Rgb,
    /// 0 is a mirror, 1 is chalk.
    pub roughness: f64,
}

/// Sub-samples along each axis of a pixel: enough that edges of hard shapes are smooth.
const SUB: u32 = 2;
/// Pixels evaluated around the picture, so that shadows from outside fall into it.
const MARGIN: u32 = 20;

/// A sampled surface, `SUB` samples along each side of a pixel and a margin around.
#[derive(Debug)]
pub struct Relief {
    width: u32,
    height: u32,
    z: Field,
    albedo: [Field; 3],
    roughness: Field,
}

/// A distant light and the sky around it.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Where the sun stands; need not have unit length.
    pub towards: [f64; 3],
    /// Light of the sun.
    pub sun: Rgb,
    /// Light of the sky.
    pub sky: Rgb,
    /// Strength of the highlights.
    pub gloss: f64,
}

impl Relief {
    /// Samples `surface` over `width * height` pixels.
    pub fn of(width: u32, height: u32, surface: impl Fn(f64, f64) -> Texel) -> Self {
        let (w, h) = ((width + 2 * MARGIN) * SUB, (height + 2 * MARGIN) * SUB);
        let position = |i: u32| (f64::from(i) + 0.5) / f64::from(SUB) - f64::from(MARGIN);
        let texels: Vec<Texel> =
            (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| surface(position(x), position(y))).collect();
        let field = |of: &dyn Fn(&Texel) -> f64| Field::new(w, h, texels.iter().map(of).collect());
        Self {
            width,
            height,
            z: field(&|t| t.height),
            albedo: [0, 1, 2].map(|c| field(&|t| t.albedo[c])),
            roughness: field(&|t| t.roughness),
        }
    }

    /// The surface under `light`, sRGB, 8 bits.
    pub fn lit(&self, light: &Light) -> Plane<2> {
        self.srgb(&self.radiance(light).each_ref())
    }

    /// The surface under `light`, linear, half floats: highlights stay as bright as they are.
    pub fn lit_linear(&self, light: &Light) -> Plane<2> {
        let linear = self.radiance(light);
        let halves = linear.iter().flat_map(|f| self.pixels(f)).map(|v| f16::from_f32(v as f32).to_bits()).collect();
        let grid = Grid::from_vec(Domain::open([self.height, self.width]), 3, halves).expect("three planes");
        Plane::new(Role::Color, Samples::F16(grid))
    }

    fn radiance(&self, light: &Light) -> [Field; 3] {
        let normals = self.normals();
        let open = self.openness();
        let sunlit = self.sunlit(unit(light.towards));
        let towards = unit(light.towards);
        let half = unit([towards[0], towards[1], towards[2] + 1.0]);
        [0, 1, 2].map(|c| {
            self.z.map_index(|i| {
                let n = [normals[0].at(i), normals[1].at(i), normals[2].at(i)];
                let sun = light.sun[c] * dot(n, towards).max(0.0) * sunlit.at(i);
                let sky = light.sky[c] * open.at(i) * (0.75 + 0.25 * n[2]);
                let polish = 1.0 - self.roughness.at(i);
                let shine = libm::pow(dot(n, half).max(0.0), 8.0 + 90.0 * polish * polish) * polish * sunlit.at(i);
                self.albedo[c].at(i) * (sun + sky) + light.gloss * light.sun[c] * shine
            })
        })
    }

    /// The colour of the material without light but with the dirt that gathers in its hollows, sRGB, 8 bits.
    pub fn albedo(&self) -> Plane<2> {
        let open = self.openness();
        let channels = [0, 1, 2].map(|c| self.z.map_index(|i| self.albedo[c].at(i) * (0.35 + 0.65 * open.at(i))));
        self.srgb(&channels.each_ref())
    }

    /// Unit normals as 8-bit RGB: x right, y up, z out; 128 stands for zero.
    pub fn normal(&self) -> Plane<2> {
        let [x, y, z] = self.normals();
        let (x, y, z) = (self.pixels(&x), self.pixels(&y), self.pixels(&z));
        let mut samples = [const { Vec::new() }; 3];
        for ((&x, &y), &z) in x.iter().zip(&y).zip(&z) {
            let n = unit([x, -y, z]);
            for (plane, v) in samples.iter_mut().zip(n) {
                plane.push((127.5 + 127.5 * v).round() as u8);
            }
        }
        plane8(Role::Normal, self.width, self.height, samples.concat())
    }

    /// Height over `lowest..=highest` pixels as 16-bit grey.
    pub fn height16(&self, lowest: f64, highest: f64) -> Plane<2> {
        let level = |z: f64| ((z - lowest) / (highest - lowest)).clamp(0.0, 1.0) * 65535.0;
        let levels = self.pixels(&self.z).into_iter().map(|z| level(z).round() as u16);
        plane16(Role::Height, self.width, self.height, levels.collect())
    }

    /// Roughness as 8-bit grey.
    pub fn roughness(&self) -> Plane<2> {
        let grey = self.pixels(&self.roughness).into_iter().map(|r| (r.clamp(0.0, 1.0) * 255.0).round() as u8);
        plane8(Role::Scalar, self.width, self.height, grey.collect())
    }

    fn normals(&self) -> [Field; 3] {
        let (dx, dy) = self.z.slopes(f64::from(SUB));
        let length = dx.map_index(|i| (dx.at(i) * dx.at(i) + dy.at(i) * dy.at(i) + 1.0).sqrt());
        [
            dx.map_index(|i| -dx.at(i) / length.at(i)),
            dy.map_index(|i| -dy.at(i) / length.at(i)),
            dx.map_index(|i| 1.0 / length.at(i)),
        ]
    }

    /// Share of the sky that a point sees, judged by how far it lies below its surroundings at three distances.
    fn openness(&self) -> Field {
        let around = [2, 5, 12].map(|radius| self.z.blurred(radius * SUB));
        self.z.map_index(|i| {
            let sunk: f64 = around.iter().zip([0.16, 0.12, 0.08]).map(|(a, k)| k * (a.at(i) - self.z.at(i))).sum();
            libm::exp(-sunk.max(-0.25))
        })
    }

    /// 1 where the sun shines, 0 in shadow: a walk towards the light until the surface stands in the way.
    fn sunlit(&self, towards: [f64; 3]) -> Field {
        let flat = (towards[0] * towards[0] + towards[1] * towards[1]).sqrt().max(1e-6);
        let (sx, sy, rise) = (towards[0] / flat, towards[1] / flat, towards[2] / flat);
        let (w, _) = self.z.size();
        let highest = self.z.highest();
        self.z.map_index(|i| {
            let (x, y) = ((i as u32 % w) as f64, (i as u32 / w) as f64);
            let mut light: f64 = 1.0;
            for step in 1..=MARGIN * SUB {
                let far = f64::from(step);
                let ray = self.z.at(i) + rise * far / f64::from(SUB);
                if ray > highest {
                    break;
                }
                let over = self.z.clamped(x + sx * far, y + sy * far) - ray;
                // A shadow's edge softens with the distance of what throws it.
                light = light.min(0.5 - 1.2 * over / (0.4 + 0.05 * far));
            }
            light.clamp(0.0, 1.0)
        })
    }

    fn srgb(&self, linear: &[&Field; 3]) -> Plane<2> {
        let planes: Vec<u8> = linear.iter().flat_map(|f| self.pixels(f)).map(encode).collect();
        plane8(Role::Color, self.width, self.height, planes)
    }

    /// Means over the sub-samples of each pixel, without the margin.
    fn pixels(&self, field: &Field) -> Vec<f64> {
        field.reduced(SUB, MARGIN, self.width, self.height)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::bytes;

    const SUN_FROM_THE_LEFT: Light = Light { towards: [-1.0, 0.0, 1.0], sun: [0.5; 3], sky: [0.1; 3], gloss: 0.0 };

    fn grey(height: f64) -> Texel {
        Texel { height, albedo: [1.0; 3], roughness: 1.0 }
    }

    #[test]
    fn a_table_is_flat_and_evenly_lit() {
        let table = Relief::of(6, 4, |_, _| grey(2.0));
        let normal = table.normal();
        assert!(bytes(&normal)[..48].iter().all(|&v| v == 128) && bytes(&normal)[48..].iter().all(|&v| v == 255));
        let lit = table.lit(&SUN_FROM_THE_LEFT);
        assert!(bytes(&lit).iter().all(|&v| v == bytes(&lit)[0]));
    }

    #[test]
    fn slopes_face_where_they_fall() {
        let normal = Relief::of(4, 4, |x, y| grey(x - 0.5 * y)).normal();
        let (x, y) = (bytes(&normal)[5], bytes(&normal)[16 + 5]);
        assert!(x < 64 && y < 128, "rises to the right and upwards, so x and y point away: {x} {y}");
    }

    #[test]
    fn a_wall_throws_its_shadow_away_from_the_sun() {
        let wall = Relief::of(32, 4, |x, _| grey(if (14.0..16.0).contains(&x) { 6.0 } else { 0.0 }));
        let lit = wall.lit(&SUN_FROM_THE_LEFT);
        let row = &bytes(&lit)[..32];
        assert!(row[19] + 40 < row[4], "behind {} before {}", row[19], row[4]);
        assert!(row[27].abs_diff(row[4]) < 12, "far behind {} before {}", row[27], row[4]);
    }

    #[test]
    fn heights_span_16_bits() {
        let ramp = Relief::of(2, 1, |x, _| grey(if x < 1.0 { -3.0 } else { 5.0 })).height16(-3.0, 5.0);
        let selvedge_core::Samples::U16(levels) = ramp.samples else { panic!("16 bits") };
        assert_eq!(levels.samples(), [0, 65_535]);
    }
}
