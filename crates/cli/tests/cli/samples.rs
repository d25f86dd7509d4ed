//! Samples bit for bit: maps applied again, depths, threads.

use std::fs;
use std::path::Path;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, ReadOptions, WriteOptions, decode};

use crate::program::Folder;

fn samples(folder: &Folder, name: &str) -> Samples<2> {
    let path = folder.path(name);
    decode(&fs::read(&path).unwrap(), &path, &ReadOptions::default()).unwrap().plane.samples
}

/// A weave of waves with values over 1, below 0 and next to it.
fn float_exemplar() -> Plane<2> {
    let domain = Domain::open([40, 48]);
    let mut grid = Grid::try_filled(domain, 3, 0.0_f32).unwrap();
    for c in 0..3 {
        for (i, value) in grid.plane_mut(c).iter_mut().enumerate() {
            let [y, x] = domain.position(i);
            let wave = ((x * 7 + y * 3 + c as u32) % 23) as f32 / 3.0 - 2.5;
            *value = if i % 97 == 0 { f32::MIN_POSITIVE / 4.0 } else { wave * 1.000_1 };
        }
    }
    Plane::new(Role::Color, Samples::F32(grid))
}

#[test]
fn a_map_gives_the_samples_of_the_output_again() {
    let folder = Folder::new("apply");
    let float = folder.path("float.exr");
    selvedge_io::write(&float, &float_exemplar(), &Metadata::default(), &WriteOptions::default()).unwrap();
    let Samples::F32(grid) = samples(&folder, "float.exr") else { panic!("the file is float") };
    assert!(grid.samples().iter().any(|v| *v < 0.0) && grid.samples().iter().any(|v| 1.0 < *v));
    let cases = [
        ("@/bricks/albedo.png", "png"),
        ("@/bricks/height.png", "png"),
        ("@/bricks/height.png", "tiff"),
        ("@/scales-hdr.exr", "exr"),
        ("float.exr", "exr"),
        ("float.exr", "tiff"),
    ];
    for (exemplar, extension) in cases {
        let (out, again) = (format!("out.{extension}"), format!("again.{extension}"));
        folder.run(&format!("quilt {exemplar} -o {out} --map map.exr --size 70x50 --block 12 --tile x")).done();
        // A height would be fused.
        folder.run(&format!("apply map.exr {exemplar} -o {again} --copy")).done();
        let (one, other) = (samples(&folder, &out), samples(&folder, &again));
        assert_eq!(one, other, "{exemplar} as {extension}");
        copied(&folder, &one, exemplar);
    }
}

/// Every sample stands in the exemplar where the map says.
fn copied(folder: &Folder, out: &Samples<2>, exemplar: &str) {
    let exemplar = exemplar.replace('@', &crate::program::fixtures());
    let from = samples(folder, &exemplar);
    let map = selvedge_io::read_map(folder.path("map.exr"), &Default::default()).unwrap().map;
    assert_eq!(map.domain().shape, [50, 70]);
    assert_eq!(map.domain().periodic, [false, true]);
    for at in map.domain().positions() {
        let (source, place) = map.locate(at).expect("every sample is assigned");
        assert_eq!(source, 0);
        for c in 0..out.channels() {
            let (a, b) = (out.value(c, map.domain().index(at)), from.value(c, from.domain().index(place)));
            assert_eq!(a.to_bits(), b.to_bits(), "{exemplar} at {at:?}");
        }
    }
}

#[test]
fn several_exemplars_are_applied_in_their_order() {
    let folder = Folder::new("several");
    let line = "quilt @/weave.png @/scales.png @/bricks/height.png -o out.png --map map.exr --size 120 --block 20";
    folder.run(line).done();
    folder.run("apply map.exr @/weave.png @/scales.png @/bricks/height.png -o again.png").done();
    assert_eq!(samples(&folder, "out.png"), samples(&folder, "again.png"));
    assert!(
        matches!(samples(&folder, "out.png"), Samples::U16(g) if g.channels() == 3),
        "8 bits and grey were widened"
    );
    folder
        .run("apply map.exr @/weave.png -o no.png")
        .refused(3, &["'map.exr'", "3 exemplars", "weave.png, scales.png"]);
    let twice = "apply map.exr @/weave.png @/scales.png @/bricks/height.png @/scales.png @/weave.png @/weave.png";
    folder.run(&format!("{twice} -o one.png")).refused(2, &["'one.png'", "{stem}"]);
    folder.run(&format!("{twice} -o x-{{stem}}.png")).done();
    assert!(folder.names().contains(&"x-weave.png".to_owned()) && folder.names().contains(&"x-scales.png".to_owned()));
}

#[test]
fn equal_runs_write_equal_files_on_any_number_of_threads() {
    let folder = Folder::new("equal");
    // Large enough for a PNG of several bands, which are packed on all threads.
    for exemplar in ["@/cobbles.png", "@/scales-hdr.exr"] {
        let extension = Path::new(exemplar).extension().unwrap().to_str().unwrap();
        let mut files = Vec::new();
        for (i, threads) in [1, 1, 2, 3, 8].into_iter().enumerate() {
            let out = format!("out-{i}.{extension}");
            let line = format!("quilt {exemplar} -o {out} --map m.exr --size 300x190 --seed 3 -j {threads}");
            folder.run(&line).done();
            files.push((fs::read(folder.path(out)).unwrap(), fs::read(folder.path("m.exr")).unwrap()));
        }
        assert!(files.windows(2).all(|pair| pair[0] == pair[1]), "{exemplar}");
        folder.run(&format!("quilt {exemplar} -o other.{extension} --size 300x190 --seed 4")).done();
        assert_ne!(fs::read(folder.path(format!("other.{extension}"))).unwrap(), files[0].0);
    }
}

#[test]
fn the_command_inside_of_a_picture_makes_it_again() {
    let folder = Folder::new("provenance");
    fs::copy(crate::program::fixtures() + "/weave.png", folder.path("weave.png")).unwrap();
    fs::create_dir(folder.path("deep")).unwrap();
    folder.run("quilt weave.png -o deep/a.png --size 0.5x --seed 9 --tile y -j 2 --progress none").done();
    let info = folder.run("info deep/a.png --json").done().json();
    let made = &info["stats"]["made_by_selvedge"];
    let command = made["command"].as_str().unwrap();
    assert!(command.starts_with("selvedge quilt weave.png --size 96x77 --tile y --block "), "{command}");
    assert_eq!((made["seed"].as_u64(), made["input"][0]["name"].as_str()), (Some(9), Some("weave.png")));
    let words = command.strip_prefix("selvedge ").unwrap().to_owned() + " -o b.png";
    folder.run(&words).done();
    assert_eq!(fs::read(folder.path("deep/a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap());
}

#[test]
fn masked_samples_are_never_used() {
    let folder = Folder::new("mask");
    // The left half may be used.
    let domain = Domain::open([192, 192]);
    let half = domain.positions().map(|[_, x]| if x < 96 { 255_u8 } else { 0 }).collect();
    let mask = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, half).unwrap()));
    selvedge_io::write(folder.path("m.png"), &mask, &Metadata::default(), &WriteOptions::default()).unwrap();
    let line = "quilt @/weave.png @/scales.png --mask m.png --mask none -o out.png --size 128 --block 24 --map map.exr";
    // Random blocks come from everywhere.
    folder.run(&format!("{line} --stage random")).done();
    let map = selvedge_io::read_map(folder.path("map.exr"), &Default::default()).unwrap().map;
    let from = |source: usize| map.domain().positions().filter_map(|at| map.locate(at)).filter(move |l| l.0 == source);
    assert!(from(0).all(|(_, [_, x])| x < 96));
    assert!(from(1).any(|(_, [_, x])| 96 <= x), "the other exemplar is not masked");
}

#[test]
fn depths_are_kept_or_converted() {
    let folder = Folder::new("depth");
    let depth = |line: &str, name: &str| {
        folder.run(line).done();
        samples(&folder, name).depth().name()
    };
    assert_eq!(depth("quilt @/bricks/height.png -o a.png --size 16", "a.png"), "u16");
    assert_eq!(depth("quilt @/bricks/height.png -o b.png --size 16 --depth u8", "b.png"), "u8");
    assert_eq!(depth("quilt @/scales-hdr.exr -o c.exr --size 16", "c.exr"), "half");
    assert_eq!(depth("quilt @/scales-hdr.exr -o d.exr --size 16 --depth float", "d.exr"), "float");
    assert_eq!(depth("quilt @/weave.png @/scales-hdr.exr -o e.exr --size 16 --depth half", "e.exr"), "half");
    let clipped = folder.run("quilt @/scales-hdr.exr -o f.png --size 16 --depth u16").done();
    assert!(clipped.stderr.contains("warning: ") && clipped.stderr.contains("clipped"), "{clipped:?}");
}
