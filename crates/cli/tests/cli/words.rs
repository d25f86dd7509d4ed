//! What is said of small mistakes, and of outputs that are not what was hoped for.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::program::Folder;

/// A picture of a colour by place.
fn picture(folder: &Folder, name: &str, [width, height]: [u32; 2], color: impl Fn([u32; 2]) -> [u8; 3]) {
    let domain = Domain::open([height, width]);
    let samples = (0..3).flat_map(|c| domain.positions().map(move |at| (c, at))).map(|(c, at)| color(at)[c]);
    let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples.collect()).unwrap()));
    selvedge_io::write(folder.path(name), &plane, &Default::default(), &Default::default()).unwrap();
}

#[test]
fn what_is_too_small_is_named_with_its_size_as_typed() {
    let folder = Folder::new("words-small");
    picture(&folder, "one.png", [1, 1], |_| [9; 3]);
    picture(&folder, "tall.png", [1, 64], |_| [9; 3]);
    for (line, parts) in [
        ("analogy @/scales.png @/scales.png tall.png -o a.png", ["'tall.png'", "an output of 1x64 px"]),
        ("analogy tall.png tall.png @/scales.png -o a.png", ["'tall.png'", "an exemplar of 1x64 px"]),
        ("score @/scales.png --exemplar one.png", ["'one.png'", "1x1 px are too few"]),
        ("score tall.png --exemplar @/scales.png", ["'tall.png'", "1x64 px are too few"]),
        ("inspect @/scales.png --guide tall.png @/scales.png", ["'tall.png': 1x64 px, but", "scales.png has"]),
        ("optimize one.png -o a.png", ["'one.png'", "no neighborhood of 8 px fits into 1x1 px"]),
        ("video @/fire.png --range 0-5 -o a.gif", ["frame 0 is missing, of frames 1 to 40", "choose a range within"]),
        ("video @/fire.png --range 41-50 -o a.gif", ["frame 41 is missing after 40", "choose a range within"]),
    ] {
        folder.run(line).refused(3, &parts);
    }
    for (line, said) in [
        ("detail @/scales.png --low @/scales.png --scale 2.5 -o a.png", "give a whole number"),
        ("video @/fire.png -o a.flv", ".gif, .png, .y4m, .mp4, .mov"),
        ("animate @/scales.png --flow uniform --angle nan -o a.gif", "an angle of NaN"),
    ] {
        folder.run(line).refused(2, &[said]);
    }
    let as_it_was = folder.run("fill @/scales.png --mask none -o a.png").done();
    assert!(as_it_was.stderr.contains("nothing is transparent"), "{}", as_it_was.stderr);
}

#[test]
fn frames_that_are_written_and_motion_that_is_not_known_are_told() {
    let folder = Folder::new("words-clips");
    let played = folder.run("video @/fire.png --period 16 --play loop --frames 40 -o a.gif").done();
    assert!(played.stderr.contains("written as 40 frames"), "{}", played.stderr);
    let once = folder.run("video @/fire.png --period 16 -o a.gif").done();
    assert!(!once.stderr.contains("written as"), "{}", once.stderr);
    let mut flo = [b"PIEH".as_slice(), &40_i32.to_le_bytes(), &32_i32.to_le_bytes()].concat();
    flo.extend([1e10_f32; 40 * 32 * 2].map(f32::to_le_bytes).concat());
    fs::write(folder.path("lost.flo"), flo).unwrap();
    let still = folder.run("animate @/scales.png --flow lost.flo --init quilt --frames 2 -o b.gif").done();
    assert!(still.stderr.contains("warning: 'lost.flo': no vector of the flow is known"), "{}", still.stderr);
}

#[test]
fn a_smoothed_border_is_no_label_that_is_missing() {
    let folder = Folder::new("words-labels");
    let (red, blue, mixed) = ([255, 0, 0], [0, 0, 255], [128, 0, 128]);
    picture(&folder, "have.png", [192, 192], |[y, _]| if y < 96 { red } else { blue });
    picture(&folder, "want.png", [60, 60], |[y, _]| match y {
        ..30 => red,
        30 => mixed,
        _ => blue,
    });
    picture(&folder, "other.png", [60, 60], |[y, _]| if y < 30 { red } else { mixed });
    let said = folder.run("numbers @/scales.png --labels have.png --target want.png -o a.png").done();
    assert!(said.stderr.contains("1.67 % of its samples are of no label's colour"), "{}", said.stderr);
    let other = folder.run("numbers @/scales.png --labels have.png --target other.png -o b.png");
    other.refused(3, &["no label of the exemplar has the colour #800080"]);
}

#[test]
fn an_output_that_became_a_blur_is_warned_of() {
    let folder = Folder::new("words-blur");
    let blur = "--init random --complete none --finish average --schedule 2:16,1:16 --iterations 12";
    let line = "optimize @/planks.png --size 64 --json -o a.png";
    let flat = folder.run(&format!("{line} {blur}")).done();
    assert!(0.3 < flat.json()["stats"]["washed_out"].as_f64().unwrap(), "{}", flat.json());
    assert!(flat.stderr.contains("became a blur") && flat.stderr.contains("'a.png'"), "{}", flat.stderr);
    let sound = folder.run(&format!("{line} --schedule 1:8 --iterations 2")).done();
    assert_eq!(sound.json()["stats"]["washed_out"], 0.0);
    assert!(!sound.stderr.contains("became a blur"), "{}", sound.stderr);
}
