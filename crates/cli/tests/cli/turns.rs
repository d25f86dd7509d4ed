//! Several runs in one: seeds, exemplars, names, and a sheet of all.

use std::fs;

use crate::program::Folder;

#[test]
fn every_seed_makes_what_it_makes_alone() {
    let folder = Folder::new("seeds");
    let line = "quilt @/weave.png --size 40";
    let said = folder.run(&format!("{line} --seed 1..3 -o o-{{seed}}.png --map m-{{n}}.exr --sheet sheet.png")).done();
    assert_eq!(said.stderr.matches("40x40 px").count(), 3, "{said:?}");
    for (n, seed) in [(1, 1), (2, 2), (3, 3)] {
        folder.run(&format!("{line} --seed {seed} -o alone.png --map alone.exr")).done();
        let same =
            |one: &str, other: &str| fs::read(folder.path(one)).unwrap() == fs::read(folder.path(other)).unwrap();
        assert!(same("alone.png", &format!("o-{seed}.png")) && same("alone.exr", &format!("m-{n}.exr")), "{seed}");
    }
    // Two by two, margins of 8, and the numbers below.
    assert_eq!(folder.run("info sheet.png --json").done().json()["inputs"][0]["width"], 104);
}

#[test]
fn every_exemplar_is_woven_alone_with_its_planes() {
    let folder = Folder::new("each");
    let line = "quilt @/bricks/albedo.png @/cobbles.png --each --mask none --mask none --size 48 -o {stem}.png --json";
    let object = folder.run(line).done().json();
    assert_eq!(object["runs"].as_array().unwrap().len(), 2);
    assert_eq!([0, 1].map(|i| object["runs"][i]["inputs"].as_array().unwrap().len()), [1, 1], "{object}");
    assert_eq!(
        [0, 1].map(|i| object["outputs"][i]["path"].as_str().unwrap().to_owned()),
        ["albedo.png", "cobbles.png"]
    );
    folder.run("quilt @/cobbles.png --mask none --size 48 -o alone.png").done();
    assert!(fs::read(folder.path("alone.png")).unwrap() == fs::read(folder.path("cobbles.png")).unwrap());
}

#[test]
fn several_runs_are_written_together_or_not_at_all() {
    let folder = Folder::new("turns-refused");
    let refused = [
        ("--seed 1..2 -o o.png", "2 runs would write this name"),
        ("--seed 1..2 -o -", "2 runs would write this name"),
        ("--seed 2..1 -o o-{n}.png", "'2..1' is no seed"),
        ("--seed 1 -o o-{n}.png --preview p.png", "it does not; add --tile xy"),
        ("--seed 1..2 -o o-{n}.png --sheet s.exr", "exr cannot hold u8 samples"),
        ("--seed 1..2 -o o-{n}.png --sheet nowhere.webm", "webm"),
        ("--tile xy -o o.png --preview p.hdr", "hdr cannot hold u8 samples"),
        ("--seed 1..2 -o o-{n}.png --mask -", "standard input': can be read once, and 2 runs would read it"),
    ];
    for (words, what) in refused {
        folder.run(&format!("quilt @/weave.png --size 40 {words}")).refused(2, &[what]);
    }
    folder
        .run("quilt @/cobbles-hole.png --tile x -o o.png --preview p.jpg")
        .refused(3, &["3 channels and alpha", "p.jpg"]);
    let wide = "quilt @/weave.png --tile x --size 40x9000 -o o.png --preview p.webp --dry-run";
    folder.run(&wide.replace("40x9000", "9000x40")).refused(3, &["18000x40 px", "16383"]);
    // The second exemplar is too small for the block, or is not there: the first one is not woven.
    let line = "quilt @/cobbles.png @/stars.png --each -o {n}.png --size 200 --block 150";
    folder.run(line).refused(3, &["stars.png"]);
    for line in [line.to_owned(), line.replace("@/stars.png", "none.png")] {
        let said = folder.run(&format!("{line} --progress json"));
        assert!(!said.stderr.contains("stage") && matches!(said.exit, Some(3 | 4)), "{said:?}");
    }
    // A name of the second run is an input of the first one.
    fs::copy(format!("{}/weave.png", crate::program::fixtures()), folder.path("2.png")).unwrap();
    let said = folder.run("quilt 2.png --size 40 --seed 1..2 -o {n}.png --progress json");
    said.refused(4, &["2.png", "is the same file as the input"]);
    assert_eq!(folder.names(), ["2.png"]);
    folder.run("quilt @/weave.png --size 40 --seed 1..2 -o {n}.png --dry-run").done();
    assert_eq!(folder.names(), ["2.png"]);
}

#[test]
fn no_run_writes_over_another_or_over_the_sheet() {
    let folder = Folder::new("turns-apart");
    for line in ["-o o-{seed}.png --seed 1..2 --sheet ./o-1.png", "-o ./{n}.png --explain {seed}.png --seed 2,1"] {
        folder.run(&format!("quilt @/weave.png --size 40 {line}")).refused(2, &["would write this name"]);
        assert_eq!(folder.names(), Vec::<String>::new(), "{line}");
    }
}

#[test]
fn levels_that_were_asked_for_are_carried() {
    let folder = Folder::new("levels");
    folder.run("graphcut @/bricks/albedo.png --size 40 --refine 0 -o auto.png").done();
    folder.run("graphcut @/bricks/albedo.png --size 40 --refine 0 -o one.png --levels 1").done();
    let made = |name: &str| String::from_utf8(folder.run(&format!("info {name}")).done().stdout).unwrap();
    assert!(made("one.png").contains("--levels 1") && !made("auto.png").contains("--levels"));
}

#[test]
fn a_tile_is_shown_beside_itself() {
    let folder = Folder::new("preview");
    folder.run("quilt @/weave.png --size 50x40 --tile x -o o.png --preview p.png").done();
    let info = folder.run("info p.png --json").done().json();
    assert_eq!(["width", "height"].map(|side| info["inputs"][0][side].as_u64()), [Some(100), Some(40)]);
}

#[test]
fn light_is_exposed_where_integers_are_made_of_it() {
    let folder = Folder::new("exposure");
    let line = "quilt @/scales-hdr.exr --size 40 --depth u8";
    folder.run(&format!("{line} -o o.png")).done();
    folder.run(&format!("{line} -o d.png --exposure -2")).done();
    let light = |name: &str| {
        let picture = selvedge_io::read(folder.path(name), &selvedge_io::ReadOptions::default()).unwrap().plane;
        (0..picture.domain().len()).map(|i| picture.samples.value(1, i)).sum::<f64>()
    };
    assert!(light("d.png") < 0.7 * light("o.png") && 0.0 < light("d.png"));
    let info = folder.run("info d.png").done();
    assert!(String::from_utf8_lossy(&info.stdout).contains("--exposure -2"), "{info:?}");
    folder.run("again d.png -o e.png --look-in @").done();
    assert!(fs::read(folder.path("d.png")).unwrap() == fs::read(folder.path("e.png")).unwrap());
    folder.run("quilt @/weave.png -o o.png --exposure 1").refused(2, &["floats that become integers"]);
    folder.run(&format!("{line} -o o.png --exposure 99")).refused(2, &["'99' is no exposure"]);
}

#[test]
fn options_that_do_nothing_are_not_listed_and_told() {
    let folder = Folder::new("idle");
    let help = |command: &str| String::from_utf8(folder.run(&format!("{command} --help")).done().stdout).unwrap();
    assert!(help("quilt").contains("--seed") && help("apply").contains("--no-clobber"));
    for option in ["--seed", "--keep-partial", "--dry-run", "--no-clobber", "--threads"] {
        assert!(!help("info").contains(option), "{option}");
    }
    let said = folder.run("info @/weave.png --keep-partial").done();
    assert_eq!(said.stderr, "note: --keep-partial does nothing for this command\n");
    folder.run("man pages").done();
    let page = fs::read_to_string(folder.path("pages/selvedge-quilt.1")).unwrap();
    let synopsis = page.split(".SH SYNOPSIS").nth(1).unwrap().split(".SH").next().unwrap().to_owned();
    let at = |word: &str| synopsis.find(word).unwrap_or_else(|| panic!("no {word} in {synopsis}"));
    assert!(at("EXEMPLAR") < at("OUT") && at("OUT") < at("OPTIONS") && !synopsis.contains("seed"), "{synopsis}");
}
