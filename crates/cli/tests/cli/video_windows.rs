//! Clips that are woven some frames at a time.

use std::collections::BTreeMap;
use std::fs;

use selvedge_core::{Grid, Plane, Samples};
use selvedge_io::Metadata;
use selvedge_io::clip::{ClipOptions, ClipReader, ClipWriteOptions, ClipWriter};

use crate::graphcut::samples;
use crate::program::{Folder, fixtures};

const FIRE: &str = "@/fire.png";

/// All files that a run left in `out`, but for what tells their hashes, and the frames that were woven at once.
fn made(folder: &Folder, line: &str) -> (BTreeMap<String, Vec<u8>>, serde_json::Value) {
    fs::create_dir_all(folder.path("out")).unwrap();
    let json = folder.run(&format!("video {FIRE} -o out/a.###.png --refine 2 --json {line}")).done().json();
    let files = fs::read_dir(folder.path("out")).unwrap().map(|entry| entry.unwrap().path());
    let files = files.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap()));
    let files = files.collect();
    fs::remove_dir_all(folder.path("out")).unwrap();
    (files, json["options"]["at-once"].clone())
}

#[test]
fn less_memory_weaves_some_frames_at_a_time_and_says_so() {
    let folder = Folder::new("video-windows");
    for (line, tenths) in
        [("--mode temporal --frames 300", 9), ("--size 56x64x220", 9), ("--mode temporal --frames 300 --loop fixed", 6)]
    {
        let estimated = |limit: &str| {
            let dry = folder.run(&format!("video {FIRE} -o a.###.png --json --dry-run {line} {limit}")).done();
            (dry.json()["estimated_memory_bytes"].as_u64().unwrap(), dry.stderr)
        };
        let (whole, said) = estimated("");
        assert!(!said.contains("at once"), "{said}");
        let limit = format!("--max-memory {}KiB", whole * tenths / 10 / 1024);
        let (less, said) = estimated(&limit);
        let on = |threads: u32| estimated(&format!("{limit} -j {threads}")).1;
        assert_eq!((on(1), on(3)), (said.clone(), said.clone()), "frames at once do not depend on threads");
        assert!(less <= whole * tenths / 10 && said.contains("frames at once"), "{said}");
        let (files, at_once) = made(&folder, &format!("{line} {limit} -j 1"));
        assert!(at_once.as_u64().is_some_and(|frames| (20..300).contains(&frames)), "{at_once}");
        assert_eq!(files.len(), if line.contains("300") { 301 } else { 221 });
        let provenance = String::from_utf8_lossy(&files["a.001.png"]).into_owned();
        assert!(provenance.contains(&format!("--at-once {at_once}")), "{provenance}");
        // With memory for all, by what the provenance says; the command differs by the limit alone.
        for threads in [2, 3] {
            let again = made(&folder, &format!("{line} --at-once {at_once} -j {threads}"));
            assert!(again.0 == files, "{line} on {threads} threads");
        }
    }
}

#[test]
fn frames_at_once_are_refused_where_there_is_nothing_to_part() {
    let folder = Folder::new("video-windows-wrong");
    let refused = |line: &str, code: i32, said: &str| {
        folder.run(&format!("video {FIRE} -o a.###.png {line}")).refused(code, &[said]);
    };
    refused("--mode temporal --at-once 1", 2, "--at-once");
    refused("--mode temporal --at-once 4 --dry-run", 2, "weave 5 or more at once; 29 are enough for this clip");
    let few = "--mode temporal --at-once 5 --frames 90 --refine 0";
    refused(few, 2, "fire.png': 5 frames at once are too few, of this clip 21 are the least; weave 21 or more at once");
    refused("--mode temporal --at-once 30 --levels 2 --start m.##.exr", 4, "m.##.exr");
    refused("--mode transition --at-once 30", 2, "--at-once does nothing in --mode transition");
    refused("--mode temporal --frames 300 --max-memory 20MiB", 6, "fire.png");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn windows_loop_between_frames_of_the_clip() {
    let folder = Folder::new("video-windows-fixed");
    folder.run(&format!("video {FIRE} -o in.##.png --loop no --frames 30 --mode temporal --refine 0 --quiet")).done();
    let line = "video in.##.png --mode temporal --loop fixed --keep 4 --frames 70 --at-once 30 --refine 2 --json";
    let json = folder.run(&format!("{line} -o out.##.png")).done().json();
    assert_eq!((&json["stats"]["at_once"], &json["outputs"][0]["frames"]), (&30.into(), &70.into()));
    // The last four are the middle ones of 30, into which the ones before go as they do in all of the clip.
    for k in 0..4 {
        let [made, is] =
            [format!("out.{}.png", 67 + k), format!("in.{}.png", 14 + k)].map(|name| samples(&folder, &name));
        assert!(made == is, "{k}");
    }
    assert!(json["stats"]["motion"]["over_end"].as_f64().unwrap() < 1.5, "{json}");
}

#[test]
fn windows_make_maps_better() {
    let folder = Folder::new("video-windows-start");
    let spacetime = format!("video {FIRE} --mode spacetime --region 12x12x8 --json");
    folder.run(&format!("{spacetime} --size 40x40x60 --refine 0 --levels 1 -o a.##.png --map m.##.exr")).done();
    let totals = |line: &str| {
        let json = folder.run(&format!("{spacetime} --start m.##.exr --at-once 25 {line}")).done().json();
        assert_eq!((&json["options"]["at-once"], &json["options"]["start"]), (&25.into(), &"m.##.exr".into()));
        json["stats"]["settled"].as_array().unwrap().last().unwrap().as_i64().unwrap()
    };
    let before = totals("--refine 0 -o b.##.png");
    assert!((1..=60).all(|t| samples(&folder, &format!("a.{t:02}.png")) == samples(&folder, &format!("b.{t:02}.png"))));
    let after = totals("--refine 20 -o c.##.png --checkpoint kept");
    assert!(after < before, "{before} {after}");
    // The same line goes on from the last of the windows that were kept; without its maps it is another run.
    assert_eq!(totals("--refine 20 -o d.##.png --resume kept"), after);
    assert!((1..=60).all(|t| samples(&folder, &format!("c.{t:02}.png")) == samples(&folder, &format!("d.{t:02}.png"))));
    let without = format!("{spacetime} --size 40x40x60 --at-once 25 --refine 20 -o e.##.png --resume kept");
    folder.run(&without).refused(3, &["kept", "with --start"]);
}

/// The generated fire of the fixtures as other samples, one file a frame.
fn fire(folder: &Folder, name: &str, of: impl Fn(&Samples<2>) -> Samples<2>) {
    let mut reader = ClipReader::open(fixtures() + "/fire.png", &ClipOptions::default()).unwrap();
    let mut writer =
        ClipWriter::create(folder.path(name), 40, Metadata::default(), ClipWriteOptions::default()).unwrap();
    while let Some(frame) = reader.next().unwrap() {
        let samples = of(&frame.samples);
        writer.frame(&Plane { samples, ..frame }).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn clips_that_are_not_held_give_the_same_files() {
    let folder = Folder::new("video-windows-again");
    ["in.##.png", "b.##.png"].into_iter().for_each(|name| fire(&folder, name, Clone::clone));
    // Floats are encoded by all of their samples.
    fire(&folder, "f.##.exr", |samples| {
        let (domain, channels) = (samples.domain(), samples.channels());
        let values = (0..channels).flat_map(|c| (0..domain.len()).map(move |i| samples.value(c, i) as f32 / 64.0));
        Samples::F32(Grid::from_vec(domain, channels, values.collect()).unwrap())
    });
    for line in [
        "in.##.png --with b.##.png -o out/{name}.###.png --mode temporal --frames 200 --at-once 180 --closing-frame",
        "f.##.exr -o out/a.###.exr --size 56x64x90 --loop fixed --at-once 80",
    ] {
        fs::create_dir_all(folder.path("out")).unwrap();
        let run = |more: &str| {
            let said = folder.run(&format!("video {line} --refine 2 --json --verbose {more}")).done();
            let json = said.json();
            let files = folder.files();
            fs::remove_dir_all(folder.path("out")).unwrap();
            fs::create_dir_all(folder.path("out")).unwrap();
            (files, json, said.stderr)
        };
        let (held, json, said) = run("");
        assert!(!said.contains("read again"), "{said}");
        let dry = folder.run(&format!("video {line} --refine 2 --json --dry-run")).done().json();
        let limit = dry["estimated_memory_bytes"].as_u64().unwrap() / 1024 - 1;
        let (again, other, said) = run(&format!("--max-memory {limit}KiB"));
        assert!(said.contains("the clip is read again for what is written"), "{said}");
        assert!(held == again && 80 < held.len(), "{line}");
        for field in ["stats", "options", "inputs", "outputs"] {
            assert_eq!(json[field], other[field], "{field}");
        }
    }
}
