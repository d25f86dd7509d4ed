//! `regress`, `bless`, `review`: the end-to-end suite in release, and its references.

use std::fs;
use std::io::{BufRead, Write};

use crate::outcome::Outcome;
use crate::program::cargo_with;
use crate::tree::root;

/// The suite, as cargo knows it.
const SUITE: [&str; 7] = ["test", "--quiet", "--release", "--package", "selvedge", "--test", "suite"];

/// Runs the recipes whose names contain the pattern and writes tests/out/index.html with all their pictures.
pub(crate) fn run(args: &[String]) -> Outcome {
    let mut line = SUITE.to_vec();
    line.push("--");
    line.extend(args.iter().map(String::as_str));
    cargo_with(&line, &[("SELVEDGE_PAGE", "1")])
}

/// Writes the references of the named recipes; the run says of each that it is new.
pub(crate) fn bless(args: &[String]) -> Outcome {
    if args.is_empty() {
        return Err("usage: cargo xtask bless NAME...".into());
    }
    if let Some(name) = args.iter().find(|name| !root().join(format!("tests/suite/{name}.toml")).is_file()) {
        return Err(format!("there is no recipe tests/suite/{name}.toml"));
    }
    let mut line = SUITE.to_vec();
    if let [only] = args {
        line.extend(["--", "--exact", only]);
    }
    // Writing a reference fails once by design, so that nothing turns green unseen.
    if cargo_with(&line, &[("SELVEDGE_BLESS", &args.join(",")), ("INSTA_UPDATE", "always")]).is_ok() {
        return Err("no reference was written".into());
    }
    eprintln!("look at tests/out/index.html and at the changes in tests/ref, then run `cargo xtask regress`");
    Ok(())
}

/// Runs the suite and asks, for each recipe that is not its reference, whether to write it anew.
pub(crate) fn review(args: &[String]) -> Outcome {
    let outcome = run(args);
    let list = fs::read_to_string(root().join("tests/out/review.txt")).unwrap_or_default();
    if outcome.is_ok() || list.is_empty() {
        return outcome;
    }
    eprintln!("open {}", root().join("tests/out/index.html").display());
    let mut answers = std::io::stdin().lock().lines();
    for name in list.lines() {
        eprint!("bless `{name}`? [y/N] ");
        let _ = std::io::stderr().flush();
        if answers.next().and_then(Result::ok).is_some_and(|answer| answer.trim() == "y") {
            bless(&[name.to_owned()])?;
        }
    }
    Ok(())
}
