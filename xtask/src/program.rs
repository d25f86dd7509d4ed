//! Cargo, and the program in release, as the chores run them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use crate::outcome::Outcome;
use crate::tree::root;

/// Runs cargo in the project's root; warnings of rustdoc count as errors.
pub(crate) fn cargo(args: &[&str]) -> Outcome {
    cargo_with(args, &[("RUSTDOCFLAGS", "-D warnings")])
}

/// Runs cargo in the project's root with these variables.
pub(crate) fn cargo_with(args: &[&str], variables: &[(&str, &str)]) -> Outcome {
    eprintln!("xtask: cargo {}", args.join(" "));
    // `+nightly` is understood by rustup's cargo alone, not by the one that runs us.
    let ours = std::env::var_os("CARGO").filter(|_| !args[0].starts_with('+'));
    let cargo = ours.unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    let status = command.args(args).envs(variables.iter().copied()).current_dir(root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`cargo {}` ended with {status}", args.join(" "))),
        Err(e) => Err(format!("cannot run cargo: {e}")),
    }
}

/// Builds the program in release.
pub(crate) fn build() -> Result<PathBuf, String> {
    cargo_with(&["build", "--quiet", "--release", "--package", "selvedge"], &[])?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    Ok(target.join("release").join(format!("selvedge{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs a program in the project's root.
pub(crate) fn run<'a>(program: &Path, args: impl IntoIterator<Item = &'a str>) -> Result<Output, String> {
    let output = Command::new(program).args(args).current_dir(root()).output();
    output.map_err(|e| format!("{}: {e}", program.display()))
}

/// Makes a folder anew below target/.
pub(crate) fn fresh(name: &str) -> Result<PathBuf, String> {
    let folder = root().join("target").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// Processor time of all children that have ended, in steps of 10 ms; zero where the system does not tell.
pub(crate) fn children_time() -> Duration {
    let ticks = || {
        let stat = fs::read_to_string("/proc/self/stat").ok()?;
        let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(13);
        Some(fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?)
    };
    Duration::from_millis(10 * ticks().unwrap_or(0))
}

/// An error unless it holds.
pub(crate) fn check(holds: bool, what: impl FnOnce() -> String) -> Outcome {
    if holds { Ok(()) } else { Err(what()) }
}
