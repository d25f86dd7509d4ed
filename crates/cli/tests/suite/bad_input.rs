//! Files that are damaged, hostile or merely odd: each ends in success, in code 3 or in code 6, with one line that
//! names the file, no panic, and nothing written.

use std::path::{Path, PathBuf};

use libtest_mimic::{Failed, Trial};

use crate::program::{Said, files_in, fresh, selvedge};

/// One test a file of fixtures/bad and, where `SELVEDGE_DATA` names a folder, of the `bad` folders in it.
pub(crate) fn trials() -> Vec<Trial> {
    let mut folders = vec![crate::root().join("fixtures/bad")];
    let mut trials = Vec::new();
    match std::env::var_os("SELVEDGE_DATA") {
        Some(data) => folders.extend(folders_named_bad(Path::new(&data))),
        None => {
            let name = "bad input: SELVEDGE_DATA is not set, its files are left out";
            trials.push(Trial::test(name, || Ok(())).with_ignored_flag(true));
        }
    }
    for folder in folders {
        let mut paths: Vec<PathBuf> =
            std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
        paths.sort();
        trials.extend(paths.into_iter().filter(|path| path.is_file()).map(trial));
    }
    trials
}

fn folders_named_bad(data: &Path) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(data).into_iter().flatten().flatten().map(|entry| entry.path().join("bad")).collect();
    folders.retain(|folder| folder.is_dir());
    folders.sort();
    folders
}

fn trial(path: PathBuf) -> Trial {
    let relative = path.strip_prefix(crate::root()).unwrap_or(&path).to_path_buf();
    Trial::test(format!("bad input: {}", relative.display()), move || check(&relative))
}

fn check(path: &Path) -> Result<(), Failed> {
    // A format that holds whatever depth comes, and what most people would type.
    let any_depth = if path.extension().is_some_and(|e| e == "exr") { "out.exr" } else { "out.tiff" };
    check_as(path, any_depth, &["--size", "24x20"], true)?;
    check_as(path, "out.png", &["--block", "auto"], false)
}

/// One run; if `held`, the output can hold whatever the file does.
fn check_as(path: &Path, file: &str, options: &[&str], held: bool) -> Result<(), Failed> {
    let folder = crate::out_dir().join(format!("bad-{}", path.to_string_lossy().replace(['/', '\\', ':'], "-")));
    fresh(&folder);
    let out = folder.join(file);
    let (input, output) = (path.to_string_lossy(), out.to_string_lossy());
    let words = ["quilt", &input, "-o", &output, "--max-memory", "1GiB", "--progress", "none"];
    let said = selvedge(words.into_iter().chain(options.iter().copied()));
    let written: Vec<String> = files_in(&folder).into_keys().collect();
    let _ = std::fs::remove_dir_all(&folder);
    let why = verdict(path, &said, &written, held);
    why.map_err(|why| format!("{file}: {why}\n{said:?}, written: {written:?}").into())
}

/// `err-*` must be refused, `ok-*` must not where the output holds them, and whatever happens is said properly.
fn verdict(path: &Path, said: &Said, written: &[String], held: bool) -> Result<(), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let code = said.exit.ok_or("a signal ended the program")?;
    match code {
        0 if name.starts_with("err-") && !may_be_read(path) => return Err("a damaged file was accepted".into()),
        0 => {
            return if matches!(written, [one] if one.starts_with("out.")) {
                Ok(())
            } else {
                Err("not exactly the output was written".into())
            };
        }
        3 | 6 if held && name.starts_with("ok-") && !may_be_refused(&name) => {
            return Err("a good file was refused".into());
        }
        3 | 6 => {}
        _ => return Err(format!("ended with {code}, not with 0, 3 or 6")),
    }
    let lines: Vec<&str> = said.stderr.lines().collect();
    match lines[..] {
        [line] if line.starts_with("error: ") && line.contains(&*name) => {}
        _ => return Err("standard error is not one line `error: ...` with the file's name".into()),
    }
    if !written.is_empty() || !said.stdout.is_empty() {
        return Err("a refused file left something behind".into());
    }
    Ok(())
}

/// Our own bad files leave nothing to read, nor do the broken files of PngSuite. Others, mostly found by fuzzers, may
/// be read as far as they go.
fn may_be_read(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    !(path.starts_with("fixtures/bad") || name.starts_with("err-pngsuite")) || name.starts_with("err-idat-short")
}

/// Kinds of good files that may be refused with a reason.
fn may_be_refused(name: &str) -> bool {
    name.starts_with("ok-cmyk")
}
