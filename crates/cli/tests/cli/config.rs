//! Options in files.

use std::fs;

use crate::program::Folder;

#[test]
fn saved_options_make_the_same_file() {
    let folder = Folder::new("round-trip");
    let options = "--size 90x60 --tile x --block 20 --tolerance 0.25 --continuation allow --seed 5";
    folder.run(&format!("quilt @/weave.png -o a.png {options} --mask none --save-config c.toml")).done();
    folder.run("quilt @/weave.png -o b.png --config c.toml").done();
    assert_eq!(fs::read(folder.path("a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap());
    // Saved again, it is the same file.
    folder.run("quilt @/weave.png -o b.png --config c.toml --save-config d.toml").done();
    assert_eq!(fs::read(folder.path("c.toml")).unwrap(), fs::read(folder.path("d.toml")).unwrap());
}

#[test]
fn typed_goes_before_the_file_and_the_file_before_defaults() {
    let folder = Folder::new("order");
    fs::write(folder.path("c.toml"), "size = \"40x30\"\nseed = 7\nquiet = true\npaper = true\nthreads = 2\n").unwrap();
    let options = |line: &str| folder.run(&format!("quilt @/stars.png -o a.png --json {line}")).done();
    let plain = options("--config c.toml");
    let object = plain.json();
    assert_eq!((object["options"]["size"].as_str(), object["seed"].as_u64()), (Some("40x30"), Some(7)));
    assert_eq!(object["options"]["continuation"], "allow", "--paper of the file");
    assert!(plain.stderr.is_empty(), "{plain:?}");
    let object = options("--config c.toml --size 20 --seed 8 --stage overlap").json();
    assert_eq!((object["options"]["size"].as_str(), object["seed"].as_u64()), (Some("20x20"), Some(8)));
    assert_eq!(object["options"]["stage"], "overlap", "what was typed goes before --paper of the file");
    assert!(!options("--config c.toml -v").stderr.is_empty(), "typed -v goes before quiet of the file");
    let early = folder.run("--seed 9 --config c.toml quilt @/stars.png -o a.png --json").done().json();
    assert_eq!(early["seed"], 9, "options of every command may stand before the command");
}

/// A saved file tells what every option is, those of other modes too.
#[test]
fn saved_options_of_one_mode_are_none_of_another() {
    let folder = Folder::new("modes");
    for mode in ["transition", "temporal"] {
        let line = format!("video @/fire.png -o a.png --dry-run --mode {mode}");
        folder.run(&format!("{line} --save-config {mode}.toml")).done();
        folder.run(&format!("video @/fire.png -o a.png --dry-run --config {mode}.toml")).done();
        fs::write(folder.path("own.toml"), format!("mode = \"{mode}\"\njumps = 7\nrefine = \"3\"\n")).unwrap();
        folder.run("video @/fire.png -o a.png --dry-run --config own.toml").refused(2, &["does nothing in --mode"]);
    }
}

#[test]
fn paper_survives_saving() {
    let folder = Folder::new("paper");
    folder.run("quilt @/stars.png -o a.png --size 60 --paper --save-config c.toml").done();
    folder.run("quilt @/stars.png -o b.png --config c.toml").done();
    assert_eq!(fs::read(folder.path("a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap());
}

#[test]
fn wrong_files_are_named_with_the_place() {
    let folder = Folder::new("wrong");
    let deep = format!("size = {}1", "[".repeat(100_000));
    let cases: [(&[u8], &[&str]); 11] = [
        (b"seed = 1\nblok = 3\n", &["line 2, column 1", "'blok'"]),
        (b"seed = 1\nseed = 2\n", &["line 2, column 1", "duplicate key"]),
        (b"size = ", &["line 1", "mend it"]),
        (b"tolerance = nan\n", &["NaN"]),
        (b"block = \"large\"\n", &["'large'", "auto"]),
        (b"paper = 3\n", &["line 1, column 9", "true or false"]),
        (b"size = true\n", &["line 1, column 8"]),
        (b"[quilt]\nsize = 3\n", &["'quilt'"]),
        (b"config = \"c.toml\"\n", &["'config'"]),
        (b"seed = \"\xff\"", &["UTF-8"]),
        (deep.as_bytes(), &["line 1"]),
    ];
    for (text, parts) in cases {
        fs::write(folder.path("c.toml"), text).unwrap();
        let said = folder.run("quilt @/stars.png -o a.png --config c.toml").refused(2, parts);
        assert!(text == b"tolerance = nan\n" || said.stderr.contains("'c.toml'"), "{said:?}");
    }
    folder.run("quilt @/stars.png -o a.png --config none.toml").refused(4, &["'none.toml'"]);
    folder.run("quilt @/stars.png -o a.png --config .").refused(2, &["'.'"]);
    assert_eq!(folder.names(), ["c.toml"]);
}
