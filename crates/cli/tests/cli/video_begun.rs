//! Clips that are woven on from maps, whose seams are blended, and the paper to the letter.

use selvedge_core::SourceMap;
use serde_json::Value;

use crate::graphcut::{map, samples};
use crate::program::Folder;

const SPACETIME: &str = "video @/fire.png --mode spacetime --size 40x40x24 --region 12x12x8 --json";

fn energies(json: &Value) -> Vec<i64> {
    json["stats"]["energy"].as_array().unwrap().iter().map(|e| e.as_i64().unwrap()).collect()
}

#[test]
fn a_weave_goes_on_from_its_maps() {
    let folder = Folder::new("video-start");
    let first = folder.run(&format!("{SPACETIME} --refine 0 -o a.##.png --map m.##.exr")).done().json();
    let started = "video @/fire.png --mode spacetime --region 12x12x8 --json --start m.##.exr";
    folder.run(&format!("{started} --refine 0 -o b.##.png")).done();
    assert!((1..=24).all(|t| samples(&folder, &format!("a.{t:02}.png")) == samples(&folder, &format!("b.{t:02}.png"))));
    let json = folder.run(&format!("{started} --refine 30 -o c.##.png")).done().json();
    let (before, after) = (energies(&first), energies(&json));
    assert_eq!(before.last(), after.first());
    assert!(after.last() < after.first(), "{after:?}");
    assert_eq!((&json["outputs"][0]["frames"], &json["options"]["start"]), (&24.into(), &"m.##.exr".into()));
    let refused = |line: &str, exit: i32, parts: &[&str]| {
        folder.run(&format!("video {line} -o no.##.png")).refused(exit, parts);
    };
    refused("@/fire.png --start m.##.exr --size 40x40x30", 3, &["24 frames of 40x40 px", "30 frames"]);
    refused("@/fire.png --start m.##.exr --loop fixed --mode spacetime", 2, &["--start has frames of its own"]);
    refused("@/fire.png --start m.##.exr --mode spacetime --levels 2", 2, &["what --start gives stands already"]);
    refused("@/fire.png --start m.01.exr --mode spacetime", 2, &["m.01.exr'", "one a frame"]);
    refused("@/fire.png --start m.##.exr --mode transition", 2, &["--mode transition has frames of the clip's 48x60"]);
    refused("a.##.png --start m.##.exr --mode spacetime", 3, &["a.##.png'", "were made from 40 frames"]);
    folder.run("video @/fire.png --start m.##.exr -o o.png --map m.##.exr").refused(4, &["same file"]);
}

/// Whether a seam lies within so many pixels of a place in a frame.
fn is_near(map: &SourceMap<2>, [y, x]: [u32; 2], reach: u32) -> bool {
    let near = |[v, u]: [u32; 2]| v.abs_diff(y) <= reach && u.abs_diff(x) <= reach;
    map.domain().positions().filter(|at| near(*at)).any(|at| (0..2).any(|axis| map.is_seam(at, axis)))
}

#[test]
fn seams_are_blended_within_frames_alone() {
    let folder = Folder::new("video-blended");
    for (name, more) in [("plain", "--map m.##.exr"), ("none", "--feather 0"), ("soft", "--feather 1.5")] {
        folder.run(&format!("{SPACETIME} --refine 0 {more} -o {name}.##.png")).done();
    }
    let mut changed = 0;
    for t in 1..=24 {
        let [plain, none, soft] = ["plain", "none", "soft"].map(|name| samples(&folder, &format!("{name}.{t:02}.png")));
        assert_eq!(plain, none);
        let map = map(&folder, &format!("m.{t:02}.exr")).map;
        for (i, at) in plain.domain().positions().enumerate() {
            if (0..3).any(|c| plain.value(c, i) != soft.value(c, i)) {
                // The kernel ends at two sigma, and its patches at the seam.
                assert!(is_near(&map, at, 4), "frame {t}, {at:?}");
                changed += 1;
            }
        }
    }
    assert!(1000 < changed, "{changed}");
    folder.run(&format!("{SPACETIME} --refine 0 --spline auto -o s.##.png")).done();
    assert_ne!(samples(&folder, "s.05.png"), samples(&folder, "plain.05.png"));
    folder.run("video @/fire.png --fuse -o no.#.png").refused(2, &["--fuse", "flicker"]);
    folder.run("video @/fire.png --feather 17 -o no.#.png").refused(2, &["feather", "0 to 16"]);
    folder.run("video @/fire.png --blend 9 --feather 2 -o no.#.png").refused(2, &["--blend", "no seam"]);
    // A still picture stays to the bit, whatever seams are near.
    crate::graphcut::write(&folder, "mask.png", [60, 48], 1, |_, [y, x]| if 20 < y && x < 24 { 255 } else { 0 });
    let still = "video @/fire.png --fixed mask.png --feather 2 -o still.##.png";
    let frames = folder.run(&format!("{still} --json")).done().json()["stats"]["period"].as_u64().unwrap();
    let first = samples(&folder, "still.01.png");
    for t in 2..=frames {
        let frame = samples(&folder, &format!("still.{t:02}.png"));
        let stays = |(i, at): (usize, [u32; 2])| {
            at[0] <= 20 || 24 <= at[1] || (0..3).all(|c| first.value(c, i) == frame.value(c, i))
        };
        assert!(frame.domain().positions().enumerate().all(stays), "frame {t}");
    }
}

#[test]
fn the_paper_lays_whole_clips() {
    let folder = Folder::new("video-paper");
    let json = folder.run("video @/fire.png --mode temporal --paper --frames 60 -o p.gif --json").done().json();
    let options = &json["options"];
    assert_eq!((&options["reach"], &options["variety"], &options["tries"]), (&"all".into(), &0.0.into(), &1.into()));
    folder.run("video @/fire.png --paper --reach 9 -o no.gif").refused(2, &["--reach", "--paper"]);
    let jump = folder.run("video @/fire.png --mode transition --paper -o j.gif --json").done().json();
    assert_eq!(jump["options"]["window"], 60);
}
