//! Broken, odd and hostile files: a picture, or one line that says what is wrong.

use std::fs;
use std::path::{Path, PathBuf};

use selvedge_core::Limits;
use selvedge_io::{ErrorKind, NonFinite, ReadOptions, probe, read};

/// All files of the folders `bad` in the developers' data, or nothing, said aloud, without them.
fn data() -> Vec<PathBuf> {
    let Some(root) = std::env::var_os("SELVEDGE_DATA") else {
        eprintln!("SKIPPED: SELVEDGE_DATA is not set");
        return Vec::new();
    };
    let mut files = Vec::new();
    for kind in ["free/bad", "research/bad"] {
        let folder = fs::read_dir(Path::new(&root).join(kind));
        files.extend(folder.into_iter().flatten().map(|e| e.unwrap().path()));
    }
    files.sort();
    assert!(50 < files.len(), "SELVEDGE_DATA names no such folder");
    files
}

fn name(path: &Path) -> &str {
    path.file_name().unwrap().to_str().unwrap()
}

#[test]
fn good_files_load_and_bad_ones_say_why_in_one_line() {
    let options = ReadOptions::default();
    for path in data() {
        let probed = probe(&path, &options);
        match read(&path, &options) {
            Ok(picture) => {
                let plane = &picture.plane;
                eprintln!("{:50} {:?} {:?}", name(&path), plane.domain().shape, picture.warnings);
                let info = probed.unwrap();
                assert_eq!([info.height, info.width], plane.domain().shape, "{path:?}");
                assert_eq!(info.depth, plane.samples.depth(), "{path:?}");
            }
            Err(e) => {
                eprintln!("{:50} {:?} {e}", name(&path), e.kind());
                assert!(!name(&path).starts_with("ok-"), "{e}");
                assert!(matches!(e.kind(), ErrorKind::Input | ErrorKind::Memory), "{e}");
                let line = e.to_string();
                assert!(!line.contains(char::is_control), "{line}");
                assert!(line.starts_with(&format!("'{}': ", path.display())) && line.contains("; "), "{line}");
            }
        }
    }
}

#[test]
fn bad_marks_are_not_overlooked() {
    // Lenient loads that the names promise to be broken in ways that we must see.
    for path in data() {
        let must_fail =
            ["err-truncated", "err-bomb", "err-empty", "err-pngsuite", "err-zero", "err-hdr", "err-bad-crc"];
        if must_fail.iter().any(|m| name(&path).starts_with(m)) && !name(&path).ends_with(".gif") {
            assert!(read(&path, &ReadOptions::default()).is_err(), "{path:?}");
        }
    }
}

#[test]
fn nan_and_infinity_are_counted_or_replaced() {
    for path in data().iter().filter(|p| name(p) == "odd-nan-inf.exr") {
        let refused = read(path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("not finite, the first at x="), "{refused}");
        for nonfinite in [NonFinite::Zero, NonFinite::Clamp] {
            let picture = read(path, &ReadOptions { nonfinite, ..ReadOptions::default() }).unwrap();
            assert_eq!(picture.warnings.len(), 1);
        }
    }
}

#[test]
fn nothing_loads_beyond_a_small_budget() {
    let limits = Limits { memory: 1000, ..Limits::default() };
    for path in data() {
        if let Ok(picture) = read(&path, &ReadOptions { limits, ..ReadOptions::default() }) {
            let bytes = picture.plane.domain().len() * picture.plane.samples.channels();
            assert!(bytes <= 500, "{path:?}");
        }
    }
}
