//! Outputs that tile follow the exemplar's lattice, and what was typed stays as it was typed.

use serde_json::Value;

use crate::program::{Folder, Said};

/// The size of a picture, width by height.
fn size(folder: &Folder, name: &str) -> (u64, u64) {
    let json = folder.run(&format!("info {name} --json")).done().json();
    let side = |axis: &str| json["inputs"][0][axis].as_u64().unwrap();
    (side("width"), side("height"))
}

/// The first size in px after some words.
fn named(said: &Said, before: &str) -> (u64, u64) {
    let (_, after) = said.stderr.split_once(before).unwrap_or_else(|| panic!("no {before:?} in {}", said.stderr));
    let word = after.trim_start().split(' ').next().unwrap_or_default();
    let (w, h) = word.split_once('x').unwrap_or_else(|| panic!("{word:?} in {}", said.stderr));
    (w.parse().unwrap(), h.parse().unwrap())
}

#[test]
fn a_typed_size_stays_and_the_nearest_that_closes_is_named() {
    let folder = Folder::new("order-typed");
    for method in ["quilt", "graphcut --refine 0"] {
        let said = folder.run(&format!("{method} @/weave.png -o a.png --size 200x210 --tile xy")).done();
        assert_eq!(size(&folder, "a.png"), (200, 210), "{}", said.stderr);
        let (w, h) = named(&said, "200x210 px wrap;");
        assert!((w, h) != (200, 210) && w.abs_diff(200) < 40 && h.abs_diff(210) < 40, "{w}x{h}");
        let closed = folder.run(&format!("{method} @/weave.png -o b.png --size {w}x{h} --tile xy")).done();
        assert!(!closed.stderr.contains("torn"), "{}", closed.stderr);
    }
    // Along an axis that does not wrap nothing has to close.
    let one = folder.run("quilt @/weave.png -o c.png --size 200x210 --tile x").done();
    assert_eq!((size(&folder, "c.png"), named(&one, "200x210 px wrap;").1), ((200, 210), 210));
    let open = folder.run("quilt @/weave.png -o d.png --size 200x210").done();
    assert!(!open.stderr.contains("torn"), "{}", open.stderr);
}

#[test]
fn a_factor_or_no_size_follows_the_lattice_and_says_so() {
    let folder = Folder::new("order-factor");
    for typed in ["", "--size 2x"] {
        let said = folder.run(&format!("quilt @/weave.png -o a.png {typed} --tile xy")).done();
        let (w, h) = named(&said, "size:");
        assert!(said.stderr.contains("closes the exemplar's lattice, not 384x384"), "{}", said.stderr);
        assert!(w <= 384 && h <= 384 && 340 < w && 340 < h && (w, h) != (384, 384), "{w}x{h}");
        assert_eq!(size(&folder, "a.png"), (w, h));
    }
    let open = folder.run("quilt @/weave.png -o b.png --size 2x").done();
    assert_eq!((size(&folder, "b.png"), open.stderr.contains("lattice")), ((384, 384), false));
}

#[test]
fn what_inspect_suggests_runs_closes_and_loses_nothing() {
    let folder = Folder::new("order-inspect");
    for (name, method) in
        [("weave", "graphcut"), ("grass-grey", "quilt"), ("letters", "graphcut"), ("knit", "graphcut")]
    {
        let command = folder.run(&format!("inspect @/{name}.png --json")).done().json()["stats"]["command"].clone();
        let Value::String(command) = command else { panic!("{command}") };
        let words: Vec<&str> = command.split(' ').collect();
        assert!(words[1] == method && command.contains(".png --size ") && !command.contains("jp"), "{command}");
        assert_eq!(command.contains("--tile xy"), method == "graphcut", "{command}");
        let said = folder.run_words(words[1..].iter().chain(&["--dry-run"])).done();
        assert!(!said.stderr.contains("torn"), "{command}: {}", said.stderr);
    }
}
