//! `again`: the command that a picture carries gives the same bytes, or is refused.

use std::ffi::OsString;
use std::fs;

use crate::program::{Folder, fixtures};

fn copy(folder: &Folder, from: &str, to: impl AsRef<std::path::Path>) {
    fs::copy(format!("{}/{from}", fixtures()), folder.path(to)).unwrap();
}

#[test]
fn the_same_bytes_are_made_from_the_same_files_wherever_they_lie_now() {
    let folder = Folder::new("again");
    fs::create_dir(folder.path("in")).unwrap();
    copy(&folder, "weave.png", "in/it's a weave.png");
    copy(&folder, "bricks/height.png", "in/-height.png");
    for (out, command) in [
        ("a.png", vec!["quilt", "in/it's a weave.png", "--size", "96", "--seed", "7", "--match", "in/-height.png"]),
        (
            "b.exr",
            vec!["graphcut", "in/-height.png", "--size", "40", "--refine", "1", "--depth", "half", "--map", "m.exr"],
        ),
        ("c.png", vec!["apply", "m.exr", "in/-height.png", "--copy"]),
    ] {
        folder.run_words(command.iter().chain(&["-o", out])).done();
        // Folders change, the names stay: the same bytes.
        fs::rename(folder.path("in"), folder.path("moved")).unwrap();
        let again = format!("again-{out}");
        let said = folder.run(&format!("again {out} -o {again} --look-in moved -j 1")).done();
        assert!(said.stderr.contains("the same bytes as"), "{said:?}");
        assert_eq!(fs::read(folder.path(out)).unwrap(), fs::read(folder.path(&again)).unwrap());
        folder.run(&format!("again {out} -o no.png")).refused(4, &["is not found", "--look-in"]);
        // A name that changed stands in the picture, which has the same samples all the same.
        fs::rename(folder.path("moved/it's a weave.png"), folder.path("moved/w.png")).unwrap();
        folder.run(&format!("again {out} -o {again} --look-in moved")).done();
        folder.run(&format!("compare {out} {again}")).done();
        fs::rename(folder.path("moved/w.png"), folder.path("moved/it's a weave.png")).unwrap();
        fs::rename(folder.path("moved"), folder.path("in")).unwrap();
    }
    // Planes of the run need names of their own.
    folder.run("quilt @/bricks/albedo.png -o w-{name} --size 64 --with @/bricks/normal.png").done();
    let look = format!("--look-in {}/bricks", fixtures());
    folder.run(&format!("again w-normal.png -o x.png {look}")).refused(2, &["{stem}"]);
    let said = folder.run(&format!("again w-normal.png -o x-{{name}} {look}")).done();
    assert!(said.stderr.contains("the same bytes as"), "{said:?}");
    folder.run("again @/weave.png -o x.png").refused(3, &["does not say how it was made"]);
}

#[test]
fn another_file_of_the_same_name_is_refused() {
    let folder = Folder::new("again-other");
    copy(&folder, "weave.png", "e.png");
    folder.run("quilt e.png -o out.png --size 64").done();
    copy(&folder, "stars.png", "e.png");
    folder.run("again out.png -o no.png").refused(3, &["e.png", "is not the file that it was", "--look-in"]);
    assert!(!folder.names().contains(&"no.png".to_owned()));
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_or_several_lines_are_found_by_their_content() {
    use std::os::unix::ffi::OsStringExt;
    let folder = Folder::new("again-odd");
    for name in [b"two\nlines.png".to_vec(), b"no\xfftext.png".to_vec(), b"-dash.png".to_vec()] {
        let name = OsString::from_vec(name);
        copy(&folder, "weave.png", &name);
        let given = if name.as_encoded_bytes()[0] == b'-' { OsString::from("./-dash.png") } else { name.clone() };
        let words = [OsString::from("quilt"), given, "-o".into(), "out.png".into(), "--size".into(), "48".into()];
        folder.run_words(words).done();
        let said = folder.run("again out.png -o again.png").done();
        assert!(said.stderr.contains("the same bytes as"), "{said:?}");
        for file in [name, "again.png".into(), "out.png".into()] {
            fs::remove_file(folder.path(file)).unwrap();
        }
    }
}

/// The words of a command that 'info' tells, as a shell would take them.
fn told(folder: &Folder, picture: &str) -> Vec<OsString> {
    let info = folder.run(&format!("info {picture} --json")).done().json();
    let command = info["stats"]["made_by_selvedge"]["command"].as_str().unwrap().to_owned();
    let said = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\0' {command}")]).output().unwrap();
    let words = String::from_utf8(said.stdout).unwrap();
    let words: Vec<OsString> = words.split_terminator('\0').skip(1).map(OsString::from).collect();
    words.into_iter().chain(["-o".into(), "pasted.png".into()]).collect()
}

#[cfg(unix)]
#[test]
fn a_pasted_command_gives_the_same_bytes_or_is_refused() {
    let folder = Folder::new("pasted");
    for name in ["weave.png", "it's a weave.png", "-dash.png"] {
        copy(&folder, "weave.png", name);
        let given = if name.starts_with('-') { format!("./{name}") } else { name.to_owned() };
        folder.run_words(["quilt", &given, "-o", "out.png", "--size", "48"]).done();
        let words = told(&folder, "out.png");
        folder.run_words(&words).done();
        assert_eq!(fs::read(folder.path("pasted.png")).unwrap(), fs::read(folder.path("out.png")).unwrap(), "{name:?}");
        fs::remove_file(folder.path("pasted.png")).unwrap();
        copy(&folder, "stars.png", name);
        folder.run_words(&words).refused(3, &["is not the file that it was", "again"]);
        assert!(!folder.path("pasted.png").exists());
    }
    // Two files that took each other's names.
    copy(&folder, "weave.png", "a.png");
    copy(&folder, "stars.png", "b.png");
    folder.run("quilt a.png b.png -o out.png --size 48").done();
    let words = told(&folder, "out.png");
    folder.run_words(&words).done();
    copy(&folder, "weave.png", "b.png");
    copy(&folder, "stars.png", "a.png");
    folder.run_words(&words).refused(3, &["a.png", "is not the file that it was"]);
    // Names that are no text or several lines are told in other words, by which nothing is there.
    use std::os::unix::ffi::OsStringExt;
    for name in [b"no\xfftext.png".to_vec(), b"two\nlines.png".to_vec()] {
        let name = OsString::from_vec(name);
        copy(&folder, "weave.png", &name);
        let words = [OsString::from("quilt"), name, "-o".into(), "out.png".into(), "--size".into(), "48".into()];
        folder.run_words(words).done();
        folder.run_words(told(&folder, "out.png")).refused(4, &["not found"]);
    }
}

#[test]
fn inputs_of_one_name_are_never_taken_for_each_other_in_silence() {
    let folder = Folder::new("again-twice");
    for (file, to) in [("weave.png", "a"), ("stars.png", "b")] {
        fs::create_dir(folder.path(to)).unwrap();
        copy(&folder, file, format!("{to}/x.png"));
    }
    folder.run("quilt a/x.png b/x.png -o out.png --size 48").done();
    let said = folder.run("again out.png -o again.png --look-in a b").done();
    assert!(said.stderr.contains("the same bytes as"), "{said:?}");
    // Pasted, both are the one that lies here.
    copy(&folder, "weave.png", "x.png");
    folder.run_words(told(&folder, "out.png")).refused(3, &["mark", "selvedge again"]);
    fs::remove_file(folder.path("x.png")).unwrap();
    // What was typed in another order than it was read in, or with names that are others now.
    fs::rename(folder.path("b/x.png"), folder.path("b/y.png")).unwrap();
    folder.run("again out.png -o no.png --look-in a b").refused(3, &["x.png", "selvedge info"]);
    assert!(!folder.path("no.png").exists());
    // Of another format no bytes were promised.
    let said = folder.run("again out.png -o other.tif --look-in a b").done();
    assert!(said.stderr.contains("had the name 'x.png'"), "{said:?}");
}

/// A picture of somebody else that carries a command.
fn carries(folder: &Folder, command: &str) {
    use selvedge_core::{Domain, Grid, Plane, Role, Samples};
    use selvedge_io::{Fingerprint, Metadata, Provenance, WriteOptions};
    let input = fs::read(folder.path("in.png")).unwrap();
    let input = Fingerprint { name: "in.png".into(), blake3: blake3::hash(&input).to_hex().to_string() };
    let version = env!("CARGO_PKG_VERSION").into();
    let made = Provenance { version, seed: 0, inputs: vec![input], command: command.into() };
    let metadata = Metadata { provenance: Some(made), ..Metadata::default() };
    let samples = Samples::U8(Grid::try_filled(Domain::open([2, 2]), 1, 0).unwrap());
    let plane = Plane::new(Role::Color, samples);
    selvedge_io::write(folder.path("hostile.png"), &plane, &metadata, &WriteOptions::default()).unwrap();
}

#[test]
fn a_carried_command_names_no_file_to_write_and_no_setting_of_the_run() {
    let folder = Folder::new("again-hostile");
    copy(&folder, "weave.png", "in.png");
    fs::write(folder.path("victim.png"), "precious").unwrap();
    for option in [
        "--explain victim.png",
        "--explain=victim.png",
        "--map victim.exr",
        "--map=victim.exr",
        "--report victim",
        "--config victim.png",
        "--save-config victim.png",
        "-o victim.png",
        "-ovictim.png",
        "--output victim.png",
        "--max-memory 1GiB",
        "-j 500",
        "--threads 500",
        "--sweep seed=1,2",
        "--sheet victim.png",
        "--each",
        "-q",
        "--dry-run",
        "--pretend",
        "--expect 00000000",
        "--json",
        "--paper",
        "--",
        "--size=64",
    ] {
        carries(&folder, &format!("selvedge quilt in.png --size 64 {option}"));
        let (before, word) = (folder.files(), option.split(' ').next().unwrap());
        folder.run("again hostile.png -o a.png").refused(3, &["carries the option", word]);
        assert_eq!(folder.files(), before, "{option}");
    }
    carries(&folder, "selvedge graphcut in.png --size 64 --rotate -30,30 --seed 3");
    folder.run("again hostile.png -o a.png").done();
}

#[test]
fn an_input_whose_name_is_a_value_stands_only_where_files_do() {
    let folder = Folder::new("again-value");
    fs::create_dir(folder.path("out")).unwrap();
    copy(&folder, "weave.png", "difference");
    copy(&folder, "stars.png", "48");
    folder.run("quilt difference 48 --size 48 --seam difference -o out/a.png").refused(2, &["--seam"]);
    folder.run("graphcut difference 48 --size 48 --seam difference -o out/a.png").done();
    let said = folder.run("again out/a.png -o b.png").done();
    assert!(said.stderr.contains("the same bytes as"), "{said:?}");
}
