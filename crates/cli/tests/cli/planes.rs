//! Planes of a material: roles by name, `--with`, `--match`.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, ReadOptions, WriteOptions, decode};
use serde_json::Value;

use crate::program::Folder;

fn samples(folder: &Folder, name: &str) -> Vec<f64> {
    let path = folder.path(name);
    let samples = decode(&fs::read(&path).unwrap(), &path, &ReadOptions::default()).unwrap().plane.samples;
    let n = samples.domain().len();
    (0..samples.channels() * n).map(|i| samples.value(i / n, i % n)).collect()
}

fn command_in(folder: &Folder, name: &str) -> String {
    let info = folder.run(&format!("info {name} --json")).done().json();
    let command = info["stats"]["made_by_selvedge"]["command"].as_str().unwrap();
    // The marks are tested by themselves.
    command.split(" --expect ").next().unwrap().to_owned()
}

/// Slopes of a height, as normals with y up or down, and the height.
fn material(folder: &Folder) {
    let domain = Domain::open([48, 48]);
    let height = |y: f64, x: f64| libm::sin(x * 0.7) * 20.0 + libm::cos(y * 0.45 + x * 0.2) * 30.0;
    let slope = |[y, x]: [u32; 2]| {
        let (y, x) = (f64::from(y), f64::from(x));
        let (dx, dy) = (height(y, x + 1.0) - height(y, x - 1.0), height(y + 1.0, x) - height(y - 1.0, x));
        let length = (dx * dx + dy * dy + 60.0 * 60.0).sqrt();
        // Out of the surface; up is towards smaller y.
        [-dx / length, dy / length, 60.0 / length]
    };
    let coded = |v: f64| (v * 127.5 + 127.5).round() as u8;
    for (name, up) in [("wood_NormalGL.png", 1.0), ("wood_NormalDX.png", -1.0)] {
        let of = |c: usize, at| slope(at)[c] * if c == 1 { up } else { 1.0 };
        let all = (0..3).flat_map(|c| domain.positions().map(move |at| coded(of(c, at)))).collect();
        write(folder, name, Role::Normal, Samples::U8(Grid::from_vec(domain, 3, all).unwrap()));
    }
    let coded = |[y, x]: [u32; 2]| ((height(f64::from(y), f64::from(x)) + 55.0) * 500.0) as u16;
    let heights: Vec<u16> = domain.positions().map(coded).collect();
    let color = heights.iter().map(|h| (h >> 8) as u8).collect();
    write(folder, "wood_height.png", Role::Height, Samples::U16(Grid::from_vec(domain, 1, heights).unwrap()));
    write(folder, "wood.png", Role::Color, Samples::U8(Grid::from_vec(domain, 1, color).unwrap()));
}

fn write(folder: &Folder, name: &str, role: Role, samples: Samples<2>) {
    let plane = Plane::new(role, samples);
    selvedge_io::write(folder.path(name), &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
}

/// How well the first two components of normals agree with the slopes of a height, both as they were woven.
fn correlation(normals: &[f64], height: &[f64], side: usize, up: f64) -> f64 {
    let n = side * side;
    let (mut both, mut one, mut other) = (0.0, 0.0, 0.0);
    for y in 1..side - 1 {
        for x in 1..side - 1 {
            let i = y * side + x;
            let slopes = [height[i - 1] - height[i + 1], (height[i + side] - height[i - side]) * up];
            for (c, slope) in slopes.into_iter().enumerate() {
                let component = normals[c * n + i] - 127.5;
                (both, one, other) = (both + component * slope, one + component * component, other + slope * slope);
            }
        }
    }
    both / (one * other).sqrt()
}

#[test]
fn roles_are_told_by_names_and_normals_turn_with_their_light() {
    let folder = Folder::new("roles");
    material(&folder);
    let weave = "graphcut wood.png -o out.png --size 96 --turn --mirror --map map.exr --placement sub --region 24";
    folder.run(weave).done();
    let planes = "wood_NormalGL.png wood_NormalDX.png wood_height.png";
    let said = folder.run(&format!("apply map.exr {planes} -o {{stem}}-out.png --copy --json")).done();
    assert!(
        said.stderr.contains("'wood_NormalGL.png' normal, 'wood_NormalDX.png' normal-dx, 'wood_height.png' height")
    );
    assert_eq!(said.json()["options"]["role"], Value::from(vec!["normal", "normal-dx", "height"]));
    let height = samples(&folder, "wood_height-out.png");
    for (name, up) in [("wood_NormalGL", 1.0), ("wood_NormalDX", -1.0)] {
        let laid = correlation(&samples(&folder, &format!("{name}-out.png")), &height, 96, up);
        assert!(0.9 < laid, "{name}: {laid}");
        let said = folder.run(&format!("apply map.exr {name}.png -o wrong.png --role color")).done();
        assert!(said.stderr.contains("looks like normals but is turned as color"), "{said:?}");
        let wrong = correlation(&samples(&folder, "wrong.png"), &height, 96, up);
        assert!(wrong < 0.7, "{name}: {wrong}");
    }
    assert_eq!(
        command_in(&folder, "wood_height-out.png"),
        "selvedge apply map.exr wood_height.png --copy --role height"
    );
    assert_eq!(
        command_in(&folder, "wood_NormalDX-out.png"),
        "selvedge apply map.exr wood_NormalDX.png --copy --role normal-dx"
    );
    let typed = folder.run("apply map.exr wood_height.png -o c.png --role color").done();
    assert!(!typed.stderr.contains("by their names"), "what is typed is not told: {typed:?}");
    assert_eq!(command_in(&folder, "c.png"), "selvedge apply map.exr wood_height.png --role color");
}

#[test]
fn planes_of_with_are_laid_as_apply_does() {
    let folder = Folder::new("with");
    material(&folder);
    let with = "--with wood_NormalGL.png wood_height.png";
    for weave in ["quilt wood.png", "graphcut wood.png --turn --placement sub --region 24 --feather 1.5"] {
        let said = folder.run(&format!("{weave} -o out-{{name}} --size 80x64 --map map.exr {with} --json")).done();
        assert_eq!(said.json()["outputs"].as_array().map(Vec::len), Some(4), "{said:?}");
        let feather = if weave.contains("feather") { "--feather 1.5" } else { "" };
        folder.run(&format!("apply map.exr wood_NormalGL.png wood_height.png -o again-{{name}} {feather}")).done();
        for name in ["wood_NormalGL.png", "wood_height.png"] {
            assert_eq!(samples(&folder, &format!("out-{name}")), samples(&folder, &format!("again-{name}")), "{weave}");
        }
        folder.run(&format!("{weave} -o alone.png --size 80x64 --map map-alone.exr")).done();
        let file = |name: &str| fs::read(folder.path(name)).unwrap();
        assert_eq!(file("out-wood.png"), file("alone.png"), "what is laid with it does not change the picture");
        assert_eq!(file("map.exr"), file("map-alone.exr"));
        let command = command_in(&folder, "out-wood_height.png");
        assert!(command.contains(" --with wood_height.png --role height ") && !command.contains("Normal"), "{command}");
    }
    folder.run(&format!("quilt wood.png -o out.png {with}")).refused(2, &["'out.png'", "3 outputs", "{stem}"]);
    folder.run("quilt wood.png -o o-{name} --with wood.png").refused(2, &["named for two outputs"]);
    folder.run("quilt wood.png -o o-{name} --with @/stars.png").refused(3, &["128x128 px", "'wood.png' has 48x48 px"]);
    folder
        .run("quilt wood.png wood.png -o o-{name} --with wood.png")
        .refused(2, &["1 plane of --with for 2 exemplars"]);
    folder.run("quilt wood.png -o o.png --role normal").refused(2, &["--role", "--with"]);
    assert!(!folder.names().iter().any(|name| name.starts_with("o-")));
}

#[test]
fn planes_of_match_decide_with_the_exemplar() {
    let folder = Folder::new("match");
    material(&folder);
    // A grey exemplar says nothing: what decides is the height.
    let grey = Grid::from_vec(Domain::open([48, 48]), 1, vec![99_u8; 48 * 48]).unwrap();
    write(&folder, "grey.png", Role::Color, Samples::U8(grey));
    let seams = |command: &str| {
        let said =
            folder.run(&format!("{command} --size 96 -o o.png --map m.exr --block 16 --stage overlap --json")).done();
        folder.run("apply m.exr wood_height.png -o h.png --copy").done();
        let height = samples(&folder, "h.png");
        let map = selvedge_io::read_map(folder.path("m.exr"), &Default::default()).unwrap().map;
        let ids = map.ids.plane(0);
        let step = |i: &usize| i % 96 != 95 && ids[i + 1].get() != ids[*i].get() + 1;
        let seams: Vec<f64> = (0..96 * 96).filter(step).map(|i| (height[i] - height[i + 1]).abs()).collect();
        (seams.iter().sum::<f64>() / seams.len() as f64, said.json()["options"].clone())
    };
    let (alone, options) = seams("quilt grey.png");
    assert!(options.get("match").is_none() && options.get("weight").is_none(), "{options}");
    let (matched, options) = seams("quilt grey.png --match wood_height.png --weight 0.37");
    assert!(matched * 2.0 < alone, "steps of {matched} with the height, {alone} without");
    assert_eq!((&options["match"][0], &options["weight"]), (&"wood_height.png".into(), &"0.37".into()));
    let command = command_in(&folder, "o.png");
    assert!(command.contains(" --match wood_height.png --weight 0.37 "), "{command}");
    assert_eq!(seams("quilt grey.png --match wood_height.png --weight 0").0, alone, "a weight of 0 decides nothing");
    folder.run("graphcut grey.png -o o.png --match wood_height.png,x --weight 1,1").refused(4, &["'x': not found"]);
    folder.run("quilt grey.png -o o.png --match wood.png --weight 1,2").refused(2, &["2 weights for 1 --match"]);
    folder.run("quilt grey.png -o o.png --match wood.png --weight -1").refused(2, &["-1", "--weight"]);
    folder.run("quilt grey.png -o o.png --match @/stars.png").refused(3, &["128x128", "48x48"]);
}

#[test]
fn planes_of_two_kinds_in_one_group_are_refused_with_the_order() {
    let folder = Folder::new("with-mixed");
    for name in ["a.png", "b.png", "a_normal.png", "b_normal.png", "a_height.png", "b_height.png"] {
        std::fs::copy(crate::program::fixtures() + "/weave.png", folder.path(name)).unwrap();
    }
    let line = "quilt a.png b.png -o out-{name} --size 48 --dry-run --with";
    let mixed = format!("{line} a_normal.png a_height.png b_normal.png b_height.png");
    folder.run(&mixed).refused(2, &["a_normal.png and a_height.png", "planes of different kinds", "--role"]);
    folder.run(&format!("{line} a_normal.png b_normal.png a_height.png b_height.png")).done();
    folder.run(&format!("{mixed} --role scalar")).done();
}
