//! Whether what is filled in is fused with what is around it, where nobody said how.

use std::collections::BTreeSet;
use std::path::Path;

use selvedge_core::{Depth, Plane, Role};

use crate::blending::Blending;
use crate::loaded::ExemplarSet;
use crate::roles;

/// Colours of a picture that has labels, a palette or two tones and no shades; and greys.
const FEW: [usize; 2] = [256, 64];

/// What was chosen. Two readers preferred fused fills on the same ten of twelve, and saw no difference on the others;
/// what no mean of two samples stands for is copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chosen {
    Fused,
    /// And why.
    Copied(&'static str),
}

impl Chosen {
    pub(super) fn of(loaded: &ExemplarSet) -> Self {
        Self::of_planes(&loaded.paths[0], &loaded.payload)
    }

    fn of_planes(path: &Path, planes: &[Plane<2>]) -> Self {
        let is_float = matches!(planes[0].samples.depth(), Depth::F16 | Depth::F32);
        match roles::of_name(path) {
            Some(Role::Height) => Self::Fused,
            Some(role) if role.is_normal() => Self::Copied("it holds normals"),
            Some(Role::Scalar) => Self::Copied("it holds no colours"),
            // Least squares of light would go by what is brightest.
            _ if is_float => Self::Copied("it holds light"),
            _ if roles::looks_like_normals(&planes[0]) => Self::Copied("it holds normals"),
            _ if has_few_colors(planes) => Self::Copied("it has few colours"),
            _ => Self::Fused,
        }
    }

    pub(super) fn blending(self) -> Blending {
        if self == Self::Fused { Blending::FUSED } else { Blending::COPIED }
    }

    /// For people, after what is filled.
    pub(super) fn told(self) -> String {
        match self {
            Self::Fused => ", fused with what is around".into(),
            Self::Copied(why) => format!(", copied, since {why}"),
        }
    }
}

/// True if pictures have no more colours than labels or a palette would.
fn has_few_colors(planes: &[Plane<2>]) -> bool {
    let (mut found, mut last) = (BTreeSet::new(), None);
    let most = FEW[usize::from(planes[0].color_channels() == 1)];
    for plane in planes {
        for i in 0..plane.domain().len() {
            let color: Vec<u64> = (0..plane.color_channels()).map(|c| plane.samples.value(c, i).to_bits()).collect();
            if last.as_ref() == Some(&color) {
                continue;
            }
            found.insert(color.clone());
            last = Some(color);
            if most < found.len() {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Grid, Samples};

    use super::*;

    fn of(name: &str, samples: Samples<2>) -> bool {
        Chosen::of_planes(Path::new(name), &[Plane::new(Role::Color, samples)]) == Chosen::Fused
    }

    #[test]
    fn what_a_mean_stands_for_is_fused_and_all_else_copied() {
        let domain = Domain::open([20, 20]);
        let shades = |colors: usize| {
            // More than 256 triples, and more than 64 values.
            let shade = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 24) as u8;
            Samples::U8(Grid::from_vec(domain, colors, (0..400 * colors).map(shade).collect()).unwrap())
        };
        assert!(of("photo.png", shades(3)) && of("grey.png", shades(1)) && of("wall_height.png", shades(1)));
        assert!(!of("wall_normal.png", shades(3)) && !of("wall_roughness.png", shades(1)));
        let two = Grid::from_vec(domain, 1, (0..400).map(|i| if i % 3 == 0 { 255 } else { 0 }).collect()).unwrap();
        assert!(!of("labels.png", Samples::U8(two)));
        let light = Grid::from_vec(domain, 1, (0..400).map(|i| i as f32 / 90.0).collect()).unwrap();
        assert!(!of("light.exr", Samples::F32(light.clone())) && of("wall_height.exr", Samples::F32(light)));
        let normals = Grid::from_vec(domain, 3, (0..1200).map(|i| if i < 800 { 128 } else { 255 }).collect()).unwrap();
        assert!(!of("rock.png", Samples::U8(normals)));
    }
}
