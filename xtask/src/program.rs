//! The program in release, as the chores run it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::Outcome;
use crate::ci::cargo_with;
use crate::tree::root;

/// Builds the program in release.
pub(crate) fn build() -> Result<PathBuf, String> {
    cargo_with(&["build", "--quiet", "--release", "--package", "selvedge"], &[])?;
    Ok(built("release"))
}

/// Builds the program as tests do.
pub(crate) fn build_for_tests() -> Result<PathBuf, String> {
    cargo_with(&["build", "--quiet", "--package", "selvedge"], &[])?;
    Ok(built("debug"))
}

fn built(profile: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    target.join(profile).join(format!("selvedge{}", std::env::consts::EXE_SUFFIX))
}

/// Runs a program in the project's root.
pub(crate) fn run<'a>(program: &Path, args: impl IntoIterator<Item = &'a str>) -> Result<Output, String> {
    let output = Command::new(program).args(args).current_dir(root()).output();
    output.map_err(|e| format!("{}: {e}", program.display()))
}

/// Makes a folder anew below target/.
pub(crate) fn fresh(name: &str) -> Result<PathBuf, String> {
    let folder = root().join("target").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// An error unless it holds.
pub(crate) fn check(holds: bool, what: impl FnOnce() -> String) -> Outcome {
    if holds { Ok(()) } else { Err(what()) }
}
