//! Standard input, standard output, and who listens.

use std::fs;
use std::io::{Read as _, Write as _};
use std::process::Stdio;

use crate::program::{Folder, Said, fixtures};

#[test]
fn pictures_go_through_streams() {
    let folder = Folder::new("streams");
    let bytes = fs::read(fixtures() + "/weave.png").unwrap();
    let piped = |line: &str| {
        let mut child =
            folder.command().args(line.split(' ')).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(&bytes).unwrap();
        Said::from(child.wait_with_output().unwrap()).done().stdout
    };
    folder.run("quilt @/weave.png -o file.png --size 50 --map map.exr").done();
    let picture = |bytes: &[u8]| selvedge_io::decode(bytes, "a", &Default::default()).unwrap();
    let file = picture(&fs::read(folder.path("file.png")).unwrap());
    let stream = picture(&piped("quilt - -o - --size 50"));
    assert_eq!((&stream.plane, stream.format), (&file.plane, selvedge_io::Format::Png));
    let tiff = picture(&piped("quilt - -o - --size 50 --format tiff"));
    assert_eq!((&tiff.plane, tiff.format), (&file.plane, selvedge_io::Format::Tiff));
    assert_eq!(picture(&piped("apply map.exr - -o -")).plane, file.plane);
    assert!(String::from_utf8(piped("info -")).unwrap().contains("192x192 px"));
    folder.run("quilt - -o a.png").refused(3, &["'-'", "empty"]);
    folder.run("quilt @/weave.png -o - --json").refused(2, &["--json", "standard output"]);
    folder.run("quilt @/weave.png -o - --map -").refused(2, &["'-'", "two outputs"]);
}

#[cfg(unix)]
#[test]
fn pipes_with_a_name_are_read_as_streams() {
    let folder = Folder::new("pipes");
    assert!(std::process::Command::new("mkfifo").arg(folder.path("p")).status().unwrap().success());
    let shell = |script: &str| {
        let script = script.replace('%', env!("CARGO_BIN_EXE_selvedge")).replace('@', &fixtures());
        let mut sh = std::process::Command::new("sh");
        Said::from(sh.args(["-c", &script]).current_dir(folder.path("")).output().unwrap())
    };
    shell("% quilt @/weave.png -o file.png --size 50 --block 20").done();
    shell("cat @/weave.png > p & % quilt p -o pipe.png --size 50 --block 20").done();
    shell("cat @/weave.png | % quilt /dev/stdin -o stdin.png --size 50 --block 20").done();
    shell("% quilt /dev/stdin -o again.png --size 50 --block 20 < @/weave.png").done();
    for name in ["pipe.png", "stdin.png", "again.png"] {
        folder.run(&format!("compare file.png {name}")).done();
    }
    folder.run("compare p p").refused(2, &["'p'", "a pipe that is named twice", "as files"]);
    folder.run("compare p ./p").refused(2, &["'./p'", "named twice"]);
    if std::path::Path::new("/dev/zero").exists() {
        folder.run("info /dev/zero").refused(4, &["'/dev/zero'", "no regular file"]);
    }
}

#[test]
fn with_json_there_is_exactly_one_object() {
    let folder = Folder::new("json");
    folder.run("quilt @/weave.png -o w.png --size 40 --map map.exr").done();
    for line in [
        "quilt @/weave.png -o a.png --size 40 --map m.exr -v --progress json",
        "apply map.exr @/weave.png @/scales.png -o out-{stem}.png",
        "info w.png",
        "info map.exr",
        "inspect @/weave.png",
        "compare @/weave.png @/weave.png",
        "completions bash",
        "man .",
    ] {
        let object = folder.run(&format!("{line} --json")).done().json();
        let command = line.split(' ').next().unwrap();
        assert_eq!(object["command"], command);
        assert_eq!(object["version"], env!("CARGO_PKG_VERSION"));
        for key in ["seed", "options", "inputs", "outputs", "seconds", "threads", "peak_memory_bytes", "stats"] {
            assert!(object.get(key).is_some(), "{line}: no {key}");
        }
        assert!(0.0 < object["seconds"]["total"].as_f64().unwrap());
        for output in object["outputs"].as_array().unwrap() {
            let path = folder.path(output["path"].as_str().unwrap());
            let hash = blake3::hash(&fs::read(path).unwrap()).to_hex();
            assert_eq!(output["blake3"], hash.as_str(), "{line}");
        }
    }
    // Even where the wish stands in a file of options.
    fs::write(folder.path("c.toml"), "json = true\n").unwrap();
    folder.run("quilt none.png -o a.png --config c.toml").refused(4, &["'none.png'"]).json();
}

#[test]
fn progress_is_one_object_a_line_when_asked_for() {
    let folder = Folder::new("progress");
    let said = folder.run("quilt @/weave.png -o a.png --size 80 --progress json -q").done();
    let steps: Vec<serde_json::Value> = said.stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(!steps.is_empty());
    // The last of those that know how far they are is at its end.
    let last = steps.iter().rfind(|step| step["of"] != 0).unwrap();
    assert_eq!(last["done"], last["of"], "{steps:?}");
    // What cannot tell how far it is says what it is.
    let line = "quilt @/weave.png -o a.png --size 80 --map m.exr --progress json -q";
    for (line, stage) in [
        (format!("{line} --spline 2"), "spline"),
        (format!("{line} --feather 1"), "feather"),
        ("apply m.exr @/weave.png -o b.png --fuse --progress json -q".to_owned(), "fuse"),
    ] {
        let said = folder.run(&line).done();
        assert!(said.stderr.contains(&format!("\"stage\":\"{stage}\"")), "{said:?}");
    }
    let quiet = folder.run("quilt @/weave.png -o a.png --size 80 -q").done();
    assert!(quiet.stderr.is_empty() && quiet.stdout.is_empty(), "{quiet:?}");
}

#[test]
fn a_reader_that_leaves_early_misses_pictures_alone() {
    let folder = Folder::new("pipe");
    for (line, exit) in [
        ("completions bash", 0),
        ("info @/weave.png --json", 0),
        // A part of a picture is of no use.
        ("quilt @/weave.png -o - --size 600 --block 40", 4),
        ("quilt @/weave.png -o a.png --map - --size 600 --block 40", 4),
    ] {
        let words = line.split(' ').map(|word| word.replace('@', &fixtures()));
        let mut child = folder.command().args(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(exit), "{line}: {stderr}");
        assert_eq!(stderr.contains("error: 'standard output': its reader has left; "), exit == 4, "{stderr}");
        assert_eq!(folder.names(), Vec::<String>::new(), "{line}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_for_a_closed_standard_output_is_refused() {
    let folder = Folder::new("closed");
    let run = |line: &str, to: &str| {
        let line = line.replace('@', &fixtures());
        let script = format!("exec {} {line} {to}", env!("CARGO_BIN_EXE_selvedge"));
        Said::from(
            std::process::Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).output().unwrap(),
        )
    };
    // This would take minutes if it were begun.
    let long = "quilt @/stars.png --size 9000 --block 8 --max-memory 100GiB";
    let parts = ["'standard output': is closed", "redirect it"];
    run(&format!("{long} -o -"), ">&-").refused(4, &parts);
    run(&format!("{long} -o a.png --map -"), ">&-").refused(4, &parts);
    let short = "quilt @/stars.png --size 30 --block 9";
    run(&format!("{short} -o -"), ">/dev/null").done();
    run(&format!("{short} -o a.png"), ">&-").done();
    run(&format!("{short} -o -"), "<&- 2>&- >b.png").done();
    assert_eq!(
        folder.files()["a.png".as_ref() as &std::path::Path].len(),
        fs::read(folder.path("b.png")).unwrap().len()
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_no_space() {
    let folder = Folder::new("full");
    for line in ["quilt @/stars.png -o - --size 16", "info @/stars.png", "completions zsh"] {
        let words = line.split(' ').map(|word| word.replace('@', &fixtures()));
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let said = Said::from(folder.command().args(words).stdout(full).stderr(Stdio::piped()).output().unwrap());
        assert_eq!(said.exit, Some(5), "{line}: {said:?}");
        assert!(said.stderr.lines().last().unwrap().starts_with("error: 'standard output': "), "{said:?}");
    }
}
