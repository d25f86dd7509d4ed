//! What `synthesize` keeps, and that its command makes it again.

use std::fs;

use crate::graphcut::{map, samples};
use crate::program::Folder;

/// The command that a picture tells, of an exemplar among the fixtures.
fn told(folder: &Folder, picture: &str) -> String {
    let info = String::from_utf8(folder.run(&format!("info {picture} --json")).done().stdout).unwrap();
    let start = info.find("selvedge ").expect("a picture tells its command");
    let command: String = info[start + 9..].chars().take_while(|c| *c != '"').collect();
    assert!(command.starts_with("graphcut "), "{command}");
    command.replacen("graphcut ", "graphcut @/", 1)
}

#[test]
fn the_kept_candidate_is_made_again_by_its_own_command() {
    let folder = Folder::new("synthesize");
    folder.run("synthesize @/weave.png -o a.png --map a.exr --size 80x64 --tile x --mend none --seed 5 -j 1").done();
    folder.run("synth @/weave.png -o b.png --map b.exr --size 80x64 --tile x --mend none --seed 5 -j 3").done();
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!((read("a.png"), read("a.exr")), (read("b.png"), read("b.exr")));
    let command = told(&folder, "a.png");
    folder.run(&format!("{command} -o c.png --map c.exr")).done();
    assert_eq!((read("a.png"), read("a.exr")), (read("c.png"), read("c.exr")), "{command}");
}

#[test]
fn what_is_repaired_is_made_again_by_the_command_that_it_tells() {
    let folder = Folder::new("synthesize-repaired");
    folder.run("synthesize @/cobbles.png -o a.png --size 128 --effort 1 --repair --radius 3").done();
    let command = told(&folder, "a.png");
    assert!(command.contains("--repair --radius 3"), "{command}");
    folder.run(&format!("{command} -o b.png")).done();
    assert_eq!(fs::read(folder.path("a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap(), "{command}");
    folder.run("synthesize @/cobbles.png -o c.png --radius 3").refused(2, &["--radius", "--repair"]);
}

#[test]
fn seams_are_hidden_of_what_is_kept_and_its_command_says_so() {
    let folder = Folder::new("synthesize-blended");
    let line = "synthesize @/cobbles.png --size 230x210 --effort 2 --mend none --ignore-light 0.5";
    folder.run(&format!("{line} -o sharp.png --map sharp.exr")).done();
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    for blend in ["--feather 2.0", "--spline 2", "--spline auto", "--fuse"] {
        folder.run(&format!("{line} {blend} -o soft.png --map soft.exr")).done();
        let [sharp, soft] = ["sharp.exr", "soft.exr"].map(|name| map(&folder, name).map.ids);
        assert!(sharp == soft && samples(&folder, "sharp.png") != samples(&folder, "soft.png"), "{blend}");
        let command = told(&folder, "soft.png");
        assert!(command.contains(blend) && command.contains("--ignore-light 0.5"), "{command}");
        folder.run(&format!("{command} -o again.png")).done();
        assert_eq!(read("soft.png"), read("again.png"), "{command}");
    }
    folder.run("synthesize @/cobbles.png -o a.png --feather 1 --spline 2").refused(2, &["--feather", "--spline"]);
}

#[test]
fn all_candidates_are_told_and_one_run_scores_nothing() {
    let folder = Folder::new("synthesize-json");
    let said = folder.run("synthesize @/weave.png -o a.png --size 64 --json").done();
    let text = String::from_utf8(said.stdout).unwrap();
    assert!(1 < text.matches("\"preference\"").count() && text.contains("\"seam_energy\""), "{text}");
    assert!(said.stderr.contains("the best of"), "{}", said.stderr);
    let one = folder.run("synthesize @/weave.png -o b.png --size 64 --effort 1").done();
    assert!(one.stderr.contains("by graphcut") && !one.stderr.contains("the best of"), "{}", one.stderr);
    folder.run("synthesize @/weave.png -o b.png --effort 0").refused(2, &["0"]);
}

#[test]
fn candidates_stand_on_the_page_and_below_the_explanation() {
    let folder = Folder::new("synthesize-page");
    folder.run("synthesize @/weave.png -o a.png --size 64 --mend none --explain a-e.png --report a").done();
    folder.run("synthesize @/weave.png -o b.png --size 64 --explain b-e.png --report b --effort 1").done();
    let page = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    // Three drafts, one finished.
    let [a, b] = ["a/index.html", "b/index.html"].map(page);
    assert_eq!([&a, &b].map(|page| page.matches("preference ").count()), [4, 0]);
    assert_eq!(a.matches(", kept: preference").count(), 1);
    let height = |name: &str| u32::from_be_bytes(std::fs::read(folder.path(name)).unwrap()[20..24].try_into().unwrap());
    assert!(height("b-e.png") + 64 < height("a-e.png"));
}

#[test]
fn seams_of_what_is_lit_unevenly_are_splined_unless_said_otherwise() {
    let folder = Folder::new("synthesize-light");
    let line = "--size 200x160 --effort 1 --seed 2";
    let say = |of: &str, more: &str, out: &str| {
        folder.run(&format!("synthesize @/{of}.png {line} {more} -o {out}.png --map {out}.exr")).done().stderr
    };
    let said = say("plaster", "", "light");
    assert!(said.contains("its light is uneven"), "{said}");
    assert!(!say("plaster", "--spline 0", "exact").contains("uneven"));
    say("plaster", "--spline auto", "asked");
    let [light, exact, asked] = ["light.png", "exact.png", "asked.png"].map(|name| samples(&folder, name));
    assert!(light == asked && light != exact);
    assert_eq!(map(&folder, "light.exr").map.ids, map(&folder, "exact.exr").map.ids);
    let command = told(&folder, "light.png");
    folder.run(&format!("{command} -o again.png")).done();
    assert!(command.contains("--spline auto") && samples(&folder, "again.png") == light, "{command}");
    // An even one is copied, and so is a material.
    assert!(!say("cobbles", "", "even").contains("uneven") && !told(&folder, "even.png").contains("spline"));
    let said =
        folder.run(&format!("synthesize @/plaster.png {line} --with @/planks.png --role scalar -o with-{{name}}"));
    assert!(!said.done().stderr.contains("uneven"));
}

#[test]
fn what_is_mended_is_made_again_by_this_command() {
    let folder = Folder::new("synthesize-mended");
    let line = "@/knit.png --size 200 --effort 2 --seed 4";
    let said = folder.run(&format!("synthesize {line} -o a.png --map a.exr --report a --json")).done();
    assert!(said.stderr.contains("its seams mended"), "{}", said.stderr);
    let told = String::from_utf8(said.stdout).unwrap();
    assert!(told.contains(r#""method":"optimize""#) && told.contains(r#""mends":2"#), "{told}");
    let info = String::from_utf8(folder.run("info a.png --json").done().stdout).unwrap();
    let command = "selvedge synthesize knit.png --size 200x200 --effort 2 --mend auto --seed 4";
    assert!(info.contains(command), "{info}");
    let page = fs::read_to_string(folder.path("a/index.html")).unwrap();
    assert!(page.contains("by optimize, which mends 3,"), "{page}");
    // It is the graph cut that stands without it, but for its seams.
    folder.run(&format!("synthesize {line} --mend none -o b.png --map b.exr")).done();
    folder
        .run("optimize @/knit.png --start b.exr --schedule 1:16,1:8 --complete none -o c.png --map c.exr --seed 4")
        .done();
    assert_eq!(map(&folder, "a.exr").map.ids, map(&folder, "c.exr").map.ids);
    // What comes along and does not decide is not mended.
    folder.run(&format!("synthesize {line} --with @/letters.png --role scalar -o d-{{name}} --map d.exr")).done();
    assert_eq!(map(&folder, "b.exr").map.ids, map(&folder, "d.exr").map.ids);
}
