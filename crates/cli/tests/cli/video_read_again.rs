//! Clips that are too large to be held are read again.

use std::collections::BTreeMap;
use std::fs;

use selvedge_io::clip::{ClipOptions, ClipReader, ClipWriteOptions, ClipWriter};

use crate::program::{Folder, fixtures};

/// What no run that holds the clip is content with, and one that reads it again is.
const LITTLE: &str = "--max-memory 40MiB --verbose --json";
const AGAIN: &str = "the clip is read again";

/// The generated fire of the fixtures under another name, in whichever container that is.
fn fire(folder: &Folder, name: &str) {
    let mut reader = ClipReader::open(fixtures() + "/fire.png", &ClipOptions::default()).unwrap();
    let (info, options) = (reader.info().clone(), ClipWriteOptions::default());
    let mut writer = ClipWriter::create(folder.path(name), info.frames, info.metadata, options).unwrap();
    while let Some(frame) = reader.next().unwrap() {
        writer.frame(&frame).unwrap();
    }
    writer.finish().unwrap();
}

/// All files that a run left in `out`, and what it counted.
fn made(folder: &Folder, line: &str, again: bool) -> (BTreeMap<String, Vec<u8>>, serde_json::Value) {
    fs::create_dir_all(folder.path("out")).unwrap();
    let said = folder.run(&format!("video {line} {}", if again { LITTLE } else { "--verbose --json" })).done();
    assert_eq!(said.stderr.contains(AGAIN), again, "{}", said.stderr);
    let files = fs::read_dir(folder.path("out")).unwrap().map(|entry| entry.unwrap().path());
    let files = files.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap()));
    let files = files.collect();
    fs::remove_dir_all(folder.path("out")).unwrap();
    let json = said.json();
    (files, serde_json::json!([json["stats"], json["options"], json["inputs"], json["outputs"]]))
}

#[test]
fn clips_that_are_read_again_give_the_same_files() {
    let folder = Folder::new("video-again");
    for name in ["a.##.png", "b.##.png", "c.gif", "d.y4m"] {
        fire(&folder, name);
    }
    for line in [
        "a.##.png --mode transition -o out/{name}.##.png --with b.##.png --surface out/s.png --repeat 2 --closing-frame",
        "a.##.png --mode transition -o out/a.png --levels 2 --window 8 --range 1-36",
        "c.gif --mode transition -o out/c.####.png --jump 30,4",
        "d.y4m --mode transition -o out/d.y4m --frames 50 --play loop",
    ] {
        let (held, again) = (made(&folder, line, false), made(&folder, line, true));
        assert!(!held.0.is_empty() && held.1 == again.1, "{line}: {} {}", held.1, again.1);
        assert!(held.0 == again.0, "{line}");
    }
    // A surface that is given is only measured.
    folder.run("video a.##.png --jump 30,4 -o out.##.png --surface s.png --quiet").done();
    let line = "a.##.png --mode transition -o out/a.##.png --jump 30,4 --surface-from s.png";
    assert!(made(&folder, line, false) == made(&folder, line, true));
}

#[test]
fn what_needs_the_whole_clip_says_so() {
    let folder = Folder::new("video-again-not");
    fire(&folder, "a.##.png");
    for more in ["--preview see.png", "--map m.####.exr", "--feather 2", "--frames 50 --play random"] {
        folder.run(&format!("video a.##.png -o out.##.png {more} --max-memory 40MiB")).refused(6, &["memory"]);
    }
    // A frame that is damaged is named, and nothing is left.
    fs::write(folder.path("a.20.png"), &fs::read(folder.path("a.20.png")).unwrap()[..900]).unwrap();
    folder.run("video a.##.png --mode transition -o out.##.png --max-memory 40MiB").refused(3, &["a.20.png"]);
    assert_eq!(folder.names().len(), 41);
}

/// What a stream brings is kept in a file where it is much, and that is gone afterwards.
#[test]
fn streams_are_kept_beside_the_output() {
    let folder = Folder::new("video-stream");
    fire(&folder, "fire.##.png");
    folder.run("video fire.##.png -o long.y4m --jump 30,11 --repeat 60 --quiet").done();
    let loops = |stream: &str, name: &str, more: &str| {
        let line = format!("video - -o {name} --mode transition --verbose {more}");
        let mut command = folder.command();
        command.args(line.split_whitespace()).stdin(fs::File::open(folder.path(stream)).unwrap());
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains(AGAIN) != more.is_empty(), "{said}");
        output.stdout
    };
    loops("long.y4m", "a.y4m", "");
    // From a stream to a stream.
    assert!(loops("long.y4m", "-", "") == fs::read(folder.path("a.y4m")).unwrap());
    loops("long.y4m", "b.y4m", "--max-memory 72MiB");
    assert!(fs::read(folder.path("a.y4m")).unwrap() == fs::read(folder.path("b.y4m")).unwrap());
    assert_eq!(folder.names().iter().filter(|name| !name.starts_with("fire")).count(), 3, "{:?}", folder.names());
}

/// Systems let a process open some hundred files, and a loop may have more frames.
#[cfg(unix)]
#[test]
fn loops_have_more_frames_than_files_may_be_open() {
    let folder = Folder::new("video-many");
    let program = env!("CARGO_BIN_EXE_selvedge");
    for (held, more) in [("", ""), ("--max-memory 40MiB", "--mode transition")] {
        let line = format!(
            "ulimit -n 200 && '{program}' video '{}/fire.png' -o 'out{}.####.png' --jump 30,11 --repeat 15 --quiet {held} {more}",
            fixtures(),
            held.len()
        );
        let said = std::process::Command::new("sh").args(["-c", &line]).current_dir(folder.path("")).output().unwrap();
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    }
    assert_eq!(folder.names().len(), 2 * 301);
}
