//! `fill`, `extend` and `tile`: masks of every kind, and what stays.

use selvedge_core::Samples;

use crate::graphcut::{map, samples, write};
use crate::program::{Folder, fixtures};

/// A part of the cobbles.
fn cobbles(folder: &Folder, name: &str, shape: [u32; 2]) {
    let cobbles = samples(folder, &(fixtures() + "/cobbles.png"));
    write(folder, name, shape, 3, |c, [y, x]| cobbles.value(c, (y * 192 + x) as usize) as u8);
}

/// A picture fills where its mask is white, and has its bytes elsewhere.
fn filled(folder: &Folder, mask: impl Fn([u32; 2]) -> u8) -> Samples<2> {
    write(folder, "mask.png", [70, 60], 1, |_, at| mask(at));
    folder.run("fill photo.png --mask mask.png -o out.png --map m.exr").done();
    let (photo, out, made) = (samples(folder, "photo.png"), samples(folder, "out.png"), map(folder, "m.exr").map);
    let domain = made.domain();
    for (i, at) in domain.positions().enumerate() {
        let (_, from) = made.locate(at).unwrap();
        if mask(at) < 128 {
            assert!(from == at && (0..3).all(|c| photo.value(c, i) == out.value(c, i)), "{at:?} stays");
        } else {
            assert!(mask(from) < 128, "{at:?} comes from {from:?}, which is to vanish");
        }
    }
    out
}

#[test]
fn masks_of_every_kind_are_filled_and_all_else_stays() {
    let folder = Folder::new("fill-masks");
    cobbles(&folder, "photo.png", [70, 60]);
    let white = |yes: bool| if yes { 255 } else { 0 };
    filled(&folder, |[y, x]| white(y.abs_diff(35) < 9 && x.abs_diff(30) < 7));
    // At one border, a corner, and all four.
    filled(&folder, |[y, x]| white(y < 12 && (20..40).contains(&x)));
    filled(&folder, |[y, x]| white(y < 10 && x < 14));
    filled(&folder, |[y, x]| white(!(6..64).contains(&y) || !(5..55).contains(&x)));
    // Several, one sample, a ring.
    filled(&folder, |[y, x]| white(y % 30 < 7 && x % 25 < 6));
    filled(&folder, |at| white(at == [40, 11]));
    filled(&folder, |[y, x]| white((9..16).contains(&y.abs_diff(35).max(x.abs_diff(30)))));
    // Larger than the rest, and soft: from half of white on.
    filled(&folder, |[y, x]| white(y.abs_diff(35) < 30 && x.abs_diff(30) < 25));
    filled(&folder, |[y, x]| (y * 3 + x).min(255) as u8);
    let said = folder.run("fill photo.png --mask @/stars.png -o no.png");
    said.refused(3, &["stars.png'", "photo.png'"]);
    write(&folder, "all.png", [70, 60], 1, |_, _| 255);
    folder.run("fill photo.png --mask all.png -o no.png").refused(3, &["photo.png'", "nothing is left", "--from"]);
    folder.run("fill photo.png --mask all.png --from @/cobbles.png -o from.png").done();
    write(&folder, "none.png", [70, 60], 1, |_, _| 127);
    let said = folder.run("fill photo.png --mask none.png -o same.png").done();
    assert!(said.stderr.contains("as it was: the mask has no white"), "{said:?}");
    assert_eq!(samples(&folder, "same.png"), samples(&folder, "photo.png"));
    let said = folder.run("fill photo.png -o same.png").done();
    assert!(said.stderr.contains("as it was: nothing is transparent"), "{said:?}");
    folder
        .run("fill photo.png --from a.png --from b.png --source-mask none -o no.png")
        .refused(2, &["--source-mask", "2 pictures"]);
}

#[test]
fn small_pictures_are_filled_in_any_depth() {
    let folder = Folder::new("fill-depths");
    write(&folder, "line.png", [1, 50], 1, |_, [_, x]| (x % 7 * 30) as u8);
    write(&folder, "line-mask.png", [1, 50], 1, |_, [_, x]| if (20..27).contains(&x) { 255 } else { 0 });
    folder.run("fill line.png --mask line-mask.png -o out.png").done();
    write(&folder, "one.png", [1, 1], 1, |_, _| 0);
    folder.run("fill @/bad/ok-1x1.png --mask one.png -o one-out.png").done();
    write(&folder, "mask.png", [192, 192], 1, |_, [y, x]| if (80..110).contains(&y) && x < 30 { 255 } else { 0 });
    for (picture, out) in [("@/bricks/height.png", "h.png"), ("@/cobbles.png", "c.exr --depth half")] {
        folder.run(&format!("fill {picture} --mask mask.png -o {out}")).done();
    }
    folder.run("fill @/cobbles-hole.png -o whole.png").done();
    let (hole, whole) = (samples(&folder, &(fixtures() + "/cobbles-hole.png")), samples(&folder, "whole.png"));
    assert!((0..128 * 128).all(|i| whole.value(3, i) == 255.0
        && (hole.value(3, i) == 0.0 || (0..3).all(|c| hole.value(c, i) == whole.value(c, i)))));
    folder.run("fill @/bricks/albedo.png --mask mask.png --with @/bricks/roughness.png -o a-{name}").done();
    let (rough, out) = (samples(&folder, "@/bricks/roughness.png"), samples(&folder, "a-roughness.png"));
    let hole = |i: usize| (80..110).contains(&(i / 192)) && i % 192 < 30;
    assert!((0..192 * 192).all(|i| hole(i) || rough.value(0, i) == out.value(0, i)), "other planes stay as well");
    assert!((0..192 * 192).any(|i| rough.value(0, i) != out.value(0, i)));
}

#[test]
fn what_is_filled_in_is_fused_unless_a_mean_stands_for_nothing() {
    let folder = Folder::new("fill-fused");
    write(&folder, "mask.png", [70, 60], 1, |_, [y, x]| if y.abs_diff(35) < 9 && x < 20 { 255 } else { 0 });
    cobbles(&folder, "photo.png", [70, 60]);
    let run = |line: &str| folder.run(&format!("fill {line}")).done();
    let said = run("photo.png --mask mask.png -o out.png --map m.exr");
    assert!(said.stderr.contains("fused with what is around"), "{said:?}");
    run("photo.png --mask mask.png -o fused.png --fuse");
    let said = run("photo.png --mask mask.png -o copied.png --spline 0");
    assert!(!said.stderr.contains("fused") && !said.stderr.contains("copied,"), "{said:?}");
    folder.run("apply m.exr photo.png -o map.png").done();
    let of = |name: &str| samples(&folder, name);
    assert_eq!((of("out.png"), of("map.png")), (of("fused.png"), of("copied.png")));
    assert_ne!(of("out.png"), of("copied.png"));
    let info = |name: &str| String::from_utf8(folder.run(&format!("info {name}")).done().stdout).unwrap();
    assert!(info("out.png").contains("--fuse") && info("copied.png").contains("--spline 0"));
    for name in ["out", "copied"] {
        folder.run(&format!("again {name}.png -o {name}-again.png")).done();
        assert_eq!(of(&format!("{name}.png")), of(&format!("{name}-again.png")));
    }
    // Labels, light, normals.
    write(&folder, "labels.png", [70, 60], 3, |c, [y, x]| if (y / 7 + x / 9) % 3 == c as u32 { 200 } else { 10 });
    for (picture, out, why) in [
        ("labels.png", "l.png", "few colours"),
        ("photo.png --depth half", "h.exr", "light"),
        ("rock_normal.png", "n.png", "normals"),
    ] {
        if picture == "rock_normal.png" {
            cobbles(&folder, picture, [70, 60]);
        }
        let said = run(&format!("{picture} --mask mask.png -o {out} --map m-{out}.exr"));
        assert!(
            said.stderr.contains(&format!("copied, since it holds {why}"))
                || said.stderr.contains(&format!("copied, since it has {why}")),
            "{said:?}"
        );
    }
    let colors = |name: &str| -> std::collections::BTreeSet<Vec<u64>> {
        let of = of(name);
        let color = |i| (0..3).map(|c| of.value(c, i).to_bits()).collect();
        (0..of.domain().len()).map(color).collect()
    };
    assert_eq!(colors("l.png"), colors("labels.png"));
    // Planes beside it are laid as they were: heights fused, all else copied.
    cobbles(&folder, "wall_albedo.png", [70, 60]);
    cobbles(&folder, "wall_roughness.png", [70, 60]);
    run("wall_albedo.png --mask mask.png --with wall_roughness.png -o w-{name}");
    assert_eq!((of("w-wall_albedo.png"), of("w-wall_roughness.png")), (of("out.png"), of("copied.png")));
}

#[test]
fn what_is_filled_is_opaque_and_may_be_a_jpeg() {
    let folder = Folder::new("fill-jpeg");
    folder.run("fill @/cobbles-hole.png -o out.jpg").done();
    assert_eq!((samples(&folder, "out.jpg").channels(), samples(&folder, "out.jpg").domain().shape), (3, [128, 128]));
    folder.run("extend @/cobbles-hole.png --size 160x128 -o wide.jpg").done();
    assert_eq!(samples(&folder, "wide.jpg").channels(), 3);
    let hole = samples(&folder, &(fixtures() + "/cobbles-hole.png"));
    // Some of it is translucent, and would stay so.
    write(&folder, "veil.png", [128, 128], 4, |c, [y, x]| match hole.value(c, (y * 128 + x) as usize) as u8 {
        255 if c == 3 && y < 9 => 100,
        value => value,
    });
    for command in ["fill", "extend --size 130x130"] {
        let said = folder.run(&format!("{command} veil.png -o no.jpg"));
        said.refused(3, &["veil.png'", "3 channels and alpha", "jpeg", "no.jpg"]);
    }
    write(&folder, "mask.png", [128, 128], 1, |_, [y, _]| if y < 9 { 255 } else { 0 });
    let said = folder.run("fill @/cobbles-hole.png --mask mask.png -o no.jpg");
    said.refused(3, &["cobbles-hole.png'", "3 channels and alpha"]);
}

#[test]
fn tiles_close_and_keep_their_middle() {
    let folder = Folder::new("tile");
    cobbles(&folder, "photo.png", [90, 80]);
    folder.run("tile photo.png -o over.png --map m.exr").done();
    let made = map(&folder, "m.exr").map;
    assert_eq!(made.domain().periodic, [true, true]);
    assert!((45..90).contains(&made.domain().shape[0]) && (40..80).contains(&made.domain().shape[1]));
    folder.run("tile photo.png -o x.png --tile x --overlap 20 --map x.exr").done();
    let made = map(&folder, "x.exr").map;
    assert_eq!((made.domain().shape, made.domain().periodic), ([90, 60], [false, true]));
    folder.run("tile photo.png -o band.png --method band --band 9 --map b.exr").done();
    let (photo, band, made) = (samples(&folder, "photo.png"), samples(&folder, "band.png"), map(&folder, "b.exr").map);
    assert_eq!((made.domain().shape, made.domain().periodic), ([90, 80], [true, true]));
    for (i, [y, x]) in made.domain().positions().enumerate() {
        let middle = (9..81).contains(&y) && (9..71).contains(&x);
        assert!(!middle || (0..3).all(|c| photo.value(c, i) == band.value(c, i)), "{x}, {y}");
    }
    folder.run("tile photo.png -o no.png --overlap 0").refused(2, &["0 px", "give 2 px", "leave it out"]);
    folder.run("tile photo.png -o no.png --overlap 1").refused(2, &["1 px", "give 2 px", "leave it out"]);
    folder.run("tile photo.png photo.png -o no.png").refused(2, &["2 pictures", "--method band"]);
    folder.run("tile photo.png -o no.png --method band --band 0").refused(2, &["0 px", "leave it out"]);
    for dry in ["", " --dry-run"] {
        folder.run(&format!("tile photo.png -o no.png --overlap 60{dry}")).refused(3, &["overlap", "60", "half"]);
        let line = format!("tile photo.png -o no.png --method band --band 50{dry}");
        folder.run(&line).refused(3, &["photo.png'", "band", "50", "half"]);
        for method in ["overlap", "band"] {
            let line = format!("tile @/bad/ok-1x1.png -o no.png --method {method}{dry}");
            folder.run(&line).refused(3, &["ok-1x1.png'", "1 pixel", "border"]);
        }
    }
    // What is transparent stays so.
    let said = folder.run("tile @/cobbles-hole.png -o hole.png").done();
    let hole = samples(&folder, "hole.png");
    let holes = (0..hole.domain().len()).filter(|&i| hole.value(3, i) == 0.0).count();
    assert!(0 < holes && said.stderr.contains(&format!("{holes} pixels transparent")), "{holes}: {said:?}");
    folder.run("tile photo.png -o no.png --band 9").refused(2, &["--band", "--method band"]);
}

#[test]
fn pictures_are_extended_around_what_they_show() {
    let folder = Folder::new("extend");
    cobbles(&folder, "photo.png", [60, 50]);
    let photo = samples(&folder, "photo.png");
    for (options, shape, [top, left]) in [
        ("--size 1.5x", [90, 75], [15, 12]),
        ("--size 60x60 --anchor ne", [60, 60], [0, 10]),
        ("--size 90x60 --anchor W --tile x --fuse", [60, 90], [0, 0]),
        ("--size 50x60", [60, 50], [0, 0]),
    ] {
        folder.run(&format!("extend photo.png -o out.png --map m.exr {options}")).done();
        let (out, made) = (samples(&folder, "out.png"), map(&folder, "m.exr").map);
        assert_eq!((made.domain().shape, made.holes()), (shape, 0), "{options}");
        assert_eq!(made.domain().periodic, [false, options.contains("--tile x")]);
        for (i, [y, x]) in photo.domain().positions().enumerate() {
            let at = [y + top, x + left];
            let same = (0..3).all(|c| photo.value(c, i) == out.value(c, made.domain().index(at)));
            assert!(same && made.locate(at) == Some((0, [y, x])), "{options}: {x},{y}");
        }
    }
    let said = folder.run("extend photo.png --size 2x -o no.png --dry-run").done();
    assert!(said.stderr.contains("would be 100x120 px with 9000 pixels filled"), "{said:?}");
    folder.run("extend photo.png --size 40x80 -o no.png").refused(3, &["photo.png'", "50x60 px", "40x80 px", "--size"]);
    folder.run("extend photo.png -o no.png").refused(2, &["--size"]);
    // A cut-out: its hole is filled as well.
    folder.run("extend @/cobbles-hole.png --size 160x128 --anchor w -o whole.png").done();
    let whole = samples(&folder, "whole.png");
    assert!((0..160 * 128).all(|i| whole.value(3, i) == 255.0));
    // What it carries makes it again.
    folder.run("extend photo.png --size 1.2x --anchor se -o first.png").done();
    folder.run("again first.png -o second.png").done();
    assert_eq!(samples(&folder, "first.png"), samples(&folder, "second.png"));
}

#[test]
fn one_period_is_cut_out_and_tiles() {
    let folder = Folder::new("tile-period");
    write(&folder, "grid.png", [100, 120], 3, |c, [y, x]| {
        let (v, u) = (y % 20, x % 24);
        (40 + (v * v * 3 + u * 7 + v * u * (1 + c as u32)) % 200) as u8
    });
    folder.run("tile grid.png --period auto -o out.png --map m.exr --preview p.png").done();
    let (out, grid, made) = (samples(&folder, "out.png"), samples(&folder, "grid.png"), map(&folder, "m.exr").map);
    assert_eq!(made.domain(), selvedge_core::Domain::periodic([20, 24]));
    assert_eq!(samples(&folder, "p.png").domain().shape, [40, 48]);
    let value =
        |of: &Samples<2>, width: u32, [y, x]: [u32; 2]| [0, 1, 2].map(|c| of.value(c, (y * width + x) as usize));
    let (_, [top, left]) = made.locate([0, 0]).unwrap();
    for [y, x] in made.domain().positions() {
        assert_eq!(value(&out, 24, [y, x]), value(&grid, 120, [(top + y) % 20, (left + x) % 24]), "{x},{y}");
    }
    folder.run("tile grid.png --period 48x20 --tile x -o x.png --map x.exr").done();
    let made = map(&folder, "x.exr").map;
    assert_eq!((made.domain().shape, made.domain().periodic), ([100, 48], [false, true]));
    cobbles(&folder, "photo.png", [90, 80]);
    folder
        .run("tile photo.png --period auto -o no.png --dry-run")
        .refused(3, &["photo.png'", "comes again", "--period"]);
    folder.run("tile grid.png --period 200 -o no.png").refused(3, &["200", "grid.png'"]);
    folder.run("tile grid.png --period 20 --method band -o no.png").refused(2, &["--period", "--method overlap"]);
}

#[test]
fn copies_may_have_to_come_from_farther_away() {
    let folder = Folder::new("fill-avoid-near");
    let filled = |options: &str| {
        folder.run(&format!("fill @/cobbles-hole.png -o out.png {options}")).done();
        samples(&folder, "out.png")
    };
    let (usual, far) = (filled(""), filled("--avoid-near 60"));
    assert!(usual != far);
    let command = String::from_utf8(folder.run("info out.png").done().stdout).unwrap();
    assert!(command.contains("--avoid-near 60"), "{command}");
    folder.run("fill @/cobbles-hole.png -o no.png --avoid-near 0").refused(2, &["--avoid-near"]);
}

#[test]
fn inspect_tells_the_offsets_that_fill_goes_by() {
    let folder = Folder::new("inspect-offsets");
    let value = |y: u32, x: u32| ((y % 20 * 16 + x % 16).wrapping_mul(2_654_435_761) >> 24) as u8;
    write(&folder, "a.png", [70, 60], 1, |_, [y, x]| value(y, x));
    let offsets = |file: &str| {
        let said = folder.run(&format!("inspect {file} --offsets --json")).done().json();
        serde_json::from_value::<Vec<[i32; 2]>>(said["stats"]["offsets"].clone()).unwrap()
    };
    let found = offsets("a.png");
    assert!(!found.is_empty() && found.iter().all(|[x, y]| x % 16 == 0 && y % 20 == 0), "{found:?}");
    assert!(folder.run("inspect a.png --json").done().json()["stats"]["offsets"].is_null());
    // Of large pictures they are looked for at a smaller size, and told in pixels of this one.
    write(&folder, "b.png", [60, 500], 1, |_, [y, x]| value(y / 2, x / 2));
    let found = offsets("b.png");
    assert!(!found.is_empty() && found.iter().all(|[x, y]| x % 32 == 0 && y % 40 == 0), "{found:?}");
}
