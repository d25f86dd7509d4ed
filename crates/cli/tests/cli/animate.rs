//! `selvedge animate` from outside.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::clip::{ClipWriteOptions, ClipWriter};
use selvedge_io::{Metadata, WriteOptions};

use crate::program::{Folder, fixtures};

fn flo(width: i32, height: i32, vector: [f32; 2]) -> Vec<u8> {
    let mut bytes = b"PIEH".to_vec();
    bytes.extend([width, height].iter().flat_map(|n| n.to_le_bytes()));
    let vectors = (0..width * height).flat_map(|_| vector);
    bytes.extend(vectors.flat_map(f32::to_le_bytes));
    bytes
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let folder = Folder::new("animate-refused");
    fs::write(folder.path("good.flo"), flo(40, 32, [1.0, 0.0])).unwrap();
    fs::write(folder.path("cut.flo"), &flo(40, 32, [1.0, 0.0])[..99]).unwrap();
    fs::write(folder.path("nan.flo"), flo(40, 32, [f32::NAN, 0.0])).unwrap();
    for (name, width) in [("v.1.flo", 40), ("v.2.flo", 41)] {
        fs::write(folder.path(name), flo(width, 32, [1.0, 0.0])).unwrap();
    }
    for name in ["m.1.png", "m.2.png"] {
        fs::copy(format!("{}/stars.png", fixtures()), folder.path(name)).unwrap();
    }
    let refused = [
        ("--flow whirl", 2, "'whirl' is no flow; write sink"),
        ("--flow missing.flo", 4, "'missing.flo'"),
        ("--flow cut.flo", 3, "'cut.flo': damaged flo file (99 of 10252 bytes)"),
        ("--flow nan.flo", 3, "'nan.flo': 1280 value(s) are not finite"),
        ("--flow nan.flo", 3, "; mark these vectors as unknown, or give numbers"),
        ("--flow good.flo --flow-scale 1e39 --dry-run", 2, "use a smaller --flow-scale"),
        ("--flow sink --speed 1e300 --dry-run", 2, "out of range; use -1000000 to 1000000"),
        ("--flow sink --size 48 --schedule 1:256 --dry-run", 3, "scales.png': no neighborhood of 256 px"),
        ("--flow v.#.flo", 3, "'v.2.flo': 41x32 vectors, but the first one has 40x32"),
        ("--flow w.#.flo", 4, "w.#.flo"),
        ("--flow @/weave.png", 3, "is no flow; it holds a PNG"),
        ("--flow good.flo --size 64", 3, "the flow has 40x32 vectors, but --size asks for 64x64 px"),
        ("--flow good.flo --speed 2", 2, "--speed is about fields"),
        ("--flow vortex --angle 20", 2, "--angle is about the uniform field, and --flow is vortex; leave it out"),
        ("--flow curl-noise --center 3,4", 2, "--center is about fields that have a middle, and --flow is curl-noise"),
        ("--flow sink --flow-scale 2", 2, "--flow-scale is about vectors of files, and --flow is sink"),
        ("--flow sink --flow-direction backward", 2, "--flow-direction is about vectors of files"),
        ("--flow sink --speed nan", 2, "speed of NaN"),
        ("--flow sink --center 3", 2, "'3' is no place; write a column"),
        ("--flow sink --lambda -1", 2, "lambda of -1"),
        ("--flow sink --lambda 1e308", 2, "use 0 (no wish) to 1000000"),
        ("--flow sink --schedule 1:10", 2, "use a multiple of 4"),
        ("--flow sink --schedule 1:64 --size 32", 3, "no neighborhood of 64 px"),
        ("--flow sink --init map.exr", 2, "write auto, quilt"),
        (
            "--flow sink --frames 5 --close 5",
            2,
            "--close 5 leaves no frame as it is, of 5; use --close 4 or less, or ask for more --frames",
        ),
        ("--flow sink --within @/stars.png", 3, "stars.png': 128x128 px, but the frames have 384x384 px"),
        ("--flow sink --within m.#.png --frames 3", 3, "2 masks for 3 frames; use --frames 2"),
        ("--flow sink --seed 1..3", 2, "3 seeds for one clip"),
    ];
    for (options, exit, named) in refused {
        folder.run(&format!("animate @/scales.png -o a.##.png {options}")).refused(exit, &[named]);
    }
    let pixel = Plane::new(Role::Color, Samples::U8(Grid::try_filled(Domain::open([1, 1]), 3, 9).unwrap()));
    selvedge_io::write(folder.path("px1.png"), &pixel, &Metadata::default(), &WriteOptions::default()).unwrap();
    folder
        .run("animate px1.png -o a.##.png --flow sink --size 64 --init random --dry-run")
        .refused(3, &["px1.png': no neighborhood of 8 px"]);
    folder.run("animate @/scales.png -o a.webp --flow sink").refused(2, &["webp"]);
    assert_eq!(folder.names().len(), 8, "{:?}", folder.names());
}

#[test]
fn sizes_below_the_first_frame_s_serve_exemplars_that_hold_nothing_larger() {
    let folder = Folder::new("animate-small");
    let samples = (0..7 * 6 * 3).map(|i| (i * 37 % 251) as u8).collect();
    let small = Plane::new(Role::Color, Samples::U8(Grid::from_vec(Domain::open([7, 6]), 3, samples).unwrap()));
    selvedge_io::write(folder.path("small.png"), &small, &Metadata::default(), &WriteOptions::default()).unwrap();
    let line = "animate small.png -o a.##.png --flow sink --size 20x16 --frames 2";
    folder.run(line).refused(3, &["no neighborhood of 8 px"]);
    folder.run(&format!("{line} --schedule 1:4")).done();
    assert!(folder.path("a.02.png").exists());
    // Others have the first frame that they have without.
    let large = "animate @/scales.png --flow sink --size 40x40 --frames 1";
    folder.run(&format!("{large} -o b.#.png")).done();
    folder.run(&format!("{large} -o c.#.png --schedule 1:16,1:4")).done();
    let [b, c] = ["b.1.png", "c.1.png"].map(|name| selvedge_io::read(folder.path(name), &Default::default()).unwrap());
    assert!(b.plane == c.plane);
}

#[test]
fn frames_follow_one_file_or_one_each_and_are_made_again() {
    let folder = Folder::new("animate-files");
    for name in ["v.1.flo", "v.2.flo"] {
        fs::write(folder.path(name), flo(40, 32, [1.5, 0.0])).unwrap();
    }
    let line = "animate @/scales.png --init quilt --seed 3";
    let each = folder.run(&format!("{line} --flow v.#.flo -o each.#.png --json")).done().json();
    assert_eq!((&each["options"]["frames"], &each["options"]["size"]), (&3.into(), &"40x32".into()));
    let frames = each["stats"]["frames"].as_array().unwrap();
    let is_number = |key: &str| frames.iter().map(|frame| frame[key].is_f64()).collect::<Vec<_>>();
    assert_eq!(["sharpness", "completeness", "energy"].map(is_number), [[true; 3], [true; 3], [false, true, true]]);
    let one = folder.run(&format!("{line} --flow v.1.flo --frames 3 -o one.#.png")).done();
    drop(one);
    let read = |name: &str| selvedge_io::read(folder.path(name), &Default::default()).unwrap().plane;
    for frame in 1..=3 {
        assert_eq!(read(&format!("each.{frame}.png")), read(&format!("one.{frame}.png")));
    }
    assert_ne!(read("one.1.png"), read("one.3.png"));
    fs::create_dir(folder.path("flows")).unwrap();
    for name in ["v.1.flo", "v.2.flo"] {
        fs::copy(folder.path(name), folder.path("flows").join(name)).unwrap();
    }
    let folded = folder.run(&format!("{line} --flow flows -o folded.#.png --json --dry-run")).done().json();
    assert_eq!(folded["options"]["frames"], 3, "a folder of .flo files is one frame each");
    folder.run("again one.2.png -o again.#.png --look-in @").done();
    assert_eq!(fs::read(folder.path("again.2.png")).unwrap(), fs::read(folder.path("one.2.png")).unwrap());
    folder.run("again each.2.png -o more.#.png --look-in @").done();
    assert_eq!(fs::read(folder.path("more.2.png")).unwrap(), fs::read(folder.path("each.2.png")).unwrap());
    let dry = folder.run(&format!("{line} --flow v.#.flo -o dry.#.png --json --dry-run")).done().json();
    assert_eq!(dry["options"], each["options"]);
    let (clip, planned) = (&each["outputs"][0], &dry["outputs"][0]);
    assert_eq!((&clip["path"], &clip["blake3"].is_string()), (&"each.#.png".into(), &true));
    for (name, value) in [("width", 40), ("height", 32), ("frames", 3)] {
        assert_eq!((&clip[name], &planned[name]), (&value.into(), &value.into()), "{name}");
    }
    assert!(!folder.path("dry.1.png").exists());
}

#[test]
fn a_clip_as_exemplar_goes_on_while_it_flows() {
    let folder = Folder::new("animate-clip");
    // Frames of a clip that are unlike each other: each frame that is made has the samples of its own one alone.
    let mut packed = ClipWriter::create("all.png", 3, Metadata::default(), ClipWriteOptions::default()).unwrap();
    for (number, from) in [(1, 0_u8), (2, 85), (3, 170)] {
        let noise: Vec<u8> =
            (0..48 * 40_u32).map(|i| from + (i.wrapping_mul(2_654_435_761) >> 25) as u8 % 80).collect();
        let samples = Samples::U8(Grid::from_vec(Domain::open([40, 48]), 1, noise).unwrap());
        let plane = Plane::new(Role::Color, samples);
        let path = folder.path(format!("in.{number}.png"));
        selvedge_io::write(path, &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
        packed.encoded(&plane).unwrap();
    }
    let line = "animate in.#.png --flow uniform --speed 1.5 --size 40x32 --init quilt --seed 3";
    let made = folder.run(&format!("{line} -o {{stem}}-out.#.png --frames 5 --json")).done().json();
    assert_eq!(made["inputs"].as_array().map(Vec::len), Some(3));
    for frame in 1..=5_u8 {
        let plane = selvedge_io::read(folder.path(format!("in-out.{frame}.png")), &Default::default()).unwrap().plane;
        let Samples::U8(samples) = plane.samples else { panic!("8 bits") };
        let from = 85 * ((frame - 1) % 3);
        assert!(samples.samples().iter().all(|v| (from..from + 80).contains(v)), "{frame}");
    }
    folder.run("again in-out.4.png -o again.#.png --look-in @").done();
    assert_eq!(fs::read(folder.path("again.4.png")).unwrap(), fs::read(folder.path("in-out.4.png")).unwrap());
    let dry = folder.run(&format!("{line} -o dry.#.png --json --dry-run")).done().json();
    assert_eq!(dry["options"]["frames"], 3, "as many as the clip has");
    // The same in one file.
    fs::write(folder.path("all.png"), &packed.ended().unwrap()[0].1).unwrap();
    let line_of_packed = line.replace("in.#.png", "all.png");
    let made = folder.run(&format!("{line_of_packed} -o {{stem}}-out.#.png --frames 5 --json")).done().json();
    let inputs = made["inputs"].as_array().unwrap();
    assert_eq!((inputs.len(), &inputs[0]["path"], &inputs[0]["frames"]), (1, &"all.png".into(), &3.into()));
    let read = |name: &str| selvedge_io::read(folder.path(name), &Default::default()).unwrap().plane;
    for frame in 1..=5 {
        assert!(read(&format!("all-out.{frame}.png")) == read(&format!("in-out.{frame}.png")), "{frame}");
    }
    folder.run("again all-out.4.png -o packed.#.png --look-in @").done();
    assert_eq!(fs::read(folder.path("packed.4.png")).unwrap(), fs::read(folder.path("all-out.4.png")).unwrap());
    let beside = "all.png': is a clip, beside 1 exemplar; give the clip alone";
    folder.run(&format!("{line_of_packed} @/weave.png -o no.#.png")).refused(2, &[beside]);
    let refused = [
        ("--frames 10 --close 3", "--close after 10 frames, where a clip of 3 has not come around; use --frames 12"),
        ("@/weave.png", "in.#.png': is a clip, beside 1 exemplar; give the clip alone"),
        ("--mask in.1.png --mask in.2.png", "2 masks"),
    ];
    for (options, named) in refused {
        folder.run(&format!("{line} -o no.#.png {options}")).refused(2, &[named]);
    }
    fs::copy(format!("{}/stars.png", fixtures()), folder.path("in.4.png")).unwrap();
    let of_size = "in.4.png': 128x128 px, but the first frame has 48x40 px";
    folder.run(&format!("{line} -o no.#.png")).refused(3, &[of_size]);
}
