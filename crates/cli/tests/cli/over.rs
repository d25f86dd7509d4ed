//! `graphcut --over`: holes are filled, and what is there stays.

use crate::graphcut::{map, samples, write};
use crate::program::Folder;

#[test]
fn holes_of_a_picture_are_filled() {
    let folder = Folder::new("graphcut-over");
    write(&folder, "over.png", [50, 40], 4, |c, [y, x]| match c {
        3 => {
            if y.abs_diff(25) < 12 && x.abs_diff(20) < 9 {
                0
            } else {
                255
            }
        }
        c => (y * 5 + x * 3 + c as u32 * 40) as u8,
    });
    let line = "graphcut @/cobbles.png --over over.png --region 16 --reach 4 --refine 3";
    for (i, how) in ["", "--placement entire", "--feather 2"].iter().enumerate() {
        let name = format!("whole-{i}.png");
        folder.run(&format!("{line} -o {name} {how}")).done();
        let (over, out) = (samples(&folder, "over.png"), samples(&folder, &name));
        let opaque = |i: &usize| over.value(3, *i) == 255.0;
        assert!((0..50 * 40).all(|i| out.value(3, i) == 255.0), "{how}");
        let stays = |i: usize| (0..3).all(|c| over.value(c, i) == out.value(c, i));
        assert!((0..50 * 40).filter(opaque).all(stays), "{how}: what is there stays to the bit");
    }
    folder.run(&format!("{line} -o out.png --map m.exr --blend-in 5")).done();
    let (over, out) = (samples(&folder, "over.png"), samples(&folder, "out.png"));
    let opaque = |i: usize| over.value(3, i) == 255.0;
    assert!((0..50 * 40).all(|i| out.value(3, i) == 255.0));
    // Seams may eat into the picture, but only from the hole on; what is left of it is where it was.
    let kept = |i: usize| (0..3).all(|c| over.value(c, i) == out.value(c, i));
    let made = map(&folder, "m.exr").map;
    for i in (0..50 * 40).filter(|i| opaque(*i)) {
        let (source, from) = made.locate(made.domain().position(i)).unwrap();
        assert!(source == 0 || kept(i) && made.domain().index(from) == i);
        let [y, x] = made.domain().position(i);
        assert!(kept(i) || (y.abs_diff(25) < 12 + 5 && x.abs_diff(20) < 9 + 5), "beyond the band, at {x}, {y}");
    }
    assert!((0..50 * 40).any(|i| opaque(i) && !kept(i)), "patches cut into the band");
    folder.run("apply m.exr @/cobbles.png over.png -o again.png").done();
    assert_eq!(samples(&folder, "again.png"), out);
    folder.run("graphcut @/cobbles.png -o n.png --start m.exr --blend-in 3").refused(2, &["--blend-in", "--over"]);
    folder.run("graphcut @/cobbles.png -o more.png --over over.png --start m.exr --region 16 --refine 9").done();
    folder.run("graphcut @/cobbles.png -o n.png --start m.exr").refused(3, &["'m.exr'", "'over.png'", "--over"]);
    let refused = folder.run("graphcut @/cobbles.png -o n.png --over over.png --size 64");
    refused.refused(3, &["'over.png'", "40x50 px", "64x64 px"]);
    let refused = folder.run("graphcut @/cobbles.png -o n.png --over over.png --fixed @/stars.png");
    refused.refused(3, &["stars.png'", "128x128 px", "40x50 px"]);
}

#[test]
fn more_sources_than_a_place_can_choose_from_are_refused_before_they_are_read() {
    let folder = Folder::new("over-many");
    let exemplars = |n: usize| vec!["@/cobbles.png"; n].join(" ");
    for command in [
        format!("hybrid {} --turn --mirror", exemplars(8)),
        format!("detail {} --low @/stars.png --scale 2", exemplars(16)),
    ] {
        let refused = folder.run(&format!("{command} -o a.png --over @/bricks/height.png"));
        refused.refused(2, &["64 exemplars and orientations are more than --over tells apart", "at most 63"]);
    }
}

#[test]
fn what_is_to_vanish_does_not_come_back_from_the_same_picture() {
    let folder = Folder::new("graphcut-same");
    let hole = |[y, x]: [u32; 2]| (60..100).contains(&y) && (80..130).contains(&x);
    write(&folder, "keep.png", [192, 192], 1, |_, at| if hole(at) { 0 } else { 255 });
    // A defect in the middle of the hole.
    let cobbles = samples(&folder, &(crate::program::fixtures() + "/cobbles.png"));
    let stain = |[y, x]: [u32; 2]| y.abs_diff(80) < 10 && x.abs_diff(105) < 10;
    let value = |c: usize, [y, x]: [u32; 2]| cobbles.value(c, (y * 192 + x) as usize) as u8;
    write(&folder, "photo.png", [192, 192], 3, |c, at| if stain(at) { 255 } else { value(c, at) });
    let said = folder.run("graphcut photo.png -o out.png --over photo.png --fixed keep.png --map m.exr").done();
    assert!(said.stderr.contains("'photo.png' agrees with 'photo.png' around its holes"), "{said:?}");
    let made = map(&folder, "m.exr").map;
    for at in made.domain().positions().filter(|at| hole(*at)) {
        let (source, from) = made.locate(at).unwrap();
        assert!(source == 0 && !hole(from), "{at:?} comes from {from:?}");
    }
    // Another picture of that size lends all of itself.
    let said = folder.run("graphcut @/weave.png -o other.png --over photo.png --fixed keep.png --map m.exr").done();
    assert!(!said.stderr.contains("around its holes"), "{said:?}");
}
