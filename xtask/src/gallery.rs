//! `gallery`: makes the pictures of README.md again, with the program itself.

use crate::ci::cargo_with;
use crate::tree::Tree;
use crate::{Outcome, program};

/// Where the rows stand, and what is made of them.
const ROWS: &str = "docs/gallery.toml";
const STRIP: &str = "docs/gallery.jpg";

/// Runs every row and puts exemplars and outputs side by side.
pub(crate) fn run(_: &[String]) -> Outcome {
    let table = Tree::of_project().manifest(ROWS).map_err(|why| format!("{ROWS} {why}"))?;
    let rows = table.get("row").and_then(|r| r.as_array()).ok_or_else(|| format!("{ROWS} has no [[row]]"))?;
    let selvedge = program::build()?;
    program::fresh("gallery")?;
    let mut args: Vec<String> =
        ["run", "--quiet", "--release", "--package", "selvedge", "--example", "collage", "--", STRIP]
            .map(Into::into)
            .into();
    for (number, row) in rows.iter().enumerate() {
        let texts = |key: &str| {
            let all = row.get(key).and_then(|v| v.as_array()).into_iter().flatten();
            all.filter_map(|v| v.as_str()).collect::<Vec<_>>()
        };
        let exemplar = row.get("exemplar").and_then(|v| v.as_str());
        if 0 < number {
            args.push("/".into());
        }
        args.push(exemplar.ok_or(format!("row {number} of {ROWS} has no `exemplar`"))?.into());
        let (targets, runs) = (texts("targets"), texts("runs"));
        program::check(!runs.is_empty(), || format!("row {number} of {ROWS} has no `runs`"))?;
        for (i, run) in runs.iter().enumerate() {
            let out = format!("target/gallery/{number}-{i}.png");
            let output = program::run(&selvedge, run.replace("{out}", &out).split_whitespace())?;
            program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())?;
            args.extend(targets.get(i).map(|&target| target.to_owned()));
            args.push(out);
        }
    }
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    cargo_with(&args, &[])
}
