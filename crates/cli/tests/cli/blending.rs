//! Seams that are hidden: `--feather`, `--spline` and `--fuse` of every command that renders a map.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, WriteOptions};

use crate::graphcut::{map, samples, write};
use crate::program::Folder;

/// Where two pictures differ.
fn differing(a: &Samples<2>, b: &Samples<2>) -> Vec<[u32; 2]> {
    let differs = |i: usize| (0..a.channels()).any(|c| a.value(c, i) != b.value(c, i));
    a.domain().positions().enumerate().filter(|&(i, _)| differs(i)).map(|(_, at)| at).collect()
}

#[test]
fn heights_are_fused_unless_they_are_to_be_copied() {
    let folder = Folder::new("blending-heights");
    folder.run("quilt @/bricks/albedo.png -o a.png --map m.exr --size 150x120 --tile x --block 40").done();
    let applied = |name: &str, options: &str| {
        folder.run(&format!("apply m.exr @/bricks/height.png -o {name}.png {options}")).done();
        samples(&folder, &format!("{name}.png"))
    };
    let (plain, fused) = (applied("plain", "--role scalar"), applied("fused", "--role height"));
    assert_eq!(applied("copied", "--role height --copy"), plain, "bit for bit");
    assert_eq!(applied("asked", "--role scalar --fuse"), fused);
    assert_eq!(applied("displaced", "--role displacement"), fused);
    assert_ne!(applied("splined", "--role height --spline 2"), fused);

    // What steps across seams there are beyond what the texture has elsewhere.
    let made = map(&folder, "m.exr").map;
    let mean = |of: &Samples<2>, at_seams: bool| {
        let edges = made.domain().positions().flat_map(|at| (0..2).map(move |axis| (at, axis)));
        let edges = edges.filter(|&(at, axis)| made.is_seam(at, axis) == at_seams);
        let next = |at, axis| made.domain().next(at, axis).map(|next| made.domain().index(next));
        let steps = edges.filter_map(|(at, axis)| {
            let (here, there) = (of.value(0, made.domain().index(at)), of.value(0, next(at, axis)?));
            Some((here - there).abs())
        });
        let steps: Vec<f64> = steps.collect();
        steps.iter().sum::<f64>() / steps.len() as f64
    };
    let beyond = |of: &Samples<2>| mean(of, true) - mean(of, false);
    assert!(beyond(&fused) < beyond(&plain) / 3.0, "{} of {}", beyond(&fused), beyond(&plain));
    assert!(mean(&fused, false) < 1.1 * mean(&plain, false), "detail is what it was");

    // A displacement in floats, in any unit.
    let domain = Domain::open([192, 192]);
    let Samples::U16(height) = samples(&folder, "@/bricks/height.png") else { panic!("16 bit") };
    let metres = height.samples().iter().map(|&v| f32::from(v) / 65_535.0 * 0.04 - 0.01).collect();
    let plane = Plane::new(Role::Height, Samples::F32(Grid::from_vec(domain, 1, metres).unwrap()));
    selvedge_io::write(folder.path("h.exr"), &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
    folder.run("apply m.exr h.exr -o d.exr --role displacement").done();
    let displaced = samples(&folder, "d.exr");
    let off = (0..displaced.domain().len())
        .map(|i| (displaced.value(0, i) - (fused.value(0, i) / 65_535.0 * 0.04 - 0.01)).abs())
        .fold(0.0, f64::max);
    assert!(off < 0.04 / 65_535.0, "{off}");
}

#[test]
fn quilts_are_blended_and_exact_where_they_are_not() {
    let folder = Folder::new("blending-quilt");
    let line = "quilt @/cobbles.png --size 200 --block 50 --map m.exr";
    folder.run(&format!("{line} -o sharp.png")).done();
    let sharp = samples(&folder, "sharp.png");
    for (options, reach) in [("--feather 1.5", Some(3)), ("--spline 2", Some(6)), ("--spline auto", None)] {
        folder.run(&format!("{line} -o soft.png {options}")).done();
        folder.run(&format!("apply m.exr @/cobbles.png -o again.png {options}")).done();
        let soft = samples(&folder, "soft.png");
        assert_eq!(samples(&folder, "again.png"), soft);
        let made = map(&folder, "m.exr").map;
        // Of wide blends it is enough that they are repeated.
        let near = |at: [u32; 2]| {
            let Some(reach) = reach else { return true };
            let around = Domain::open([2 * reach + 2; 2]).positions().map(|by| by.map(|b| b as i32 - reach as i32 - 1));
            around.filter_map(|by| made.domain().step(at, by)).any(|p| (0..2).any(|axis| made.is_seam(p, axis)))
        };
        let changed = differing(&sharp, &soft);
        assert!(!changed.is_empty() && changed.iter().all(|&at| near(at)), "{options}");
        let command = String::from_utf8(folder.run("info soft.png").done().stdout).unwrap();
        assert!(command.contains(options), "{command}");
    }
    let onto = "transfer @/cobbles.png --target @/grass-grey.png --passes 1";
    folder.run(&format!("{onto} -o t.png --map t.exr --feather 2")).done();
    folder.run("apply t.exr @/cobbles.png -o again.png --feather 2").done();
    assert_eq!(samples(&folder, "t.png"), samples(&folder, "again.png"));
}

#[test]
fn ways_to_blend_exclude_each_other() {
    let folder = Folder::new("blending-refused");
    let line = "quilt @/cobbles.png -o a.png";
    folder.run(&format!("{line} --feather 1 --spline 2")).refused(2, &["--feather", "--spline"]);
    folder.run(&format!("{line} --fuse --spline 2")).refused(2, &["--fuse", "--spline"]);
    folder.run(&format!("{line} --spline 6")).refused(2, &["spline is 6", "0 to 5"]);
    folder.run(&format!("{line} --spline many")).refused(2, &["'many'", "auto"]);
    folder.run(&format!("{line} --feather 17")).refused(2, &["feather is 17", "0 to 16"]);
}

#[test]
fn fusing_may_stay_near_seams_keep_a_mask_and_follow_the_stronger_step() {
    let folder = Folder::new("blending-fuse");
    let ramp = |steep: u32, add: u32| move |_: usize, [y, x]: [u32; 2]| ((y * 7 + x * steep) % 97 + add) as u8;
    write(&folder, "a.png", [40, 60], 3, ramp(3, 20));
    write(&folder, "b.png", [40, 60], 3, ramp(5, 90));
    write(&folder, "mask.png", [40, 60], 1, |_, [y, _]| if y < 8 { 255 } else { 0 });
    write(&folder, "left.png", [40, 60], 1, |_, [_, x]| if x == 0 { 255 } else { 0 });
    write(&folder, "right.png", [40, 60], 1, |_, [_, x]| if x == 59 { 255 } else { 0 });
    let line = "merge a.png b.png --keep 1 left.png --keep 2 right.png";
    let merged = |options: &str| {
        folder.run(&format!("{line} -o out.png --map m.exr {options}")).done();
        samples(&folder, "out.png")
    };
    let (plain, fused, mixed) = (merged(""), merged("--fuse"), merged("--fuse --fuse-mixed"));
    assert!(differing(&fused, &mixed).len() > 1000);
    folder.run("again out.png -o again.png").done();
    assert_eq!(samples(&folder, "again.png"), mixed);

    let near = merged("--fuse --fuse-reach 4");
    let made = map(&folder, "m.exr").map;
    let around = |at: [u32; 2]| {
        let places = (-5..=5).flat_map(|v| (-5..=5).map(move |u| [v, u]));
        places.filter_map(|by| made.domain().step(at, by)).any(|p| (0..2).any(|axis| made.is_seam(p, axis)))
    };
    let changed = differing(&plain, &near);
    assert!(!changed.is_empty() && changed.iter().all(|&at| around(at)));

    let kept = merged("--fuse --fuse-keep mask.png");
    let command = String::from_utf8(folder.run("info out.png").done().stdout).unwrap();
    assert!(command.contains("--fuse --fuse-keep mask.png"), "{command}");
    let changed = differing(&plain, &kept);
    assert!(changed.len() > 500 && changed.iter().all(|[y, _]| 8 <= *y), "{}", changed.len());

    // What says how it is fused fuses.
    assert_eq!((merged("--fuse-reach 4"), merged("--fuse-mixed")), (near, mixed));
    folder.run(&format!("{line} -o no.png --fuse-reach 4 --feather 2")).refused(2, &["--feather"]);
    folder.run(&format!("{line} -o no.png --fuse-keep mask.png")).refused(2, &["--fuse-keep", "add --fuse"]);
    folder.run(&format!("{line} -o mask.png --fuse --fuse-keep mask.png")).refused(4, &["mask.png", "input"]);
    folder.run(&format!("{line} -o no.png --fuse --fuse-keep @/weave.png")).refused(3, &["weave.png", "60x40"]);
    folder.run("graphcut a.png --size 60x40 --fuse --fuse-keep mask.png -o cut.png").done();
    write(
        &folder,
        "hole.png",
        [40, 60],
        1,
        |_, [y, x]| if y.abs_diff(14) < 10 && x.abs_diff(30) < 10 { 255 } else { 0 },
    );
    let cobbles = samples(&folder, &(crate::program::fixtures() + "/cobbles.png"));
    write(&folder, "photo.png", [40, 60], 3, |c, [y, x]| cobbles.value(c, (y * 192 + x) as usize) as u8);
    let filled = |options: &str| {
        folder.run(&format!("fill photo.png --mask hole.png -o out.png {options}")).done();
        samples(&folder, "out.png")
    };
    let kept = filled("--fuse --fuse-keep mask.png");
    assert!(differing(&kept, &filled("--spline 0")).iter().all(|[y, _]| 8 <= *y));
    // It fuses by itself; what has few colours is copied.
    assert_eq!(kept, filled("--fuse-keep mask.png"));
    assert!(differing(&filled("--fuse-mixed"), &filled("")).len() > 10);
    folder.run("fill a.png --mask hole.png -o no.png --fuse-keep mask.png").refused(2, &["add --fuse"]);
    folder.run("extend a.png --size 80x60 --fuse --fuse-keep hole.png -o no.png").refused(3, &["hole.png", "80x60"]);
    folder.run("extend a.png --size 80x60 --fuse --fuse-mixed -o out.png").done();
    folder.run("tile a.png --method band --band 8 --fuse --fuse-reach 9 -o out.png").done();
}
