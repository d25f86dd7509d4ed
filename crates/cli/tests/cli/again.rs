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
        // Names and folders change, the content stays.
        fs::rename(folder.path("in"), folder.path("moved")).unwrap();
        fs::rename(folder.path("moved/it's a weave.png"), folder.path("moved/w.png")).unwrap();
        let again = format!("again-{out}");
        let said = folder.run(&format!("again {out} -o {again} --look-in moved -j 1")).done();
        assert!(said.stderr.contains("the same bytes as"), "{said:?}");
        assert_eq!(fs::read(folder.path(out)).unwrap(), fs::read(folder.path(again)).unwrap());
        folder.run(&format!("again {out} -o no.png")).refused(4, &["is not found", "--look-in"]);
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
