//! `merge` of clips: seams are surfaces in space and time, strokes one picture or one a frame.

use crate::graphcut::{samples, write};
use crate::program::Folder;

/// A texture that is nowhere like another of another seed.
fn texture(seed: u32, [y, x]: [u32; 2], c: u32) -> u8 {
    let mixed = (x * 7 + y * 13 + c * 5 + seed * 31).wrapping_mul(0x9e37_79b1) ^ (x / 3 * 11 + y / 4 * 17 + seed);
    (mixed.wrapping_mul(0x85eb_ca6b) >> 24) as u8
}

/// Two clips of five frames, the content of which goes down by so many pixels a frame.
pub(crate) fn clips(folder: &Folder, by: u32) {
    for (name, seed) in [("a", 1), ("b", 2)] {
        for t in 0..5 {
            let file = format!("{name}.{:03}.png", t + 1);
            write(folder, &file, [24, 30], 3, |c, [y, x]| texture(seed, [y + 40 - by * t, x], c as u32));
        }
    }
}

/// Yellow at the left, blue at the right, moved by so many pixels.
pub(crate) fn paint(folder: &Folder, name: &str, by: u32) {
    let at = |c: usize, [_, x]: [u32; 2]| match (x, c) {
        (x, 0 | 1) if x < 6 + by => 255,
        (x, 2) if 14 + by <= x => 255,
        _ => 0,
    };
    write(folder, name, [24, 30], 3, at);
}

pub(crate) const COLORS: &str = "--color #ffff00=1 --color #0000ff=2";

#[test]
fn clips_that_stand_still_merge_as_their_pictures_do() {
    let folder = Folder::new("merge-still-clips");
    clips(&folder, 0);
    paint(&folder, "paint.png", 0);
    folder.run(&format!("merge a.001.png b.001.png --strokes paint.png {COLORS} -o one.png")).done();
    let line = format!("merge a.###.png b.###.png --strokes paint.png {COLORS} -o out.###.png --json");
    let said = folder.run(&line).done().json();
    assert_eq!(said["stats"]["seam_moves"], 0.0);
    assert_eq!(said["outputs"][0]["frames"], 5);
    let one = samples(&folder, "one.png");
    assert!((1..=5).all(|t| samples(&folder, &format!("out.{t:03}.png")) == one));
}

#[test]
fn every_sample_is_that_of_the_clip_that_shows_there() {
    let folder = Folder::new("merge-clips");
    clips(&folder, 2);
    (0..5).for_each(|t| paint(&folder, &format!("paint.{}.png", t + 1), 4 * t));
    let white = |_: usize, [y, x]: [u32; 2]| if (10..13).contains(&y) && 27 <= x { 255 } else { 0 };
    write(&folder, "mask.png", [24, 30], 1, white);
    let line = format!("merge a.###.png b.###.png --strokes paint.#.png {COLORS} --keep 2 mask.png");
    let said = folder.run(&format!("{line} --label-map l.#.png -o out.###.png --json")).done().json();
    assert!(0.0 < said["stats"]["seam_moves"].as_f64().unwrap());
    for t in 0..5 {
        let [out, a, b] = ["out", "a", "b"].map(|name| samples(&folder, &format!("{name}.{:03}.png", t + 1)));
        let labels = samples(&folder, &format!("l.{}.png", t + 1));
        for (i, at) in out.domain().positions().enumerate() {
            let from = if labels.value(0, i) == 1.0 { &a } else { &b };
            assert!((0..3).all(|c| out.value(c, i) == from.value(c, i)), "frame {t}, {at:?}");
            let wanted = match at[1] {
                x if x < 6 + 4 * t => 1.0,
                x if 14 + 4 * t <= x || 0 < white(0, at) => 2.0,
                _ => continue,
            };
            assert_eq!(labels.value(0, i), wanted, "frame {t}, {at:?}");
        }
    }
    // Clips beside each other reach farther than one of them.
    let said = folder.run("merge a.###.png b.###.png --at 20,0 -o wide.png --json").done().json();
    assert_eq!([&said["outputs"][0]["width"], &said["outputs"][0]["height"]], [50, 24]);
    let said = folder.run(&format!("{line} -o dry.###.png --dry-run")).done();
    assert!(said.stderr.contains("would be 5 frames of 30x24 px from 2 clips"), "{said:?}");
    folder.run("merge a.001.png b.001.png --at 20,0 -o wide.001.png").done();
    // Two rows of frames, and slices along both axes, each with what is between.
    folder.run(&format!("{line} -o out.###.png --preview see.png --report page")).done();
    let seen = samples(&folder, "see.png");
    assert_eq!(seen.domain().shape, [24 + 6 + 24 + 6 + 5 + 6 + 24, 3 * 30 + 2 * 6]);
    let red = |[y, x]: [u32; 2]| (0..3).map(|c| seen.value(c, (y * 102 + x) as usize)).eq([255.0, 40.0, 40.0]);
    assert!((30..54).all(|y| (0..30).any(|x| red([y, x]))) && (0..24).all(|y| (0..102).all(|x| !red([y, x]))));
    let page = std::fs::read_to_string(folder.path("page/index.html")).unwrap();
    assert!(page.contains("slices through time") && page.contains("seam moves"), "{page}");
}

#[test]
fn other_passes_of_both_clips_are_cut_by_the_same_seam() {
    let folder = Folder::new("merge-clips-maps");
    clips(&folder, 2);
    paint(&folder, "paint.png", 0);
    // Of other depth and channels than the clips.
    for (name, seed) in [("an", 8), ("bn", 9)] {
        for t in 0..5 {
            write(&folder, &format!("{name}.{t}.png"), [24, 30], 1, |c, at| texture(seed + t, at, c as u32));
        }
    }
    let line = "merge a.###.png b.###.png --at 6,0 --keep 1 left.png --with an.#.png bn.#.png";
    write(&folder, "left.png", [24, 36], 1, |_, [_, x]| if x < 10 { 255 } else { 0 });
    let line = format!("{line} --map m.#.exr --label-map l.#.png -o {{stem}}-out.###.png --json");
    let said = folder.run(&line).done().json();
    assert_eq!(said["outputs"].as_array().unwrap().len(), 3 + 5, "two clips, numbers, and a map a frame");
    folder.run("apply m.#.exr a.###.png b.###.png an.#.png bn.#.png -o {stem}-again.###.png").done();
    for t in 1..=5 {
        for name in ["a", "an"] {
            let [made, again] = ["out", "again"].map(|of| samples(&folder, &format!("{name}-{of}.{t:03}.png")));
            assert!(made == again, "frame {t} of {name}");
        }
        let [out, a, b] = [format!("an-out.{t:03}.png"), format!("an.{}.png", t - 1), format!("bn.{}.png", t - 1)]
            .map(|name| samples(&folder, &name));
        let labels = samples(&folder, &format!("l.{t}.png"));
        for (i, [y, x]) in out.domain().positions().enumerate() {
            let shown = if labels.value(0, i) == 1.0 {
                a.value(0, (y * 30 + x) as usize)
            } else {
                b.value(0, (y * 30 + x - 6) as usize)
            };
            assert_eq!(out.value(0, i), shown, "frame {t} at {x},{y}");
        }
    }
    let refused = |line: &str, exit: i32, parts: &[&str]| folder.run(line).refused(exit, parts);
    refused("apply m.#.exr a.###.png -o no.#.png", 3, &["a.###.png'", "5 frames of 30x24 px", "10 frames of 30x24 px"]);
    refused("apply m.#.exr a.###.png an.#.png -o no.#.png", 3, &["an.#.png'", "1 channel of u8", "3 channels of u8"]);
    let line = "apply m.#.exr a.###.png l.#.png -o no.#.png";
    refused(line, 3, &["l.#.png'", "5 frames of 36x24 px", "after the clips before it", "of 30x24 px"]);
    refused("video a.###.png --start m.#.exr --mode spacetime -o no.#.png", 3, &["a.###.png'", "made from 10 frames"]);
    let line = "merge a.###.png b.###.png --with an.#.png l.#.png -o {stem}-no.#.png";
    refused(line, 3, &["l.#.png'", "5 frames of 36x24 px", "5 of 30x24 px"]);
    refused("merge a.###.png b.###.png --with an.#.png -o {stem}-no.#.png", 2, &["1 plane of --with", "2 exemplars"]);
    refused("merge a.###.png b.###.png --with an.#.png bn.#.png -o no.#.png", 2, &["no.#.png'", "2 outputs"]);
    refused("merge a.###.png b.###.png --map m.exr -o no.#.png", 2, &["m.exr'", "maps.####.exr"]);
}

#[test]
fn what_is_masked_never_shows_and_what_is_in_no_clip_is_transparent() {
    let folder = Folder::new("merge-clips-masked");
    clips(&folder, 2);
    // What is in the way in the first clip goes to the right; of the second nothing shows at the bottom.
    let thing = |t: u32, x: u32| (4 + 3 * t..9 + 3 * t).contains(&x);
    for t in 0..5 {
        let mask = |_: usize, [_, x]: [u32; 2]| if thing(t, x) { 0 } else { 255 };
        write(&folder, &format!("mask.{t}.png"), [24, 30], 1, mask);
    }
    write(&folder, "top.png", [24, 30], 1, |_, [y, _]| if y < 20 { 255 } else { 0 });
    let line = "merge a.###.png b.###.png --mask mask.#.png --mask top.png --label-map l.#.png --json";
    let said = folder.run(&format!("{line} -o out.###.png")).done();
    assert!(said.stderr.contains("100 pixels in none of them and transparent"), "{said:?}");
    for t in 0..5 {
        let [out, a, b] = ["out", "a", "b"].map(|name| samples(&folder, &format!("{name}.{:03}.png", t + 1)));
        let labels = samples(&folder, &format!("l.{}.png", t + 1));
        for (i, [y, x]) in out.domain().positions().enumerate() {
            let from = match labels.value(0, i) {
                1.0 => &a,
                2.0 => &b,
                _ => {
                    assert!(thing(t, x) && 20 <= y && out.value(3, i) == 0.0, "frame {t}, {x},{y}");
                    continue;
                }
            };
            assert!(
                !(thing(t, x) && labels.value(0, i) == 1.0 || 20 <= y && labels.value(0, i) == 2.0),
                "{t}, {x},{y}"
            );
            assert!(out.value(3, i) == 255.0 && (0..3).all(|c| out.value(c, i) == from.value(c, i)), "{t}, {x},{y}");
        }
    }
}

#[test]
fn clips_that_agree_are_found_and_evened_over_all_frames() {
    let folder = Folder::new("merge-clips-at");
    // A scene that goes down by two pixels a frame, behind a window that both clips look through at other places; what
    // moves across the second one is in its first and last frame alone.
    let scene = |t: u32, [y, x]: [u32; 2], c: u32| 50.0 + f64::from(texture(5, [y + 40 - 2 * t, x], c)) / 3.0;
    for t in 0..5 {
        write(&folder, &format!("a.{}.png", t + 1), [26, 40], 3, |c, at| scene(t, at, c as u32).round() as u8);
        let thing = |[y, x]: [u32; 2]| t % 4 == 0 && (9..15).contains(&y) && x < 6;
        let dark = |c: usize, [y, x]: [u32; 2]| match thing([y, x]) {
            true => 200,
            false => (0.8 * scene(t, [y + 3, x + 22], c as u32) + 10.0).round() as u8,
        };
        write(&folder, &format!("b.{}.png", t + 1), [26, 40], 3, dark);
        write(&folder, &format!("m.{}.png", t + 1), [26, 40], 1, |_, at| if thing(at) { 0 } else { 255 });
    }
    let line = "merge a.#.png b.#.png --at auto --gain --mask none --mask m.#.png --label-map l.#.png --json";
    let said = folder.run(&format!("{line} -o out.#.png")).done().json();
    assert_eq!(said["options"]["at"], serde_json::json!(["22,3"]));
    assert_eq!([&said["outputs"][0]["width"], &said["outputs"][0]["height"]], [62, 29]);
    // One gain for all frames, although each has another mean.
    let fitted = &said["stats"]["tones"][1];
    for c in 0..3 {
        let [gain, offset] = ["gain", "offset"].map(|part| fitted[part][c].as_f64().unwrap());
        assert!((gain * 0.8 - 1.0).abs() < 0.02 && (offset * 255.0 + 12.5).abs() < 2.0, "{fitted}");
    }
    for t in 0..5 {
        let [out, a, b, labels] = ["out", "a", "b", "l"].map(|name| samples(&folder, &format!("{name}.{}.png", t + 1)));
        for (i, [y, x]) in out.domain().positions().enumerate() {
            for c in 0..3 {
                let shown = match labels.value(0, i) {
                    1.0 => a.value(c, (y * 40 + x) as usize),
                    2.0 => {
                        let [gain, offset] = ["gain", "offset"].map(|part| fitted[part][c].as_f64().unwrap());
                        gain * b.value(c, ((y - 3) * 40 + x - 22) as usize) + offset * 255.0
                    }
                    _ => continue,
                };
                assert!(
                    (out.value(c, i) - shown).abs() <= 0.501,
                    "frame {t} at {x},{y}: {} for {shown}",
                    out.value(c, i)
                );
            }
        }
    }
    // With another place typed for a third clip.
    let said = folder.run("merge a.#.png b.#.png a.#.png --at auto --at 0,0 -o three.#.png --json").done().json();
    assert_eq!(said["options"]["at"], serde_json::json!(["22,3", "0,0"]));
}

#[test]
fn a_picture_beside_clips_is_held_over_all_frames() {
    let folder = Folder::new("merge-clips-held");
    clips(&folder, 2);
    for (name, seed) in [("plate", 3), ("plate-n", 4), ("b-n", 5)] {
        write(&folder, &format!("{name}.png"), [24, 30], 3, |c, at| texture(seed, at, c as u32));
    }
    paint(&folder, "paint.png", 0);
    let line = format!("merge plate.png b.###.png --strokes paint.png {COLORS} --label-map l.#.png --map m.#.exr");
    let said = folder.run(&format!("{line} -o out.#.png --json")).done().json();
    assert_eq!((&said["outputs"][0]["frames"], &said["inputs"][0]["container"]), (&5.into(), &"png picture".into()));
    let plate = samples(&folder, "plate.png");
    for t in 1..=5 {
        let [out, b, labels] =
            [format!("out.{t}.png"), format!("b.{t:03}.png"), format!("l.{t}.png")].map(|name| samples(&folder, &name));
        for i in 0..24 * 30 {
            let from = if labels.value(0, i) == 1.0 { &plate } else { &b };
            assert!((0..3).all(|c| out.value(c, i) == from.value(c, i)), "frame {t}, {i}");
        }
    }
    // So are its passes; all that is held may be, and a clip beside it decides how long.
    folder.run("apply m.#.exr plate-n.png b-n.png -o n.#.png").done();
    let [n, labels, plate] = ["n.3.png", "l.3.png", "plate-n.png"].map(|name| samples(&folder, name));
    assert!((0..24 * 30).all(|i| labels.value(0, i) != 1.0 || n.value(0, i) == plate.value(0, i)));
    folder.run("merge b.###.png plate.png --with plate-n.png b-n.png -o {stem}-w.#.png").done();
}

#[test]
fn what_is_no_pair_of_clips_is_refused() {
    let folder = Folder::new("merge-clips-refused");
    clips(&folder, 1);
    paint(&folder, "paint.png", 0);
    (0..4).for_each(|t| paint(&folder, &format!("paint.{}.png", t + 1), t));
    write(&folder, "small.png", [9, 9], 1, |_, _| 255);
    for (name, shape, channels) in [("short", [24, 30], 3), ("grey", [24, 30], 1)] {
        let frames = if name == "short" { 4 } else { 5 };
        (1..=frames).for_each(|t| write(&folder, &format!("{name}.{t}.png"), shape, channels, |_, _| 9));
    }
    let refused = |line: &str, exit: i32, parts: &[&str]| {
        folder.run(&format!("merge a.###.png {line} -o no.###.png")).refused(exit, parts);
    };
    refused("", 2, &["1 picture to merge"]);
    refused("short.#.png", 3, &["short.#.png'", "4 frames", "5 frames"]);
    refused("grey.#.png", 3, &["1 channel of u8", "3 channels of u8"]);
    refused("small.png", 3, &["small.png'", "1 channel of u8", "3 channels of u8"]);
    refused("none.png", 4, &["none.png'"]);
    refused("b.###.png --at 90,0", 3, &["b.###.png'", "lies apart"]);
    refused("b.###.png --mask none", 2, &["1 mask for 2 exemplars"]);
    refused("b.###.png --mask none --mask small.png", 3, &["small.png'", "9x9 px", "30x24 px"]);
    refused("b.###.png --mask none --mask paint.#.png", 3, &["paint.#.png'", "4 frames", "have 5"]);
    let bare = "--at 3,4 -o no.y4m";
    folder.run(&format!("merge a.###.png b.###.png {bare}")).refused(3, &["no.y4m'", "120 pixels", "fill their box"]);
    refused("b.###.png --tile x", 2, &["--tile is for pictures"]);
    refused(&format!("b.###.png --strokes paint.#.png {COLORS}"), 3, &["paint.#.png'", "4 frames", "have 5"]);
    refused("b.###.png --strokes paint.png --color #ffff00=1", 3, &["paint.png'", "#0000ff"]);
    refused("b.###.png --keep 1 small.png", 3, &["small.png'", "9x9 px"]);
    refused("b.###.png --max-memory 10MiB", 6, &["memory"]);
    folder.run("merge a.###.png b.###.png -o b.###.png").refused(4, &["same file as the input"]);
    folder.run("merge a.###.png b.###.png -o no.jpg").refused(2, &["no.jpg'"]);
    assert!(folder.names().iter().all(|name| !name.starts_with("no")), "{:?}", folder.names());
}
