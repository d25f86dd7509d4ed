//! What `merge` of clips is given beside colours: what they have to have in common, streams, and what pictures tell.

use std::fs;
use std::io::Write as _;
use std::process::Stdio;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Association, Metadata, WriteOptions};

use crate::graphcut::{samples, write};
use crate::merge_clips::clips;
use crate::program::{Folder, Said};

/// White in these columns.
fn white(folder: &Folder, name: &str, columns: std::ops::Range<u32>) {
    write(folder, name, [24, 30], 1, |_, [_, x]| if columns.contains(&x) { 255 } else { 0 });
}

/// Five frames that differ in what they say of their colours.
fn tagged(folder: &Folder, name: &str, channels: usize, (association, gamma): (Association, Option<u32>)) {
    let grid = Grid::try_filled(Domain::open([24, 30]), channels, 90_u8).unwrap();
    let plane = Plane { alpha: channels == 4, association, ..Plane::new(Role::Color, Samples::U8(grid)) };
    let metadata = Metadata { gamma, ..Metadata::default() };
    for t in 1..=5 {
        let path = folder.path(name.replace('#', &t.to_string()));
        selvedge_io::write(path, &plane, &metadata, &WriteOptions::default()).unwrap();
    }
}

#[test]
fn what_is_kept_is_in_the_command_that_frames_carry() {
    let folder = Folder::new("merge-clips-again");
    clips(&folder, 2);
    fs::create_dir(folder.path("masks")).unwrap();
    white(&folder, "masks/left.png", 0..8);
    (1..=5).for_each(|t| white(&folder, &format!("masks/right.{t}.png"), 20 + t..30));
    let line = "merge a.###.png b.###.png --keep 1 masks/left.png --keep 2 masks/right.#.png -o out.###.png --json";
    let said = folder.run(line).done().json();
    assert_eq!(said["options"]["keep"], serde_json::json!([["1", "left.png"], ["2", "right.#.png"]]));
    folder.run("again out.003.png -o again.###.png --look-in masks").done();
    let bytes = |name: &str, t: u32| fs::read(folder.path(format!("{name}.{t:03}.png"))).unwrap();
    assert!((1..=5).all(|t| bytes("out", t) == bytes("again", t)));
    // So does the command that is told, where all lies in one folder.
    (1..=5).for_each(|t| white(&folder, &format!("right.{t}.png"), 20 + t..30));
    white(&folder, "left.png", 0..8);
    let info = folder.run("info out.003.png --json").done().json();
    let told = info["stats"]["made_by_selvedge"]["command"].as_str().unwrap().to_owned();
    let told = format!("{} -o told.###.png", told.strip_prefix("selvedge ").unwrap().replace('\'', ""));
    folder.run(&told).done();
    assert!((1..=5).all(|t| bytes("out", t) == bytes("told", t)));
    white(&folder, "right.2.png", 20..30);
    folder.run(&told).refused(3, &["right.2.png", "is not the file that it was"]);
}

#[test]
fn rates_are_compared_with_the_first_clip_that_has_one() {
    let folder = Folder::new("merge-clips-rates");
    (1..=2).for_each(|t| write(&folder, &format!("a.{t}.png"), [2, 2], 1, |_, _| 9));
    for (name, rate) in [("b", 24), ("c", 25)] {
        let file = format!("YUV4MPEG2 W2 H2 F{rate}:1 Cmono XCOLORRANGE=FULL\nFRAME\nabcdFRAME\nabcd");
        fs::write(folder.path(format!("{name}.y4m")), file).unwrap();
    }
    let parts = ["c.y4m'", "25 frames a second", "'b.y4m' has 24"];
    folder.run("merge a.#.png b.y4m c.y4m -o no.#.png").refused(3, &parts);
    folder.run("merge a.#.png a.#.png c.y4m -o out.#.png").done();
    // The one that decides is named, which is a picture here.
    write(&folder, "plate.png", [2, 2], 4, |_, _| 255);
    folder
        .run("merge plate.png a.#.png -o no.#.png")
        .refused(3, &["a.#.png'", "1 channel", "'plate.png' has 4 channels"]);
}

#[test]
fn colours_that_mean_something_else_are_told() {
    let folder = Folder::new("merge-clips-tags");
    let straight = (Association::Straight, None);
    tagged(&folder, "plain.#.png", 3, straight);
    tagged(&folder, "gamma.#.png", 3, (Association::Straight, Some(100_000)));
    let said = folder.run("merge plain.#.png gamma.#.png -o out.#.png").done();
    assert_eq!(said.stderr.matches("colour tags").count(), 1, "{said:?}");
    assert!(!folder.run("merge plain.#.png plain.#.png -o out.#.png").done().stderr.contains("colour tags"));
    // Multiplied by alpha and not is refused, by name.
    tagged(&folder, "straight.#.png", 4, straight);
    tagged(&folder, "multiplied.#.tif", 4, (Association::Premultiplied, None));
    let parts = ["multiplied.#.tif'", "premultiplied", "'straight.#.png' has straight"];
    folder.run("merge straight.#.png multiplied.#.tif -o no.#.png").refused(3, &parts);
}

#[test]
fn numbers_that_are_none_are_replaced_in_masks_as_well() {
    let folder = Folder::new("merge-clips-nonfinite");
    clips(&folder, 2);
    let light: Vec<f32> =
        (0..24 * 30).map(|i| if i % 30 == 29 { f32::NAN } else { f32::from(u8::from(i % 30 < 8)) }).collect();
    let mask = Plane::new(Role::Scalar, Samples::F32(Grid::from_vec(Domain::open([24, 30]), 1, light).unwrap()));
    selvedge_io::write(folder.path("m.exr"), &mask, &Metadata::default(), &WriteOptions::default()).unwrap();
    let line = "merge a.###.png b.###.png --label-map l.#.png -o out.###.png";
    for (option, shown) in [("--keep 1 m.exr", 1.0), ("--mask none --mask m.exr", 2.0)] {
        folder.run(&format!("{line} {option}")).refused(3, &["m.exr'", "--nonfinite"]);
        folder.run(&format!("{line} {option} --nonfinite zero")).done();
        assert!(shown == 2.0 || samples(&folder, "l.2.png").value(0, 3) == shown);
        assert!(shown == 1.0 || samples(&folder, "l.2.png").value(0, 20) == 1.0);
    }
}

/// Runs it with a file as standard input.
fn fed(folder: &Folder, line: &str, file: &str) -> Said {
    let mut command = folder.command();
    command.args(line.split(' ')).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // What refuses its options reads nothing.
    let _ = child.stdin.take().unwrap().write_all(&fs::read(folder.path(file)).unwrap());
    Said::from(child.wait_with_output().unwrap())
}

#[test]
fn streams_are_read_once_and_may_be_a_picture() {
    let folder = Folder::new("merge-clips-streams");
    clips(&folder, 2);
    white(&folder, "m.png", 0..8);
    for twice in ["--mask - --mask -", "--keep 1 - --keep 2 -", "--mask - --mask none --fuse --fuse-keep -"] {
        let said = fed(&folder, &format!("merge a.###.png b.###.png {twice} -o no.###.png"), "m.png");
        said.refused(2, &["standard input is named twice"]);
    }
    fed(&folder, "merge a.###.png b.###.png --keep 1 - -o out.###.png", "m.png").done();
    // A picture is held over all frames, also first, where no clip says yet how many there are.
    for line in ["merge - b.###.png", "merge b.###.png -"] {
        fed(&folder, &format!("{line} -o piped.#.png"), "a.003.png").done();
        folder.run(&format!("{} -o file.#.png", line.replace("- ", "a.003.png ").replace(" -", " a.003.png"))).done();
        assert!(
            (1..=5).all(|t| samples(&folder, &format!("piped.{t}.png")) == samples(&folder, &format!("file.{t}.png")))
        );
    }
    folder.run("merge a.###.png b.###.png --keep 1 m.png --map m.#.exr -o out.###.png").done();
    fed(&folder, "apply m.#.exr - b.###.png -o piped.#.png", "a.003.png").done();
    folder.run("apply m.#.exr a.003.png b.###.png -o file.#.png").done();
    assert!((1..=5).all(|t| samples(&folder, &format!("piped.{t}.png")) == samples(&folder, &format!("file.{t}.png"))));
}

#[test]
fn a_picture_is_held_over_all_frames_that_maps_were_made_from() {
    let folder = Folder::new("merge-clips-apply-one");
    for t in 1..=12 {
        write(&folder, &format!("v.{t:02}.png"), [16, 16], 1, |_, [y, x]| (100 + 9 * (t % 6) + y + x) as u8);
    }
    folder.run("video v.##.png --period 6 --map m.##.exr -o out.##.png").done();
    write(&folder, "one.png", [16, 16], 3, |c, [y, x]| (c as u32 * 50 + 7 * y + x) as u8);
    folder.run("apply m.##.exr one.png -o held.##.png").done();
    assert!((1..=6).all(|t| samples(&folder, &format!("held.{t:02}.png")) == samples(&folder, "one.png")));
}

#[test]
fn passes_beside_blended_clips_are_said_to_be_copied() {
    let folder = Folder::new("merge-clips-copied");
    clips(&folder, 2);
    (1..=5).for_each(|t| white(&folder, &format!("n.{t}.png"), t..9));
    let line = "merge a.###.png b.###.png --with n.#.png n.#.png -o {stem}-out.###.png";
    let said = folder.run(&format!("{line} --feather 1")).done();
    assert_eq!(said.stderr.matches("not blended").count(), 1, "{said:?}");
    assert!(!folder.run(line).done().stderr.contains("not blended"));
    assert!(!folder.run("merge a.###.png b.###.png --feather 1 -o out.###.png").done().stderr.contains("not blended"));
}

#[test]
fn the_preview_shows_what_is_written() {
    let folder = Folder::new("merge-clips-preview");
    for (name, add) in [("a", 40), ("b", 100)] {
        for t in 1..=5 {
            write(&folder, &format!("{name}.{t}.png"), [24, 30], 3, |_, [y, x]| (add + 2 * x + y) as u8);
        }
    }
    for options in ["--feather 2", "--spline 2", "--fuse"] {
        folder.run(&format!("merge a.#.png b.#.png --at 12,5 {options} -o out.#.png --preview see.png")).done();
        let (seen, out) = (samples(&folder, "see.png"), samples(&folder, "out.1.png"));
        let wide = seen.domain().shape[1];
        for (i, [y, x]) in out.domain().positions().enumerate() {
            let shown = |c: usize| if out.value(3, i) == 0.0 { 255.0 } else { out.value(c, i) };
            let is = |c: usize| seen.value(c, (y * wide + x) as usize);
            assert!((0..3).all(|c| is(c) == shown(c)), "{options} at {x},{y}: {} for {}", is(0), shown(0));
        }
    }
}

#[test]
fn what_is_in_no_clip_is_no_seam_that_moves() {
    let folder = Folder::new("merge-clips-hole");
    clips(&folder, 0);
    // A hole goes down where only one clip lies; the seam beside it stands still.
    for t in 0..5 {
        let shows = |_: usize, [y, x]: [u32; 2]| if x < 4 && (3 * t..3 * t + 6).contains(&y) { 0 } else { 255 };
        write(&folder, &format!("hole.{t}.png"), [24, 30], 1, shows);
    }
    let line = "merge a.###.png b.###.png --at 20,0 --mask hole.#.png --mask none --json";
    let said = folder.run(&format!("{line} -o out.###.png")).done().json();
    assert!(said["stats"]["holes"].as_u64().unwrap() == 5 * 24);
    assert_eq!(said["stats"]["seam_moves"], 0.0);
}
