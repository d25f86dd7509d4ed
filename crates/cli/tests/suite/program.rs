//! Running the program and collecting what it says and writes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// What one run of the program said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Said {
    /// Exit code; `None` if a signal ended it.
    pub(crate) exit: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs the program in the project's root.
pub(crate) fn selvedge<'a>(args: impl IntoIterator<Item = &'a str>) -> Said {
    selvedge_in(&crate::root(), args)
}

/// Runs the program in a folder.
pub(crate) fn selvedge_in<'a>(folder: &Path, args: impl IntoIterator<Item = &'a str>) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_selvedge")).args(args).current_dir(folder).output();
    let output = output.expect("cargo has built the program");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Said { exit: output.status.code(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
}

/// Files in a folder by their names.
pub(crate) fn files_in(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|e| Some((e.file_name().to_string_lossy().into_owned(), fs::read(e.path()).ok()?))).collect()
}

/// Makes a folder anew, without what was in it.
pub(crate) fn fresh(folder: &Path) {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
}
