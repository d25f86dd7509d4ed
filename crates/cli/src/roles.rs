//! What the channels of a plane mean, told by its name as tools for materials do, or by its samples.

use std::path::{Path, PathBuf};

use selvedge_core::{Depth, Plane, Role};

/// Words of names, and what they say. Of several the last one counts: `metal_plate_diff` is a colour. The words are
/// those that material editors go by; single letters (`_n`, `_h`) are left out, since they say other things as often.
const WORDS: [(Role, &[&str]); 4] = [
    (
        Role::Color,
        &["basecolor", "basecolour", "albedo", "diffuse", "diff", "color", "colour", "col", "emissive", "emission"],
    ),
    (Role::Normal, &["normal", "normals", "normalmap", "nor", "nrm", "nrml", "normalgl", "normaldx"]),
    (Role::Height, &["height", "heightmap", "displacement", "displace", "disp", "dsp", "depth", "bump"]),
    (
        Role::Scalar,
        &[
            "roughness",
            "rough",
            "rgh",
            "gloss",
            "glossiness",
            "smoothness",
            "metallic",
            "metalness",
            "metal",
            "mtl",
            "ao",
            "occlusion",
            "ambientocclusion",
            "arm",
            "orm",
            "opacity",
            "alpha",
            "mask",
            "specular",
            "spec",
            "cavity",
            "curvature",
        ],
    ),
];

/// Words that say that y points down.
const DOWN: [&str; 2] = ["dx", "normaldx"];

/// What the channels of a file mean by its name; `None` if that says nothing.
pub(crate) fn of_name(path: &Path) -> Option<Role> {
    let stem = path.file_stem()?.to_string_lossy();
    let words = words(&stem);
    let says = |word: &String| WORDS.iter().find(|(_, all)| all.contains(&word.as_str())).map(|(role, _)| *role);
    let role = words.iter().rev().find_map(says)?;
    // A capital parts the last letter from the others.
    let whole = stem.to_lowercase().contains("directx");
    let down = role == Role::Normal && (whole || words.iter().any(|word| DOWN.contains(&word.as_str())));
    Some(if down { Role::NormalDown } else { role })
}

/// What the channels of planes that are laid together mean by their names: colour unless all say the same.
pub(crate) fn of_names(paths: &[PathBuf]) -> Role {
    let mut roles = paths.iter().map(|path| of_name(path).unwrap_or(Role::Color));
    let first = roles.next().unwrap_or(Role::Color);
    if roles.all(|role| role == first) { first } else { Role::Color }
}

/// The words of a name in small letters, parted by what is no letter and before capitals.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let begins = c.is_uppercase() && before.is_lowercase();
        if (begins || !c.is_alphabetic()) && !words[words.len() - 1].is_empty() {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            let last = words.len() - 1;
            words[last].extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// True if a plane of three channels can hardly be anything but normals of a surface: on average they point out of it,
/// and they are about as long as 1.
pub(crate) fn looks_like_normals(plane: &Plane<2>) -> bool {
    let n = plane.domain().len();
    if plane.color_channels() != 3 || n == 0 {
        return false;
    }
    let (most, integer) = match plane.samples.depth() {
        Depth::U8 => (255.0, true),
        Depth::U16 => (65_535.0, true),
        Depth::F16 | Depth::F32 => (1.0, false),
    };
    let values = |c: usize| (0..n).map(move |i| plane.samples.value(c, i));
    let signed = !integer && (0..2).any(|c| values(c).any(|v| v < 0.0));
    let component = |v: f64| if signed { v } else { 2.0 * v / most - 1.0 };
    let mean = |c: usize| values(c).map(component).sum::<f64>() / n as f64;
    let squares = (0..3).map(|c| values(c).map(|v| component(v) * component(v)).sum::<f64>()).sum::<f64>() / n as f64;
    // A picture that is blue on average is not as long as 1 everywhere; 8 bits round lengths by about 0.01.
    mean(0).abs() < 0.15 && mean(1).abs() < 0.15 && 0.5 < mean(2) && (squares - 1.0).abs() < 0.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Samples};

    #[test]
    fn names_say_what_tools_for_materials_mean_by_them() {
        for (name, role) in [
            ("Bricks059_1K-PNG_NormalGL.png", Some(Role::Normal)),
            ("Bricks059_1K-PNG_NormalDX.png", Some(Role::NormalDown)),
            ("wood_Normal_DirectX.png", Some(Role::NormalDown)),
            ("T_WoodNormalDirectX.tga", Some(Role::NormalDown)),
            ("wood_normal_directx.png", Some(Role::NormalDown)),
            ("directx_diffuse.png", Some(Role::Color)),
            ("Bricks059_1K-PNG_Color.png", Some(Role::Color)),
            ("Bricks059_1K-PNG_AmbientOcclusion.png", Some(Role::Scalar)),
            ("rock_wall_10_nor_gl_2k.exr", Some(Role::Normal)),
            ("rock_wall_10_nor_dx_2k.png", Some(Role::NormalDown)),
            ("rock_wall_10_disp_2k.png", Some(Role::Height)),
            ("rock_wall_10_arm_2k.jpg", Some(Role::Scalar)),
            ("metal_plate_02_diff_4k.jpg", Some(Role::Color)),
            ("T_Wood_BaseColor.tga", Some(Role::Color)),
            ("woodRoughness.tif", Some(Role::Scalar)),
            ("in/normal.png", Some(Role::Normal)),
            ("height/wood.png", None),
            ("abnormal.png", None),
            ("a.png", None),
        ] {
            assert_eq!(of_name(Path::new(name)), role, "{name}");
        }
    }

    #[test]
    fn normals_are_known_by_their_length_as_well() {
        let plane = |samples: Vec<u8>| {
            let domain = Domain::open([1, samples.len() as u32 / 3]);
            Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples).unwrap()))
        };
        assert!(looks_like_normals(&plane(vec![128, 90, 166, 127, 128, 128, 255, 250, 250])));
        // Blue, but with a light and a dark part.
        assert!(!looks_like_normals(&plane(vec![255, 0, 0, 255, 255, 255])));
        assert!(!looks_like_normals(&plane(vec![100, 90, 80, 110, 90, 80])));
    }
}
