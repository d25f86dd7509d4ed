//! `ci`: everything that has to pass, in the order in which it is cheap. Needs cargo, rustfmt and clippy.

use std::process::Command;
use std::time::Instant;

use crate::tree::Tree;
use crate::{Outcome, fresh, tidy};

/// Runs every check and test.
pub(crate) fn run(_: &[String]) -> Outcome {
    let started = Instant::now();
    cargo(&["fmt", "--all", "--check"])?;
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])?;
    cargo(&["doc", "--workspace", "--no-deps"])?;
    cargo(&["test", "--workspace"])?;
    // The one optional feature whose code the line above leaves out.
    cargo(&["test", "-p", "selvedge-maxflow", "--features", "petgraph"])?;
    let tree = Tree::of_project();
    for name in tree.crates() {
        let package = package_name(&tree, name)?;
        cargo(&["check", "--tests", "--no-default-features", "-p", &package])?;
    }
    tidy::run(&[])?;
    fresh::run(&[])?;
    eprintln!("xtask: all green after {} s", started.elapsed().as_secs());
    Ok(())
}

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
    let status = command.args(args).envs(variables.iter().copied()).current_dir(crate::tree::root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`cargo {}` ended with {status}", args.join(" "))),
        Err(e) => Err(format!("cannot run cargo: {e}")),
    }
}

/// The package that stands in `crates/NAME`.
pub(crate) fn package_name(tree: &Tree, name: &str) -> Result<String, String> {
    let path = format!("crates/{name}/Cargo.toml");
    let manifest = tree.manifest(&path).map_err(|why| format!("{path} {why}"))?;
    let package = manifest.get("package").and_then(|p| p.get("name")).and_then(|n| n.as_str());
    package.map(str::to_owned).ok_or_else(|| format!("{path} names no package"))
}
