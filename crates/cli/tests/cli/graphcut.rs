//! `graphcut`: sources of all kinds as maps, blended seams, what the output starts from, and what is refused.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples, SourceMap, Transform};
use selvedge_io::{MapFile, Metadata, ReadOptions, WriteOptions, decode};

use crate::program::{Folder, Said};

/// Few patches that are found at once.
const QUICK: &str = "--placement random --region 16 --reach 12 --refine 4 --tries 1";

pub(crate) fn samples(folder: &Folder, name: &str) -> Samples<2> {
    let path = folder.path(name.replace('@', &crate::program::fixtures()));
    decode(&fs::read(&path).unwrap(), &path, &ReadOptions::default()).unwrap().plane.samples
}

pub(crate) fn map(folder: &Folder, name: &str) -> MapFile {
    selvedge_io::read_map(folder.path(name), &Default::default()).unwrap()
}

/// A picture of bytes.
pub(crate) fn write(
    folder: &Folder,
    name: &str,
    shape: [u32; 2],
    channels: usize,
    value: impl Fn(usize, [u32; 2]) -> u8,
) {
    let domain = Domain::open(shape);
    let all = (0..channels).flat_map(|c| domain.positions().map(move |at| (c, at)));
    let grid = Grid::from_vec(domain, channels, all.map(|(c, at)| value(c, at)).collect()).unwrap();
    let plane = Plane { alpha: channels == 4, ..Plane::new(Role::Color, Samples::U8(grid)) };
    selvedge_io::write(folder.path(name), &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
}

pub(crate) fn energy(said: &Said) -> Vec<i64> {
    said.json()["stats"]["energy"].as_array().unwrap().iter().map(|e| e.as_i64().unwrap()).collect()
}

#[test]
fn paper_is_what_it_stands_for() {
    let folder = Folder::new("graphcut-paper");
    let line = "graphcut @/weave.png --size 120x100 --placement random --refine 4";
    folder.run(&format!("{line} -o a.png --paper")).done();
    folder.run(&format!("{line} -o b.png --reach all --variety 0 --tries 1")).done();
    folder.run(&format!("{line} -o c.png")).done();
    assert_eq!(samples(&folder, "a.png"), samples(&folder, "b.png"));
    assert_ne!(samples(&folder, "a.png"), samples(&folder, "c.png"));
}

#[test]
fn regions_may_be_oblong() {
    let folder = Folder::new("graphcut-oblong");
    let line = "graphcut @/weave.png --size 120x100 --placement sub --refine 6 --map m.exr";
    let made = |options: &str| {
        let said = folder.run(&format!("{line} -o a.png --json {options}")).done();
        let used = said.json()["options"].clone();
        (used["region"].to_string(), used["reach"].to_string(), samples(&folder, "a.png"))
    };
    let (square, typed) = (made("--region 24 --reach 12"), made("--region 24x24 --reach 12x12"));
    assert_eq!((square.0.as_str(), square.1.as_str()), ("24", "12"));
    assert_eq!(square, typed);
    let wide = made("--region 40x16 --reach 30X0");
    assert_eq!((wide.0.as_str(), wide.1.as_str()), ("\"40x16\"", "\"30x0\""));
    assert_ne!(wide.2, square.2);
    assert_eq!(made("--region 40x16").1, "\"20x8\"", "half of the region");
}

#[test]
fn maps_of_turned_and_scaled_sources_stand_alone() {
    let folder = Folder::new("graphcut-sources");
    write(&folder, "half.png", [128, 128], 1, |_, [_, x]| if x < 80 { 255 } else { 0 });
    let sources = "--turn --mirror --rotate -30 --scale 0.7";
    for (exemplar, extension, blending) in [
        ("@/stars.png", "png", ""),
        ("@/bricks/height.png", "png", "--feather 1.5"),
        ("@/scales-hdr.exr", "exr", "--spline 2"),
        ("@/scales-hdr.exr", "exr", ""),
        ("@/stars.png", "png", "--feather 2 --mask half.png"),
    ] {
        let (out, again) = (format!("out.{extension}"), format!("again.{extension}"));
        let line = format!("graphcut {exemplar} -o {out} --map map.exr --size 60x50 {QUICK} {sources} {blending}");
        folder.run(&line).done();
        folder.run(&format!("apply map.exr {exemplar} -o {again} {blending}")).done();
        assert_eq!(samples(&folder, &out), samples(&folder, &again), "{line}");
        let table = map(&folder, "map.exr").map.table;
        // 4 turns of 2 angles, mirrored or not, at 2 scales; quarter turns of the full size are exact.
        assert_eq!(table.sources().len(), 4 * 2 * 2 * 2);
        let exact = table.sources().iter().filter(|(o, _)| matches!(o.transform, Transform::Exact { .. }));
        assert_eq!(exact.count(), 8);
    }
    folder.run("info map.exr").done();
    let info = folder.run("info map.exr --json").done().json();
    let sources = info["stats"]["source"].as_array().unwrap();
    let turned = |s: &&serde_json::Value| s["degrees"] == 330.0 && s["scale"] == 0.7 && s["mirror"] == true;
    assert_eq!(sources.iter().filter(turned).count(), 1);
    folder.run("apply map.exr @/weave.png -o no.png").refused(3, &["weave.png'", "192x192 px", "stars.png"]);
}

#[test]
fn materials_are_blended_like_their_colours() {
    let folder = Folder::new("graphcut-material");
    folder.run(&format!("graphcut @/bricks/albedo.png -o a.png --map m.exr --size 64 {QUICK} --feather 2")).done();
    let planes = "@/bricks/normal.png @/bricks/height.png --role normal --role height";
    folder.run(&format!("apply m.exr {planes} --feather 2 -o {{name}}")).done();
    folder.run(&format!("apply m.exr {planes} -o sharp-{{name}}")).done();
    let (soft, sharp) = (samples(&folder, "normal.png"), samples(&folder, "sharp-normal.png"));
    assert_ne!(soft, sharp);
    let length = |i: usize| {
        let squares = (0..3).map(|c| soft.value(c, i) / 127.5 - 1.0).map(|v| v * v);
        squares.sum::<f64>().sqrt()
    };
    let blended = (0..64 * 64).filter(|&i| (0..3).any(|c| soft.value(c, i) != sharp.value(c, i)));
    assert!(blended.map(length).all(|l| (l - 1.0).abs() < 0.02));
    let height = |name: &str| matches!(samples(&folder, name), Samples::U16(_));
    assert!(height("height.png"));
    assert_ne!(samples(&folder, "height.png"), samples(&folder, "sharp-height.png"));
}

#[test]
fn a_map_is_gone_on_from() {
    let folder = Folder::new("graphcut-start");
    let first =
        folder.run(&format!("graphcut @/cobbles.png -o a.png --map a.exr --size 70x60 --tile x {QUICK} --json"));
    let first = energy(&first.done());
    // More ways to turn, another order of exemplars: samples keep their meaning.
    let more = "graphcut @/weave.png @/cobbles.png --mirror -o b.png --map b.exr --start a.exr";
    let second = folder.run(&format!("{more} --seed 5 --placement sub --region 16 --refine 8 --json")).done();
    assert_eq!(second.json()["options"]["size"], "70x60");
    assert_eq!(second.json()["options"]["tile"], "x", "the map's topology is kept");
    let second_energy = energy(&second);
    assert_eq!(second_energy[0], *first.last().unwrap(), "it begins where the first run ended");
    assert!(second_energy.is_sorted_by(|a, b| a >= b));
    folder.run("graphcut @/cobbles.png -o c.png --start a.exr --refine 0").done();
    assert_eq!(samples(&folder, "a.png"), samples(&folder, "c.png"), "nothing to fill, nothing to refine");

    folder.run("graphcut @/weave.png -o n.png --start a.exr").refused(3, &["'a.exr'", "'cobbles.png'", "weave.png"]);
    let refused = folder.run("graphcut @/cobbles.png -o n.png --start a.exr --size 64");
    refused.refused(3, &["'a.exr'", "70x60 px", "64x64 px", "leave --size out"]);
    let mirrored = format!("graphcut @/cobbles.png -o m.png --map m.exr --rotate 45 --size 60 {QUICK} --seed 4");
    folder.run(&mirrored).done();
    folder.run("graphcut @/cobbles.png -o n.png --start m.exr").refused(3, &["'m.exr'", "45 degrees", "--rotate"]);
    folder.run("graphcut @/cobbles.png -o n.png --start @/weave.png").refused(3, &["weave.png'", "no source map"]);
}

#[test]
fn a_map_with_masked_samples_is_filled_again() {
    let folder = Folder::new("graphcut-holes");
    write(&folder, "left.png", [192, 192], 1, |_, [_, x]| if x < 96 { 255 } else { 0 });
    folder.run(&format!("graphcut @/cobbles.png -o a.png --map a.exr --size 70 {QUICK}")).done();
    let right = |m: &SourceMap<2>| m.domain().positions().filter(|at| m.locate(*at).unwrap().1[1] >= 96).count();
    assert_ne!(right(&map(&folder, "a.exr").map), 0);
    let line = "graphcut @/cobbles.png --mask left.png -o b.png --map b.exr --start a.exr --region 16 --placement sub";
    folder.run(line).done();
    assert_eq!(right(&map(&folder, "b.exr").map), 0);
}

#[test]
fn what_is_fixed_stays_to_the_bit() {
    let folder = Folder::new("graphcut-fixed");
    let white = |[y, x]: [u32; 2]| (20..40).contains(&y) && x < 50;
    write(&folder, "fixed.png", [60, 70], 1, |_, at| if white(at) { 255 } else { 0 });
    folder.run(&format!("graphcut @/cobbles.png -o a.png --map a.exr --size 70x60 {QUICK}")).done();
    let same = |one: &Samples<2>, other: &Samples<2>, at: [u32; 2]| {
        (0..3).all(|c| one.value(c, one.domain().index(at)) == other.value(c, other.domain().index(at)))
    };
    let before = samples(&folder, "a.png");
    for from in ["--start a.exr --placement sub --region 12 --refine 20", "--over a.png --region 16 --refine 20"] {
        for blending in ["", "--feather 3", "--spline 3"] {
            let line = format!("graphcut @/cobbles.png -o b.png --map b.exr --fixed fixed.png {from} {blending}");
            folder.run(&line).done();
            let after = samples(&folder, "b.png");
            let all = || before.domain().positions();
            assert!(all().filter(|at| white(*at)).all(|at| same(&before, &after, at)), "{line}");
            assert!(!all().all(|at| same(&before, &after, at)), "{line}: something else changed");
            assert_eq!(map(&folder, "b.exr").map.holes(), 0);
        }
    }
    // The picture is one more exemplar of the map, at its own place.
    let made = map(&folder, "b.exr");
    let names: Vec<&str> = made.exemplars.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["cobbles.png", "a.png"]);
    let from_picture = |at: &[u32; 2]| made.map.locate(*at).is_some_and(|(source, _)| source == 1);
    assert!(made.map.domain().positions().filter(from_picture).all(|at| made.map.locate(at).unwrap().1 == at));
    assert!(made.map.domain().positions().all(|at| from_picture(&at) == white(at)), "black was woven anew");
    let masks = "--mask none --mask fixed.png --fixed fixed.png";
    folder.run(&format!("apply b.exr @/cobbles.png a.png -o again.png --spline 3 {masks}")).done();
    assert_eq!(samples(&folder, "again.png"), samples(&folder, "b.png"));
    let refused = folder.run("apply b.exr @/cobbles.png a.png -o n.png --spline 3 --fixed @/stars.png");
    refused.refused(3, &["stars.png'", "128x128 px", "70x60 px"]);
    let refused = folder.run("apply b.exr @/cobbles.png a.png -o n.png --spline 3 --mask none");
    refused.refused(3, &["'b.exr'", "2 exemplar(s)", "1 mask(s)"]);
}

/// The scale wanted at a part of the way down and across.
type Field = fn(f64, f64) -> f64;

#[test]
fn each_place_takes_the_scale_that_the_field_has_there() {
    let folder = Folder::new("graphcut-field");
    write(&folder, "ramp.png", [2, 7], 3, |_, [_, x]| (x * 42) as u8);
    let fields: [(&str, Field); 3] = [
        ("top=0.5,bottom=1.5", |y, _| 0.5 + y),
        ("left=2,top=0.5", |y, x| (0.5 + 0.5 * y) * (2.0 - x)),
        ("ramp.png --scale-range 0.5..2", |_, x| 0.5 + 1.5 * (x * 7.0 - 0.5).clamp(0.0, 6.0) * 42.0 / 255.0),
    ];
    for (field, scale) in fields {
        let line = format!("graphcut @/cobbles.png -o out.png --map m.exr --size 80x90 {QUICK} --mirror");
        folder.run(&format!("{line} --scale-field {field}")).done();
        let file = map(&folder, "m.exr");
        for at in file.map.domain().positions() {
            let (source, _) = file.map.locate(at).unwrap();
            let found = match file.map.table.sources()[source].0.transform {
                Transform::Resampled { scale, .. } => scale,
                _ => 1.0,
            };
            let wanted = scale((f64::from(at[0]) + 0.5) / 90.0, (f64::from(at[1]) + 0.5) / 80.0);
            let off = (found / wanted).max(wanted / found);
            assert!(
                off * off * off * off <= 1.2 * 1.2 * 1.2 + 1e-6,
                "three quarters of a step: {field}: {found} for {wanted} at {at:?}"
            );
        }
        folder.run("apply m.exr @/cobbles.png -o again.png").done();
        assert_eq!(samples(&folder, "out.png"), samples(&folder, "again.png"));
    }
}

#[test]
fn the_command_inside_makes_it_again() {
    let folder = Folder::new("graphcut-provenance");
    for name in ["cobbles.png", "stars.png"] {
        fs::copy(crate::program::fixtures() + "/" + name, folder.path(name)).unwrap();
    }
    let lines = [
        format!(
            "graphcut cobbles.png -o a.png --map a.exr --size 60x50 {QUICK} --rotate -30,20 --scale 0.8 --feather 1.5"
        ),
        "graphcut cobbles.png -o a.png --start a.exr --rotate -30,20 --scale 0.8 --region 9 --refine 3".into(),
        format!("graphcut cobbles.png -o a.png --size 40 {QUICK} --scale-field stars.png --scale-range 0.8..1.25"),
        "graphcut cobbles.png -o a.png --size 60x50 --region 24x16 --reach 6x9 --placement sub --refine 2".into(),
        "graphcut cobbles.png -o a.png --over stars.png --fixed stars.png --region 16 --refine 1 --tries 1".into(),
    ];
    for line in lines {
        folder.run(&line).done();
        let info = folder.run("info a.png --json").done().json();
        let command = info["stats"]["made_by_selvedge"]["command"].as_str().unwrap();
        folder.run(&(command.strip_prefix("selvedge ").unwrap().to_owned() + " -o b.png")).done();
        assert_eq!(fs::read(folder.path("a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap(), "{command}");
    }
}

#[test]
fn tiny_and_constant_exemplars_are_woven() {
    let folder = Folder::new("graphcut-tiny");
    for (name, shape) in [("one.png", [1, 1]), ("row.png", [1, 50]), ("column.png", [50, 1]), ("flat.png", [40, 40])] {
        write(&folder, name, shape, 3, |_, _| 7);
        for options in
            ["--size 9x5", "--size 30x20 --tile xy", "--size 1 --feather 2", "--size 12 --placement entire --spline 2"]
        {
            let line = format!("graphcut {name} -o out.png {options}");
            folder.run(&line).done();
            assert!(
                matches!(samples(&folder, "out.png"), Samples::U8(g) if g.samples().iter().all(|v| *v == 7)),
                "{line}"
            );
        }
    }
}

/// Command lines that fail, their codes, and what their lines name.
const REFUSED: [(&str, i32, &[&str]); 31] = [
    ("", 3, &["'small.png'", "16 samples", "[9, 12]", "use --region 9 or a larger exemplar"]),
    ("--region 9x10", 3, &["'small.png'", "a region of [10, 9] samples", "[9, 12]"]),
    ("--region 4x", 2, &["'4x'", "48x32 (width by height)"]),
    ("--region 0x4", 2, &["region is 0", "at least 1"]),
    ("--reach -1", 2, &["'-1'", "24x16 (across by down)"]),
    ("--refine -1", 2, &["'-1'", "--refine"]),
    ("--tries 0", 2, &["tries is 0", "1 to 64"]),
    ("--feather nan", 2, &["feather is NaN", "0 to 16"]),
    ("--feather 17", 2, &["feather is 17", "0 to 16"]),
    ("--spline 6", 2, &["spline is 6", "0 to 5"]),
    ("--feather 1 --spline 1", 2, &["--feather", "--spline"]),
    ("--rotate nan", 2, &["'nan' is no angle"]),
    ("--scale 0", 2, &["'0' is no scale", "0.0625 to 16"]),
    ("--scale -1", 2, &["'-1' is no scale"]),
    ("--scale nan", 2, &["'nan' is no scale"]),
    ("--scale 2 --scale-field top=2", 2, &["--scale", "--scale-field"]),
    ("--scale-field top=nan", 2, &["'nan' is no scale", "0.0625 to 16"]),
    ("--scale-field top=0,bottom=1", 2, &["'0' is no scale"]),
    ("--scale-field top=-1", 2, &["'-1' is no scale"]),
    ("--scale-field top=16,left=16", 2, &["1 to 256", "0.0625 to 16"]),
    ("--scale-field top=0.5,bottom=4 --scale-step 1.02", 2, &["106 scales", "choose from 64", "--scale-step"]),
    ("--scale-field top=0.5 --scale-step 1", 2, &["'1' is no step"]),
    ("--scale-field top=0.5 --tile y", 2, &["0.5 at the top", "along y", "--tile"]),
    ("--scale-field top=0.5 --scale-range 1..2", 2, &["--scale-range 1..2", "sides"]),
    ("--scale-range 1..2", 2, &["--scale-field"]),
    ("--scale-field small.png", 2, &["'small.png'", "--scale-range"]),
    ("--scale-field small.png --scale-range 2..1", 2, &["backwards", "1..2"]),
    ("--scale-field nan.exr --scale-range 1..2", 3, &["'nan.exr'", "--nonfinite"]),
    ("--scale-field none.png --scale-range 1..2", 4, &["'none.png'", "not found"]),
    ("--fixed small.png", 2, &["--start or --over"]),
    ("--mask black.png", 3, &["'small.png'", "no sample can be used"]),
];

#[test]
fn what_cannot_be_done_is_refused_in_one_line() {
    let folder = Folder::new("graphcut-refused");
    write(&folder, "small.png", [9, 12], 3, |c, [y, x]| (y * 20 + x * 3 + c as u32) as u8);
    write(&folder, "black.png", [9, 12], 1, |_, _| 0);
    let field = Grid::from_vec(Domain::open([1, 2]), 1, vec![0.5, f32::NAN]).unwrap();
    let field = Plane::new(Role::Scalar, Samples::F32(field));
    selvedge_io::write(folder.path("nan.exr"), &field, &Metadata::default(), &WriteOptions::default()).unwrap();
    let before = folder.names();
    for (options, exit, parts) in REFUSED {
        let region = match options {
            "" => "--region 16",
            _ if options.contains("--region") => "",
            _ => "--region 4",
        };
        let said = folder.run(&format!("graphcut small.png -o a.png {region} {options}")).refused(exit, parts);
        assert!(said.stdout.is_empty());
        assert_eq!(folder.names(), before, "{options}");
    }
}

#[test]
fn a_dry_run_tells_what_the_run_will_choose() {
    let folder = Folder::new("graphcut-dry");
    for line in
        ["@/cobbles.png --size 60 --refine 1", "@/weave.png --size 40x30 --refine 1 --scale-field top=0.8,bottom=1.2"]
    {
        let line = format!("graphcut {line} --json -o");
        let dry = folder.run(&format!("{line} dry.png --dry-run")).done();
        assert!(dry.stderr.contains(" px, ") && dry.stderr.contains(" placement, with about "), "{dry:?}");
        let made = folder.run(&format!("{line} made.png")).done().json();
        assert_eq!(dry.json()["options"], made["options"], "{line}");
    }
}

#[test]
fn small_exemplars_and_pictures_without_holes_are_named() {
    let folder = Folder::new("graphcut-small");
    write(&folder, "small.png", [9, 12], 3, |c, [y, x]| (y * 20 + x * 3 + c as u32) as u8);
    let said = folder.run("graphcut small.png @/cobbles.png -o a.png --size 64 --refine 0").done();
    assert!(said.stderr.contains("'small.png': smaller than the regions of"), "{}", said.stderr);
    let said = folder.run("graphcut @/cobbles.png -o b.png --over @/cobbles.png --refine 0").done();
    assert!(said.stderr.contains("the picture has no holes, and no --fixed makes some"), "{}", said.stderr);
}

#[test]
fn equal_orientations_of_a_field_are_one_source() {
    let folder = Folder::new("graphcut-orientations");
    let line =
        "graphcut @/weave.png --size 60 --scale-field top=0.8,bottom=1.2 --placement random --region 12 --refine 0";
    folder.run(&format!("{line} -o a.png")).done();
    // A turn that rounds to a whole one is the same at scale 1, but not at others.
    folder.run(&format!("{line} --rotate=-1e-20 -o b.png --map b.exr")).done();
    let read = map(&folder, "b.exr").map;
    let scale = |[y, x]: [u32; 2]| match read.table.sources()[read.locate([y, x]).unwrap().0].0.transform {
        Transform::Resampled { scale, .. } => scale,
        _ => 1.0,
    };
    assert!((0..60).all(|x| scale([0, x]) < 1.0 && 1.0 < scale([59, x])));
}
