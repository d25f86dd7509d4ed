//! What `merge` of clips is given beside colours: what they have to have in common, streams, and what pictures tell.

use std::fs;

use crate::graphcut::write;
use crate::merge_clips::clips;
use crate::program::Folder;

/// White in these columns.
fn white(folder: &Folder, name: &str, columns: std::ops::Range<u32>) {
    write(folder, name, [24, 30], 1, |_, [_, x]| if columns.contains(&x) { 255 } else { 0 });
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
