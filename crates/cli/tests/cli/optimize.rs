//! `selvedge optimize` from outside.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, WriteOptions};

use crate::program::Folder;

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let folder = Folder::new("optimize-refused");
    let refused = [
        ("--schedule 1:10", 2, "use a multiple of 4"),
        ("--schedule eight", 2, "'eight' is no schedule; write"),
        ("--schedule 3:8,1:8", 2, "1/3"),
        ("--robust 3", 2, "exponent of 3"),
        ("--iterations 0", 2, "use at least 1"),
        ("--init noise", 2, "'noise' is nothing to start from; write auto, quilt"),
        ("--paper --init quilt", 2, "--init"),
        ("--size 5", 3, "use --size 8 or more"),
        ("--schedule 1:256", 3, "no neighborhood of 256 px"),
        ("--start @/scales-hdr.exr", 3, "scales-hdr.exr"),
        ("--start missing.exr", 4, "'missing.exr'"),
        ("--size 64 --paper --map m.exr", 2, "averaged"),
        ("--fixed @/weave.png", 2, "--fixed has nothing to fix"),
        ("--want @/weave.png --lambda -1 --size 192", 2, "lambda of -1"),
        ("--want @/weave.png --lambda 1e39 --size 192", 2, "use 0 (no wish) to 1000000"),
        ("--lambda 2", 2, "--want"),
        ("--want @/stars.png --size 96 --iterations 1", 3, "the output has 96x96 px"),
        ("--search tree --complete 0.2", 2, "use --complete none, and leave --spread out"),
        ("--complete -1", 2, "completeness of -1"),
        ("--complete much", 2, "'much' is no completeness; write a number"),
    ];
    for (options, exit, named) in refused {
        folder.run(&format!("optimize @/scales.png -o a.png {options}")).refused(exit, &[named]);
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn a_dry_run_tells_what_would_be_done_and_the_options_make_it_again() {
    let folder = Folder::new("optimize-again");
    let line = "optimize @/scales.png --size 48x40 --schedule 2:8,1:8 --iterations 2 --seed 3";
    let dry = folder.run(&format!("{line} -o dry.png --dry-run --json")).done().json();
    let made = folder.run(&format!("{line} -o a.png --json")).done().json();
    assert_eq!(dry["options"], made["options"]);
    assert_eq!(made["stats"]["levels"].as_array().map(Vec::len), Some(2), "{made}");
    let init = made["options"]["init"].as_str().unwrap().to_owned();
    assert_eq!(init, "graphcut");
    let left_open = |options: &str| {
        let run = folder.run(&format!("optimize @/scales.png --size 48x40 -o dry.png --json --dry-run {options}"));
        let options = run.done().json()["options"].clone();
        ["init", "schedule", "complete"].map(|name| options[name].to_string().replace('"', ""))
    };
    let all = "4:8,2:16,2:8,1:32,1:16,1:8";
    assert_eq!(left_open(""), ["graphcut", "1:16,1:8", "none"]);
    assert_eq!(left_open("--complete 0.5"), ["graphcut", "1:16,1:8", "0.5"]);
    assert_eq!(left_open("--schedule 1:32"), ["graphcut", "1:32", "none"]);
    assert_eq!(left_open("--init quilt"), ["quilt", all, "0.2"]);
    assert_eq!(left_open("--init random --search tree"), ["random", all, "none"]);
    folder.run(&format!("{line} -o b.png --init {init}")).done();
    assert_eq!(std::fs::read(folder.path("a.png")).unwrap(), std::fs::read(folder.path("b.png")).unwrap());
    assert!(!folder.path("dry.png").exists());
}

#[test]
fn planes_that_come_along_undecided_are_warned_of() {
    let folder = Folder::new("optimize-along");
    let line = "optimize @/bricks/albedo.png --size 40 --with @/bricks/normal.png -o a.{name}";
    assert!(folder.run(line).done().stderr.contains("give it to --match too"));
    let said = folder.run(&format!("{line} --match @/bricks/normal.png")).done();
    assert!(!said.stderr.contains("--match too"), "{}", said.stderr);
}

#[test]
fn the_report_shows_energies_what_levels_end_with_and_distances_also_of_averages() {
    let folder = Folder::new("optimize-report");
    for (how, pictures) in [("", 3), ("--finish average", 2)] {
        let line = "optimize @/scales.png --size 64x48 --init random --schedule 2:8,1:16,1:8 --iterations 3";
        let said = folder.run(&format!("{line} {how} -o a.png --report page --json")).done().json();
        let page = std::fs::read_to_string(folder.path("page/index.html")).unwrap();
        let energies =
            said["stats"]["levels"].as_array().unwrap().iter().map(|l| l["energy"].as_array().unwrap().len());
        let curve = page.split_once("<polyline points=\"").unwrap().1.split_once('"').unwrap().0;
        assert_eq!(curve.split_whitespace().count(), energies.sum::<usize>(), "{how}");
        for name in ["2:8", "1:16", "1:8", "distances"] {
            assert!(page.contains(&format!("<img alt=\"So far, {name}\"")), "{how} {name}");
        }
        assert_eq!(page.matches("<img ").count(), pictures + 4, "{how}");
    }
    let averaged = "--finish average --schedule 1:8 --iterations 1";
    folder
        .run(&format!("optimize @/scales.png --size 48 -o b.png {averaged} --explain e.png"))
        .refused(2, &["averaged"]);
}

#[test]
fn what_is_wanted_of_float_pictures_is_on_the_curve_of_the_exemplars() {
    let folder = Folder::new("optimize-float");
    // Both lamps are brighter than all that the exemplar has: to it they are the same.
    for (name, lamp) in [("lamp", 100.0), ("sun", 1e6)] {
        let mut light = Grid::try_filled(Domain::open([40, 48]), 3, 0.5_f32).unwrap();
        light.set(0, [3, 3], lamp);
        let (path, plane) = (folder.path(format!("{name}.exr")), Plane::new(Role::Color, Samples::F32(light)));
        selvedge_io::write(&path, &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
        let line = "optimize @/scales-hdr.exr --size 48x40 --schedule 1:8 --iterations 2 --lambda 1";
        folder.run(&format!("{line} --want {name}.exr -o {name}-out.exr --map {name}-map.exr")).done();
    }
    let map = |name: &str| selvedge_io::read_map(folder.path(name), &Default::default()).unwrap().map;
    assert_eq!(map("lamp-map.exr").ids, map("sun-map.exr").ids);
}
