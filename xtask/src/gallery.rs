//! `gallery`: makes the pictures of README.md again, with the program itself.

use std::path::Path;

use crate::ci::cargo_with;
use crate::tree::Tree;
use crate::{Outcome, program};

/// Where the rows stand.
const ROWS: &str = "docs/gallery.toml";

/// Runs every row and puts exemplars and outputs side by side, strip by strip.
pub(crate) fn run(args: &[String]) -> Outcome {
    let table = Tree::of_project().manifest(ROWS).map_err(|why| format!("{ROWS} {why}"))?;
    let strips =
        table.get("strip").and_then(|s| s.as_table()).ok_or_else(|| format!("{ROWS} has no [[strip.NAME]]"))?;
    let selvedge = program::build()?;
    program::fresh("gallery")?;
    let wanted = |name: &str| args.is_empty() || args.iter().any(|arg| arg == name);
    for (name, rows) in strips.iter().filter(|(name, _)| wanted(name)) {
        let rows = rows.as_array().ok_or_else(|| format!("{ROWS}: `{name}` has no rows"))?;
        let mut pictures = Vec::new();
        for (number, row) in rows.iter().enumerate() {
            if 0 < number {
                pictures.push("/".into());
            }
            pictures.extend(made(&selvedge, name, number, row)?);
        }
        let strip = format!("docs/{name}.jpg");
        let mut args =
            vec!["run", "--quiet", "--release", "--package", "selvedge", "--example", "collage", "--", &strip];
        args.extend(pictures.iter().map(String::as_str));
        cargo_with(&args, &[])?;
    }
    Ok(())
}

/// Runs a row; answers with its pictures: the exemplar, and each target with what was made.
fn made(selvedge: &Path, name: &str, number: usize, row: &toml::Value) -> Result<Vec<String>, String> {
    let texts = |key: &str| {
        let all = row.get(key).and_then(|v| v.as_array()).into_iter().flatten();
        all.filter_map(|v| v.as_str()).collect::<Vec<_>>()
    };
    let exemplar = row.get("exemplar").and_then(|v| v.as_str());
    let mut pictures = vec![exemplar.ok_or(format!("{ROWS}: row {number} of `{name}` has no `exemplar`"))?.to_owned()];
    let (targets, runs) = (texts("targets"), texts("runs"));
    program::check(!runs.is_empty(), || format!("{ROWS}: row {number} of `{name}` has no `runs`"))?;
    for (i, run) in runs.iter().enumerate() {
        let out = format!("target/gallery/{name}-{number}-{i}.png");
        let output = program::run(selvedge, run.replace("{out}", &out).split_whitespace())?;
        program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())?;
        pictures.extend(targets.get(i).map(|&target| target.to_owned()));
        pictures.push(out);
    }
    Ok(pictures)
}
