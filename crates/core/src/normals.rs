//! Normals as they are stored, and their length kept.

use crate::{Depth, Plane};

/// How components of normals are stored: `zero + unit * component`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCoding {
    /// What stands for 0.
    pub zero: f64,
    /// How far from it 1 lies.
    pub unit: f64,
}

impl NormalCoding {
    /// The coding of planes of one depth: integers span -1..1, floats are signed if any x or y is below 0, or
    /// if normals are nearer to the length 1 so than as if they spanned 0..1.
    pub fn of<const D: usize>(planes: &[&Plane<D>]) -> Self {
        match planes.first().map(|p| p.samples.depth()) {
            Some(Depth::U8) => Self { zero: 127.5, unit: 127.5 },
            Some(Depth::U16) => Self { zero: 32_767.5, unit: 32_767.5 },
            _ if planes.iter().any(|p| has_negative(p)) => Self::SIGNED,
            // A surface that leans one way alone has no negative components either.
            _ if off(planes, Self::SIGNED) < off(planes, Self::SPANNING) => Self::SIGNED,
            _ => Self::SPANNING,
        }
    }

    pub(crate) const SIGNED: Self = Self { zero: 0.0, unit: 1.0 };
    const SPANNING: Self = Self { zero: 0.5, unit: 0.5 };

    /// A stored component, turned round.
    pub(crate) fn negated(self, stored: f32) -> f32 {
        if self.zero == 0.0 { -stored } else { 1.0 - stored }
    }

    /// The stored components of the unit normal along a stored one. What has no direction stays as it is.
    pub fn unit_length(self, stored: [f64; 3]) -> [f64; 3] {
        let normal = stored.map(|v| (v - self.zero) / self.unit);
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length < 1e-6 { stored } else { normal.map(|v| v / length * self.unit + self.zero) }
    }
}

/// How far normals are from the length 1, in all.
fn off<const D: usize>(planes: &[&Plane<D>], coding: NormalCoding) -> f64 {
    let component = |p: &Plane<D>, c: usize, i: usize| (p.samples.value(c, i) - coding.zero) / coding.unit;
    let squared =
        |p: &Plane<D>, i: usize| (0..p.color_channels().min(3)).map(|c| component(p, c, i)).map(|v| v * v).sum::<f64>();
    planes.iter().flat_map(|p| (0..p.domain().len()).map(move |i| (squared(p, i) - 1.0).abs())).sum()
}

fn has_negative<const D: usize>(plane: &Plane<D>) -> bool {
    let components = 0..plane.color_channels().min(2);
    components.into_iter().any(|c| (0..plane.domain().len()).any(|i| plane.samples.value(c, i) < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Grid, Role, Samples};

    #[test]
    fn floats_are_signed_if_any_of_them_is_negative() {
        let plane = |x: f32| {
            let grid = Grid::from_vec(Domain::open([1, 1]), 3, vec![x, 0.5, 1.0]).unwrap();
            Plane::new(Role::Normal, Samples::F32(grid))
        };
        assert_eq!(NormalCoding::of(&[&plane(0.5)]), NormalCoding { zero: 0.5, unit: 0.5 });
        assert_eq!(NormalCoding::of(&[&plane(0.5), &plane(-0.1)]), NormalCoding { zero: 0.0, unit: 1.0 });
    }

    #[test]
    fn normals_keep_their_direction() {
        let bytes = NormalCoding { zero: 127.5, unit: 127.5 };
        assert_eq!(bytes.unit_length([127.5, 127.5, 200.0]), [127.5, 127.5, 255.0]);
        assert_eq!(bytes.unit_length([127.5; 3]), [127.5; 3]);
        let signed = NormalCoding { zero: 0.0, unit: 1.0 };
        assert_eq!(signed.unit_length([0.0, 3.0, 4.0]), [0.0, 0.6, 0.8]);
    }
}
