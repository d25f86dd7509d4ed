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
    // The corners of their box are nobody's.
    let said = folder.run("merge a.png b.png --at auto -o corners.png").done();
    assert!(said.stderr.contains("360 pixels in none of them and transparent"), "{said:?}");
    let (out, a, b) = (samples(&folder, "corners.png"), samples(&folder, "a.png"), samples(&folder, "b.png"));
    for (y, x) in (0..55_usize).flat_map(|y| (0..96_usize).map(move |x| (y, x))) {
        let of_a = (y < 50 && x < 60).then(|| (&a, y * 60 + x));
        let of_b = || (y >= 5 && x >= 36).then(|| (&b, (y - 5) * 60 + x - 36));
        let (alpha, i) = (out.value(3, y * 96 + x), y * 96 + x);
        match of_a.or_else(of_b) {
            Some((from, j)) => {
                assert!(alpha == 255.0 && (0..3).all(|c| out.value(c, i) == from.value(c, j)), "{x},{y}")
            }
            None => assert_eq!(alpha, 0.0, "{x},{y}"),
        }
    }
    // Bands of a spline reach far; means of black would be tens of levels off.
    for (blend, most) in [("--fuse", 0.0), ("--feather 3", 0.0), ("--spline auto", 2.0)] {
        folder.run(&format!("merge a.png b.png --at auto {blend} -o blended.png")).done();
        let blended = samples(&folder, "blended.png");
        let shown: Vec<usize> = (0..55 * 96).filter(|&i| out.value(3, i) == 255.0).collect();
        assert!((0..55 * 96).all(|i| blended.value(3, i) == out.value(3, i)), "{blend}");
        let off = |i: &usize| (0..3).map(|c| (blended.value(c, *i) - out.value(c, *i)).abs()).sum::<f64>() / 3.0;
        let mean = shown.iter().map(off).sum::<f64>() / shown.len() as f64;
        assert!(mean <= most, "{blend}: {mean}: holes darken nothing that agrees");
    }
    folder.run("merge a.png b.png --at auto -o no.jpg").refused(3, &["no.jpg'", "360 pixels", "transparency", "PNG"]);
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
    let white = |_: usize, [y, x]: [u32; 2]| if y < 5 && (20..30).contains(&x) { 255 } else { 0 };
    write(&folder, "mask.png", [40, 50], 1, white);
    write(&folder, "mask-30.png", [70, 50], 1, white);
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
    refused("merge a.png b.png --at 900000,900000", 3, &["lay the pictures closer together"]);
    refused("merge a.png b.png --at 2000000,0", 2, &["2000000,0", "less than 1048576"]);
    refused("merge a.png b.png --strokes paint.png --color #ffff00=3", 2, &["#ffff00=3", "2 pictures"]);
    refused("merge a.png b.png --keep 1 mask.png --keep 2 mask.png", 3, &["mask.png'", "20,0", "another"]);
    refused(
        "merge a.png b.png --strokes paint.png --color #ffff00=1 --color #ffff00=2",
        2,
        &["#ffff00", "two pictures"],
    );
    refused("merge a.png b.png --strokes paint.png --color #000000=1", 2, &["black"]);
    refused("merge a.png b.png --keep 0 mask.png", 2, &["--keep 0", "1 to 2"]);
    refused("merge a.png b.png --at 100,0", 3, &["b.png'", "lies apart", "--at"]);
    refused("merge a.png b.png c.png --at 40,0 --at 91,0", 3, &["c.png'", "lies apart"]);
    refused("merge a.png b.png --at 0,30 --keep 2 mask-30.png", 3, &["mask-30.png'", "picture 2", "20,0", "--at"]);
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

#[test]
fn exposures_are_evened_and_who_shows_is_told() {
    let folder = Folder::new("merge-gain");
    let scene =
        |c: usize, [y, x]: [u32; 2]| 60.0 + f64::from((y * 31 + x * 17 + (y / 5) * (x / 7) + c as u32 * 40) % 120);
    write(&folder, "a.png", [40, 50], 3, |c, [y, x]| scene(c, [y, x]) as u8);
    // Darker, and of less contrast in blue.
    let tone = |c: usize| if c == 2 { [0.5, 30.0] } else { [0.8, 0.0] };
    let dark = |c: usize, [y, x]: [u32; 2]| (tone(c)[0] * scene(c, [y, x + 20]) + tone(c)[1]).round() as u8;
    write(&folder, "b.png", [40, 50], 3, dark);
    let line = "merge a.png b.png --at 20,0 --gain --label-map l.png -o out.png --json";
    let said = folder.run(line).done().json();
    let fitted = &said["stats"]["tones"][1];
    for c in 0..3 {
        let [gain, offset] = ["gain", "offset"].map(|part| fitted[part][c].as_f64().unwrap());
        let [by, more] = tone(c);
        assert!((gain * by - 1.0).abs() < 0.02 && (offset * 255.0 + more / by).abs() < 2.0, "{fitted}");
    }
    assert_eq!(said["stats"]["tones"][0]["gain"], serde_json::json!([1.0, 1.0, 1.0]));
    let (out, labels) = (samples(&folder, "out.png"), samples(&folder, "l.png"));
    for (i, [y, x]) in out.domain().positions().enumerate() {
        assert!((0..3).all(|c| (out.value(c, i) - scene(c, [y, x])).abs() < 4.0), "{x},{y}");
        assert!(if x < 20 { labels.value(0, i) == 1.0 } else { x < 50 || labels.value(0, i) == 2.0 });
    }
    assert_eq!((labels.channels(), labels.domain().shape), (1, [40, 70]));
    folder.run("merge a.png b.png --label-map out.png -o out.png").refused(2, &["out.png'", "two outputs"]);
    folder.run("merge a.png b.png --label-map l.xyz -o out.png").refused(2, &["l.xyz'"]);
    folder.run("again out.png -o again.png").done();
    assert_eq!(samples(&folder, "again.png"), out);
}
