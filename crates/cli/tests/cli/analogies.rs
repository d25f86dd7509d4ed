//! Constrained synthesis: what is told of guides that do not fit, and runs that sweep what is not known yet.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::graphcut::write;
use crate::program::{Folder, fixtures};

const NUMBERS: &str =
    "numbers @/ground/picture.png --labels @/ground/labels.png --target @/ground/target.png --history 1";

#[test]
fn what_nothing_under_the_exemplars_is_like_is_told_before_the_work() {
    let folder = Folder::new("analogies-fit");
    let said = folder.run(&format!("{NUMBERS} -o out.png --dry-run")).done();
    assert!(!said.stderr.contains("is like nothing"), "{}", said.stderr);
    // A photograph is to be led by colours that it has nowhere.
    let pair = "analogy @/cobbles.png @/cobbles.png @/ground/target.png -o out.png --dry-run";
    let said = folder.run(pair).done();
    assert!(said.stderr.contains("target.png': 100 % of it is like nothing under the exemplars"), "{}", said.stderr);
    let said = folder.run("inspect @/cobbles.png --guide @/cobbles.png @/ground/target.png --json").done();
    assert_eq!((&said.json()["stats"]["guides"][0]["uncovered"], said.stderr.as_str()), (&1.0.into(), ""));
    let said = folder.run("inspect @/cobbles.png --guide @/ground/labels.png @/ground/target.png");
    said.refused(3, &["labels.png"]);
}

#[test]
fn agreement_that_is_as_dear_as_it_can_be_is_told() {
    let folder = Folder::new("analogies-saturated");
    let run = |weight| folder.run(&format!("{NUMBERS} -o out.png -K {weight} -N 2 --levels 1")).done();
    assert!(run("10000").stderr.contains("use a smaller -K"), "{}", run("10000").stderr);
    assert!(!run("2").stderr.contains("use a smaller -K"), "{}", run("2").stderr);
}

#[test]
fn a_sweep_makes_a_run_for_each_pair_of_values() {
    let folder = Folder::new("analogies-sweep");
    let said = folder.run(&format!("{NUMBERS} --sweep K=.5,5 N=1,2,3 -o {{n}}.png --sheet sheet.png --dry-run")).done();
    assert_eq!(said.stderr.lines().filter(|line| line.contains("under 1 constraint")).count(), 6, "{}", said.stderr);
    folder.run(&format!("{NUMBERS} --sweep K=1,2 -o out.png")).refused(2, &["'{n}'"]);
    folder.run(&format!("{NUMBERS} --sweep K=1 K=2 -o {{n}}.png")).refused(2, &["two lists"]);
    folder.run(&format!("{NUMBERS} --sweep X=1 -o {{n}}.png")).refused(2, &["K=.05"]);
    folder.run(&format!("{NUMBERS} --sweep N=1,40 -o {{n}}.png")).refused(2, &["40"]);
    folder.run(&format!("{NUMBERS} --sweep N=40 -o out.png")).refused(2, &["40"]);
    assert!(folder.names().is_empty(), "refused before the first run: {:?}", folder.names());
}

/// Frames b.1.png to b.4.png, over which a picture is panned by two pixels each, and pan.flo that says so.
fn panned(folder: &Folder) {
    let picture = selvedge_io::read(fixtures() + "/ground/target.png", &Default::default()).unwrap().plane;
    let Samples::U8(grid) = &picture.samples else { panic!("8 bits") };
    let (domain, channels) = (Domain::open([48, 56]), grid.channels());
    for frame in 0..4_u32 {
        let seen = |c: usize| domain.positions().map(move |[y, x]| grid.get(c, [y, x + 2 * frame]));
        let samples = (0..channels).flat_map(seen).collect();
        let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, channels, samples).unwrap()));
        let path = folder.path(format!("b.{}.png", frame + 1));
        let bytes = selvedge_io::encode(&plane, &Default::default(), &path, &Default::default()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let head = [b"PIEH".to_vec(), 56_i32.to_le_bytes().to_vec(), 48_i32.to_le_bytes().to_vec()].concat();
    let vector = [(-2_f32).to_le_bytes(), 0_f32.to_le_bytes()].concat();
    fs::write(folder.path("pan.flo"), [head, vector.repeat(domain.len())].concat()).unwrap();
}

const FRAMES: &str =
    "analogy @/ground/labels.png @/ground/picture.png b.#.png -K 1 -N 1 --history 2 -o o.#.png --map m.#.exr";

/// Of the samples that stay in sight from frame to frame, how many show the same.
fn steady(folder: &Folder) -> f64 {
    let map =
        |frame: u32| selvedge_io::read_map(folder.path(format!("m.{frame}.exr")), &Default::default()).unwrap().map;
    let (mut same, mut all) = (0, 0);
    for frame in 1..4 {
        let (before, after) = (map(frame), map(frame + 1));
        for [y, x] in after.domain().positions().filter(|[_, x]| x + 2 < 56) {
            all += 1;
            same += u32::from(after.ids.get(0, [y, x]) == before.ids.get(0, [y, x + 2]));
        }
    }
    f64::from(same) / f64::from(all)
}

#[test]
fn frames_go_on_from_each_other_along_a_flow() {
    let folder = Folder::new("analogies-frames");
    panned(&folder);
    let said = folder.run(&format!("{FRAMES} --flow pan.flo --json")).done();
    assert_eq!(said.json()["runs"].as_array().unwrap().len(), 4);
    let made = folder.files();
    assert!((1..=4).all(|i| made.contains_key(std::path::Path::new(&format!("o.{i}.png")))), "{:?}", folder.names());
    let along = steady(&folder);
    // What was ended is gone on with, to the same bytes, on any number of threads.
    for name in ["o.3.png", "m.3.exr", "o.4.png"] {
        fs::remove_file(folder.path(name)).unwrap();
    }
    let said = folder.run(&format!("{FRAMES} --flow pan.flo --resume -j 3")).done();
    assert!(said.stderr.contains("2 of 4 frames are there"), "{}", said.stderr);
    assert_eq!(folder.files(), made);
    let said = folder.run(&format!("{FRAMES} --flow pan.flo --resume")).done();
    assert!(said.stderr.contains("4 of 4 frames are there"), "{}", said.stderr);
    folder.run(&format!("{FRAMES} --temporal 0")).done();
    let alone = steady(&folder);
    assert!(0.8 < along && alone < 0.2, "{along} along the flow, {alone} where each is made by itself");
}

#[test]
fn frames_that_do_not_belong_together_are_refused_before_the_first() {
    let folder = Folder::new("analogies-no-frames");
    panned(&folder);
    let before = folder.names();
    let pair = "analogy @/ground/labels.png @/ground/picture.png";
    folder.run(&format!("{pair} b.#.png -o out.png")).refused(2, &["out.png", "'name.####.png'"]);
    folder.run(&format!("{pair} b.1.png -o o.png --flow pan.flo")).refused(2, &["--flow", "B is one picture"]);
    folder.run(&format!("{pair} b.1.png -o o.png --temporal 0.1")).refused(2, &["--temporal", "B is one picture"]);
    folder.run(&format!("{pair} b.#.png -o o.#.png --flow-direction forward")).refused(2, &["--flow-direction"]);
    folder.run(&format!("{pair} b.#.png -o o.#.png --resume")).refused(2, &["--map"]);
    folder.run(&format!("{pair} b.#.png -o o.#.png --temporal -1")).refused(2, &["-1"]);
    folder.run(&format!("{pair} b.#.png -o o.#.png --start m.exr")).refused(2, &["--start"]);
    folder.run(&format!("{pair} b.#.png -o o.#.png --flow pan.flo --temporal 0")).refused(2, &["--flow", "--temporal"]);
    // One flow by a pattern is not one for all, and one of another size is seen before the work.
    let flow = fs::read(folder.path("pan.flo")).unwrap();
    fs::write(folder.path("f.1.flo"), &flow).unwrap();
    folder.run(&format!("{pair} b.#.png -o o.#.png --flow f.#.flo")).refused(3, &["1 flow for 3 steps"]);
    let narrow = [&flow[..4], &55_u32.to_le_bytes()[..], &flow[8..12], &vec![0; 55 * 48 * 8][..]].concat();
    fs::write(folder.path("f.1.flo"), narrow).unwrap();
    folder.run(&format!("{pair} b.#.png -o o.#.png --flow f.1.flo")).refused(3, &["55x48", "the frames have 56x48"]);
    fs::remove_file(folder.path("f.1.flo")).unwrap();
    // The first frame would be written over the second, which is still to be read.
    for frame in 1..5 {
        let name = |frame: u32| folder.path(format!("b.{frame}.png"));
        fs::rename(name(frame), name(frame - 1)).unwrap();
    }
    let frames = folder.files();
    folder.run(&format!("{pair} b.#.png -o b.#.png")).refused(4, &["b.1.png", "input"]);
    assert_eq!(folder.files(), frames);
    for frame in (1..5).rev() {
        let name = |frame: u32| folder.path(format!("b.{frame}.png"));
        fs::rename(name(frame - 1), name(frame)).unwrap();
    }
    fs::copy(fixtures() + "/ground/target.png", folder.path("b.5.png")).unwrap();
    folder.run(&format!("{pair} b.#.png -o o.#.png")).refused(3, &["b.5.png", "80x60", "56x48"]);
    fs::copy(folder.path("b.4.png"), folder.path("c.1.png")).unwrap();
    fs::copy(folder.path("b.4.png"), folder.path("c.2.png")).unwrap();
    fs::remove_file(folder.path("b.5.png")).unwrap();
    let guide = "--guide @/ground/labels.png c.#.png";
    folder.run(&format!("{pair} b.#.png {guide} -o o.#.png")).refused(3, &["2 files for 4 frames"]);
    fs::remove_file(folder.path("c.1.png")).unwrap();
    fs::remove_file(folder.path("c.2.png")).unwrap();
    assert_eq!(folder.names(), before);
}

#[test]
fn a_frame_that_cannot_be_made_says_what_is_there() {
    let folder = Folder::new("analogies-broken-frame");
    panned(&folder);
    let third = fs::read(folder.path("b.3.png")).unwrap();
    fs::write(folder.path("b.3.png"), &third[..third.len() / 2]).unwrap();
    folder.run(FRAMES).refused(3, &["b.3.png", "2 frames before are written, and go on with --resume"]);
    assert!(folder.path("m.2.exr").is_file() && !folder.path("o.3.png").exists(), "{:?}", folder.names());
    fs::write(folder.path("b.3.png"), third).unwrap();
    // Other planes of the exemplar come with each frame, by names of their own.
    let pair = "analogy @/ground/labels.png @/ground/picture.png";
    folder.run(&format!("{pair} b.#.png -o {{stem}}.#.png --with @/ground/labels.png --dry-run")).done();
}

#[test]
fn threads_change_nothing_of_what_is_made_beside_labels() {
    let folder = Folder::new("analogies-threads");
    let lines = [
        "detail @/cobbles.png --low @/ground/target.png --scale 2 --no-turn --levels 1 --tolerance 1e6 --match-low",
        "detail @/cobbles.png --low @/ground/target.png --scale 2 --no-turn --levels 1 --tolerance 1e6 --kernel lanczos",
        "analogy @/ground/labels.png @/ground/picture.png @/ground/target.png --auto-guides edge=.2,orientation,blur=.1 \
         --follow-where @/ground/target.png -K 1 -N 1 --history 1",
    ];
    let mut different = Vec::new();
    for line in lines {
        let made = [1, 2, 3].map(|threads| {
            folder.run(&format!("{line} -o {threads}.png -j {threads}")).done();
            fs::read(folder.path(format!("{threads}.png"))).unwrap()
        });
        assert!(made[0] == made[1] && made[1] == made[2], "{line}");
        different.extend(made.into_iter().take(1));
    }
    assert!(different[0] != different[1], "a kernel is another reduction");
}

#[test]
fn what_is_transparent_says_nothing() {
    let folder = Folder::new("analogies-transparent");
    // The same but for what is hidden: stars there, and red.
    folder.pierced("@/stars.png", "red.png", |x| 64 <= x);
    let mut red = selvedge_io::read(folder.path("red.png"), &Default::default()).unwrap().plane;
    let Samples::U8(grid) = &mut red.samples else { panic!("8 bits") };
    let alpha = grid.plane(3).to_vec();
    for i in (0..alpha.len()).filter(|i| alpha[*i] == 0) {
        (grid.plane_mut(0)[i], grid.plane_mut(1)[i]) = (3, (i * 7 % 256) as u8);
    }
    let path = folder.path("other.png");
    fs::write(&path, selvedge_io::encode(&red, &Default::default(), &path, &Default::default()).unwrap()).unwrap();
    folder.pierced("@/stars.png", "none.png", |_| true);
    let pair = "@/stars.png @/stars.png";
    for (name, line) in [
        ("b", format!("analogy {pair} $ --luminance")),
        ("a", "analogy $ @/stars.png @/stars.png".to_owned()),
        ("guide", format!("analogy {pair} @/stars.png --guide @/stars.png $")),
        ("low", "detail @/stars.png --low $ --scale 1".to_owned()),
        ("cms", "transfer @/stars.png --target $ --method cms".to_owned()),
        ("quilt", "transfer @/stars.png --target $".to_owned()),
        ("target", "numbers @/stars.png --labels @/stars.png --target $".to_owned()),
        ("labels", "numbers @/stars.png --labels $ --target @/stars.png".to_owned()),
    ] {
        let few = if name == "quilt" { "" } else { "--history 1 -K 1 -N 1" };
        let few = if name == "cms" { "-K 1 -N 1" } else { few };
        for of in ["red", "other"] {
            folder.run(&format!("{} {few} -o {name}-{of}.png", line.replace('$', &format!("{of}.png")))).done();
        }
        folder.run(&format!("compare {name}-red.png {name}-other.png")).done();
        folder.run(&format!("{} -o no.png", line.replace('$', "none.png"))).refused(3, &["none.png", "transparent"]);
    }
}

#[test]
fn what_lies_under_the_exemplars_is_written_as_the_output_has_it() {
    let folder = Folder::new("analogies-mapped");
    for one_hot in ["", "--one-hot"] {
        folder.run(&format!("{NUMBERS} {one_hot} -K 9 -N 1 -o o.png --map m.exr --mapped q.png")).done();
        folder.run("apply m.exr @/ground/labels.png --role color -o laid.png").done();
        folder.run("compare q.png laid.png").done();
    }
    // Under the exemplar of detail lies what no file holds.
    let detail = "detail @/cobbles.png --low @/ground/target.png --scale 2 --history 1 --tolerance 1e6";
    folder.run(&format!("{detail} -o {{stem}}-o.png --mapped {{stem}}-q.png")).done();
    let size = |name: &str| selvedge_io::read(folder.path(name), &Default::default()).unwrap().plane.domain();
    assert_eq!(size("cobbles-q.png"), size("cobbles-o.png"));
    folder.run(&format!("{NUMBERS} -o o.png --mapped o.png")).refused(2, &["o.png", "two outputs"]);
    panned(&folder);
    folder.run(&format!("{FRAMES} --mapped q.png")).refused(2, &["q.png", "'name.####.png'"]);
    folder.run(&format!("{FRAMES} --mapped q.#.png")).done();
    assert_eq!(size("q.4.png"), size("o.4.png"));
}

#[test]
fn the_report_shows_what_a_run_was_like_meanwhile() {
    let folder = Folder::new("analogies-course");
    let lines = [
        format!("{NUMBERS} --one-hot"),
        "transfer @/cobbles.png --target @/ground/target.png --match-histogram --method cms".to_owned(),
    ];
    for line in lines {
        let said = folder.run(&format!("{line} -o out.png --report page --json")).done();
        let page = fs::read_to_string(folder.path("page/index.html")).unwrap();
        let pictures = page.matches("<img alt=\"So far, ").count();
        assert!((2..=25).contains(&pictures), "{pictures} pictures: {line}");
        let energies = said.json()["stats"]["energy"].as_array().unwrap().len();
        let curve = page.split_once("<polyline points=\"").unwrap().1.split_once('"').unwrap().0;
        assert_eq!(curve.split_whitespace().count(), energies, "{line}");
        let needed = |options: &str| {
            let said = folder.run(&format!("{line} -o out.png --dry-run --json {options}")).done();
            said.json()["estimated_memory_bytes"].as_u64().unwrap()
        };
        assert!(needed("") + 80 * 60 * 6 < needed("--report page"), "{line}");
    }
}

#[test]
fn searches_around_holes_are_told_and_no_others() {
    let folder = Folder::new("analogies-holes");
    let value = |c: usize, [y, x]: [u32; 2]| ((y * 31 + x * 17 + c as u32 * 7) % 251) as u8;
    let clear = |[y, x]: [u32; 2]| (20..60).contains(&y) && (30..80).contains(&x);
    write(&folder, "a.png", [200, 220], 3, value);
    write(&folder, "holes.png", [200, 220], 4, |c, at| if c < 3 { value(c, at) } else { u8::from(!clear(at)) * 255 });
    write(&folder, "mask.png", [200, 220], 1, |_, at| if clear(at) { 0 } else { 255 });
    write(&folder, "b.png", [120, 130], 3, value);
    let told = |line: &str| {
        let said = folder.run(&format!("{line} -o c.png --dry-run --json")).done().json();
        said["estimated_memory_bytes"].as_u64().unwrap()
    };
    for line in ["analogy UNDER a.png b.png", "transfer a.png --guide UNDER b.png --method cms"] {
        let whole = line.replace("UNDER", "a.png");
        let least = told(&whole) + (1 << 20);
        assert!(least < told(&format!("{whole} --mask mask.png")), "{line}: an exemplar with holes");
        assert!(least < told(&line.replace("UNDER", "holes.png")), "{line}: what lies under it has holes");
    }
}
