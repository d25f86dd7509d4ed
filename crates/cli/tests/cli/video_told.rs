//! What `video` answers with, and what a dry run says of it.

use std::fs;

use serde_json::Value;

use crate::program::Folder;
use crate::video::{bytes, clip};

const FIRE: &str = "@/fire.png";

/// A grey y4m clip of 14 frames of 24x24 px.
fn grey(folder: &Folder, name: &str, value: impl Fn([i32; 3]) -> i32) {
    let mut bytes = b"YUV4MPEG2 W24 H24 F25:1 Cmono XCOLORRANGE=FULL\n".to_vec();
    for t in 0..14 {
        bytes.extend(b"FRAME\n");
        bytes.extend((0..24 * 24).map(|i| value([t, i / 24, i % 24]).clamp(0, 255) as u8));
    }
    fs::write(folder.path(name), bytes).unwrap();
}

/// The mode of a run, and the largest step that it answers with, beside the largest that is usual, squared.
fn step(json: &Value) -> (String, f64) {
    let stats = &json["stats"];
    let number = |value: &Value| value.as_f64().unwrap();
    match stats["mode"].as_str().unwrap() {
        "transition" => ("transition".into(), number(&stats["closure"]["whole"])),
        mode => {
            let motion = &stats["motion"];
            let worst = number(&motion["largest"]).max(number(&motion["over_end"]));
            (mode.into(), worst * worst)
        }
    }
}

#[test]
fn the_answer_never_steps_more_than_what_was_refused_for_it() {
    let folder = Folder::new("video-better");
    // What grows lighter has to fall back somewhere, wherever patches lie; a disk that grows shrinks step by step.
    grey(&folder, "lighter.y4m", |[t, ..]| 20 + 15 * t);
    grey(&folder, "disk.y4m", |[t, y, x]| if (x - 12).pow(2) + (y - 12).pow(2) < (t + 1).pow(2) { 230 } else { 20 });
    for (clip, expected, why) in
        [("lighter.y4m", "transition", "temporal makes steps"), ("disk.y4m", "temporal", "the best jump makes steps")]
    {
        let run = |options: &str| folder.run(&format!("video {clip} -o out.y4m --json {options}")).done().json();
        let (mode, worst) = step(&run(""));
        let [(_, jump), (_, woven)] = ["--mode transition", "--mode temporal"].map(|options| step(&run(options)));
        assert!(1.05 < jump, "{clip}: a jump closes");
        assert_eq!((mode.as_str(), worst), (expected, jump.min(woven)), "{clip}: a jump {jump}, woven {woven}");
        assert!(run("")["stats"]["why"].as_str().unwrap().starts_with(why));
    }
}

#[test]
fn a_dry_run_refuses_what_the_run_refuses() {
    let folder = Folder::new("video-dry");
    for (line, code, said) in [
        ("--period 41", 3, "a clip of 40 frames has no loop of 41"),
        ("--jump 90,3", 3, "no jump back from frame 90"),
        ("--mode transition --frames 50", 3, "a clip of 40 frames has no loop of 50"),
    ] {
        for dry in ["", " --dry-run"] {
            folder.run(&format!("video {FIRE} -o out.##.png {line}{dry}")).refused(code, &["fire.png", said]);
        }
    }
    fs::write(folder.path("rate.y4m"), "YUV4MPEG2 W2 H2 F0:1 Cmono\nFRAME\nabcdFRAME\nabcd").unwrap();
    folder.run("video rate.y4m -o out.y4m").refused(3, &["rate.y4m", "'0:1' is no rate"]);
}

#[test]
fn a_dry_run_tells_frames_and_sizes_as_they_will_be() {
    let folder = Folder::new("video-would");
    for (line, said, frames) in [
        ("", "a loop of at most 40 frames of 48x60 px", None),
        ("--period 10", "a loop of 10 frames of 48x60 px", Some(10)),
        ("--period 8..12", "a loop of 8 to 12 frames of 48x60 px", None),
        ("--period 30..90", "a loop of 30 to 40 frames of 48x60 px", None),
        ("--jump 19,4", "a loop of 16 frames of 48x60 px", Some(16)),
        ("--period 10 --repeat 3 --closing-frame", "a loop of 10 frames", Some(31)),
        ("--mode temporal --frames 50", "a loop of 50 frames of 48x60 px", Some(50)),
        ("--play loop --frames 70", "70 frames of 48x60 px", Some(70)),
        ("--size 56x64x14", "a loop of 14 frames of 56x64 px", Some(14)),
    ] {
        let dry = folder.run(&format!("video {FIRE} -o out.##.png --dry-run --json {line}")).done();
        assert!(dry.stderr.contains(said), "{line}: {}", dry.stderr);
        let output = &dry.json()["outputs"][0];
        let size = if line.starts_with("--size") { [56, 64] } else { [48, 60] };
        assert_eq!([&output["width"], &output["height"]], size.map(Value::from).each_ref(), "{line}");
        let input = &dry.json()["inputs"][0];
        assert_eq!((&input["frames"], &input["container"]), (&40.into(), &"apng".into()), "{line}");
        assert_eq!((&output["path"], &output["frames"]), (&"out.##.png".into(), &Value::from(frames)), "{line}");
    }
    // Where what would be woven in place of a jump takes too much, the jump alone is what is left.
    let told = |line: &str| {
        let dry = folder.run(&format!("video {FIRE} -o out.##.png --dry-run --json {line}")).done().json();
        dry["estimated_memory_bytes"].as_u64().unwrap()
    };
    let (auto, jump) = (told(""), told("--mode transition"));
    assert!(jump < auto, "{jump} {auto}");
    assert_eq!(told(&format!("--max-memory {}KiB", jump.div_ceil(1024))), jump);
    // Where that does as well, the clip is read again for each step.
    let again = told(&format!("--max-memory {}KiB", jump / 1024 - 1));
    assert!(again < jump, "{again} {jump}");
    let refused = format!("video {FIRE} -o out.##.png --dry-run --max-memory {}KiB", again / 1024 - 1);
    folder.run(&refused).refused(6, &["fire.png"]);
    let pictures = folder.run("quilt @/scales.png -o a.png --size 64x48 --map m.exr --dry-run --json").done().json();
    let outputs = pictures["outputs"].as_array().unwrap();
    assert_eq!(outputs.iter().map(|o| &o["path"]).collect::<Vec<_>>(), ["a.png", "m.exr"]);
    assert!(outputs.iter().all(|o| o["width"] == 64 && o["height"] == 48), "{pictures}");
    assert!(folder.names().is_empty());
}

#[test]
fn what_is_woven_tells_at_how_many_sizes_and_a_jump_has_one() {
    let folder = Folder::new("video-levels");
    let levels = |options: &str| {
        folder.run(&format!("video {FIRE} -o out.y4m --json {options}")).done().json()["options"]["levels"].clone()
    };
    for (options, expected) in [
        ("--mode temporal --frames 50", 2),
        ("--mode temporal --frames 50 --levels 1", 1),
        ("--mode temporal --frames 50 --levels 3", 2),
        ("--mode temporal --frames 50 --loop fixed", 2),
        ("--mode temporal --frames 50 --loop fixed --levels 1", 1),
        ("--mode temporal --frames 50 --checkpoint kept", 1),
        ("--mode temporal --frames 50 --paper", 1),
        ("--mode spacetime --size 56x60x20 --region 20x20x8", 2),
    ] {
        assert_eq!(levels(&format!("{options} --refine 1")), expected, "{options}");
    }
    assert_eq!(levels("--mode transition --jumps 1"), Value::Null, "one size does nothing more than none");
    let line = format!("video {FIRE} -o out.y4m --mode temporal");
    folder.run(&format!("{line} --levels 2 --checkpoint kept")).refused(2, &["runs at one size", "--levels 1"]);
    folder.run(&format!("{line} --levels 6")).refused(2, &["'6' is no number of sizes"]);
}

#[test]
fn files_carry_the_jump_that_was_taken_and_are_made_again_by_it() {
    let folder = Folder::new("video-made-again");
    for (line, jumps) in [("--mode transition", true), ("--blend 5 --period 12..20", true), ("--mode temporal", false)]
    {
        let said = folder.run(&format!("video {FIRE} -o a.##.png --json {line}")).done().json();
        let jump = &said["stats"]["jump"];
        let expected = jumps.then(|| format!("{},{}", jump["from"], jump["to"]));
        assert_eq!(said["options"]["jump"].as_str(), expected.as_deref(), "{line}");
        assert_eq!(said["options"]["period"].as_str(), None, "{line}: another jump may have it");
        let first = folder.names().into_iter().filter(|name| name.ends_with(".png")).min().unwrap();
        folder.run(&format!("again {first} -o b.##.png --look-in @/ --quiet")).done();
        let [made, again] = ["a.##.png", "b.##.png"].map(|name| clip(&folder, name));
        assert!(bytes(&made) == bytes(&again), "{line}");
        folder.names().iter().for_each(|name| fs::remove_file(folder.path(name)).unwrap());
    }
}

#[test]
fn the_surface_of_another_jump_is_refused() {
    let folder = Folder::new("video-surface");
    folder.run(&format!("video {FIRE} -o a.##.png --jump 19,4 --surface s.exr --quiet")).done();
    folder.run(&format!("video {FIRE} -o b.##.png --period 16 --surface s.png --quiet")).done();
    let before = folder.names();
    for (surface, jump) in [("s.exr", "20,5"), ("s.png", "19,4")] {
        let line = format!("video {FIRE} -o c.##.png --jump {jump} --surface-from {surface}");
        folder.run(&line).refused(3, &[surface, "is the surface of jump", &format!("not of {jump}"), "use --jump"]);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn frames_are_told_by_their_files_too() {
    let folder = Folder::new("video-files");
    folder.run(&format!("video {FIRE} -o a.##.png --period 20 --quiet")).done();
    fs::remove_file(folder.path("a.json")).unwrap();
    (1..=20).rev().for_each(|n| {
        fs::rename(folder.path(format!("a.{n:02}.png")), folder.path(format!("a.{}.png", n + 70))).unwrap()
    });
    let said = folder.run("video a.##.png -o b.##.png --jump 16,4 --range 73-90").done();
    assert!(
        said.stderr.contains("13 frames, 4 to 16") && said.stderr.contains("'a.77.png' to 'a.89.png'"),
        "{}",
        said.stderr
    );
    let said = folder.run(&format!("video {FIRE} -o c.##.png --jump 16,4")).done();
    assert!(!said.stderr.contains("' to '"), "one file has no numbers: {}", said.stderr);
}

#[test]
fn what_a_longer_loop_left_is_told_once_the_period_is_known() {
    let folder = Folder::new("video-left");
    folder.run(&format!("video {FIRE} -o g.##.png --period 30 --quiet")).done();
    let said = folder.run(&format!("video {FIRE} -o g.##.png --period 14..16")).done();
    assert!(said.stderr.contains("is left over from a longer run, as are 1"), "{}", said.stderr);
    let said = folder.run(&format!("video {FIRE} -o g.gif --rate 60 --period 14")).done();
    assert!(said.stderr.contains("browsers play no GIF faster than 50"), "{}", said.stderr);
    let said = folder.run(&format!("video {FIRE} -o g.gif --rate 50 --period 14")).done();
    assert!(!said.stderr.contains("browsers"), "{}", said.stderr);
}
