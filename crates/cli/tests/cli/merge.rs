//! `merge`: places, strokes, preferences, and what is refused.

use crate::graphcut::{map, samples, write};
use crate::program::{Folder, fixtures};

/// Two overlapping parts of the cobbles: 60 columns each, the second 36 further right and 5 further down.
fn parts(folder: &Folder) {
    let cobbles = samples(folder, &(fixtures() + "/cobbles.png"));
    for (name, [top, left]) in [("a.png", [10, 20]), ("b.png", [15, 56])] {
        write(folder, name, [50, 60], 3, |c, [y, x]| cobbles.value(c, ((top + y) * 192 + left + x) as usize) as u8);
    }
}

#[test]
fn pictures_that_agree_are_found_and_joined_without_a_seam() {
    let folder = Folder::new("merge-at");
    parts(&folder);
    write(&folder, "corner.png", [55, 96], 1, |_, [y, x]| if y < 50 && x < 60 || y >= 5 && x >= 36 { 255 } else { 0 });
    let said = folder.run("merge a.png b.png --at auto -o no.png");
    said.refused(3, &["no picture may show at 60,0", "--at"]);
    // A third picture covers the corners.
    let line = "merge a.png b.png @/cobbles.png --at auto --at -20,-10 -o out.png --map m.exr --json";
    let said = folder.run(line).done();
    assert_eq!(said.json()["stats"]["energy"].as_array().unwrap().last().unwrap(), 0);
    assert_eq!(said.json()["options"]["at"], serde_json::json!(["36,5", "-20,-10"]));
    let (out, cobbles) = (samples(&folder, "out.png"), samples(&folder, &(fixtures() + "/cobbles.png")));
    assert_eq!(out, cobbles);
    assert_eq!(map(&folder, "m.exr").map.holes(), 0);
}

#[test]
fn strokes_and_masks_say_what_shows() {
    let folder = Folder::new("merge-strokes");
    for (name, add) in [("a.png", 0), ("b.png", 60), ("c.png", 120)] {
        write(&folder, name, [40, 50], 3, |c, [y, x]| (add + (y * 7 + x * 3 + c as u32 * 11) % 100) as u8);
    }
    // Yellow at the left, blue at the right, all else free.
    let paint = |c: usize, [_, x]: [u32; 2]| match (x, c) {
        (0..10, 0 | 1) | (40.., 2) => 255,
        _ => 0,
    };
    write(&folder, "paint.png", [40, 50], 3, paint);
    write(&folder, "mask.png", [40, 50], 1, |_, [y, x]| if y < 5 && (20..30).contains(&x) { 255 } else { 0 });
    let line = "merge a.png b.png c.png --strokes paint.png --color #ffff00=2 --color #0000ff=1";
    folder.run(&format!("{line} --keep 3 mask.png -o out.png --map m.exr")).done();
    let made = map(&folder, "m.exr").map;
    for [y, x] in made.domain().positions() {
        let (source, from) = made.locate([y, x]).unwrap();
        assert_eq!(from, [y, x]);
        let wanted = match x {
            0..10 => Some(1),
            40.. => Some(0),
            _ => (y < 5 && (20..30).contains(&x)).then_some(2),
        };
        assert!(wanted.is_none_or(|wanted| wanted == source), "{x},{y}");
    }
    let refused = |line: &str, exit: i32, parts: &[&str]| {
        folder.run(&format!("{line} -o no.png")).refused(exit, parts);
    };
    refused(
        "merge a.png b.png --strokes paint.png --color #ffff00=2",
        3,
        &["paint.png'", "#0000ff (400 px)", "--color"],
    );
    refused("merge a.png b.png --strokes paint.png", 2, &["--color"]);
    refused("merge a.png b.png --strokes paint.png --color #ffff00=3", 2, &["#ffff00=3", "2 pictures"]);
    refused("merge a.png b.png --keep 1 mask.png --keep 2 mask.png", 3, &["mask.png'", "20,0", "another"]);
    refused(
        "merge a.png b.png --strokes paint.png --color #ffff00=1 --color #ffff00=2",
        2,
        &["#ffff00", "two pictures"],
    );
    refused("merge a.png b.png --strokes paint.png --color #000000=1", 2, &["black"]);
    refused("merge a.png b.png --keep 0 mask.png", 2, &["--keep 0", "1 to 2"]);
    refused("merge a.png b.png --at 100,0", 3, &["no picture may show at 50,0"]);
    refused("merge a.png b.png --at 1,0 --at 2,0", 2, &["2 places", "1 further picture"]);
    refused("merge a.png", 2, &["1 picture to merge"]);
    refused("merge a.png b.png --strokes @/stars.png --color #ffff00=1", 3, &["stars.png'", "128x128 px", "50x40 px"]);
}

#[test]
fn who_passes_by_vanishes() {
    let folder = Folder::new("merge-median");
    let still = |c: usize, [y, x]: [u32; 2]| (60 + (y * 5 + x * 9 + c as u32) % 40) as u8;
    // A walker in each picture, at another place.
    for (name, at) in [("1.png", 8), ("2.png", 28), ("3.png", 48)] {
        let walker = move |[y, x]: [u32; 2]| (10..30).contains(&y) && x.abs_diff(at) < 6;
        write(&folder, name, [40, 60], 3, |c, p| if walker(p) { 230 } else { still(c, p) });
    }
    write(&folder, "square.png", [40, 60], 3, still);
    folder.run("merge 1.png 2.png 3.png --prefer median -o out.png").done();
    assert_eq!(samples(&folder, "out.png"), samples(&folder, "square.png"));
    folder.run("merge 1.png 2.png --prefer brightest -o light.png").done();
    let light = samples(&folder, "light.png");
    assert!([8_usize, 28].iter().all(|x| light.value(0, 20 * 60 + x) == 230.0));
}
