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
    let mut pictures = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let text =
            |key: &str| row.get(key).and_then(|v| v.as_str()).ok_or(format!("row {number} of {ROWS} has no `{key}`"));
        let out = format!("target/gallery/{number}.png");
        let line = text("run")?.replace("{out}", &out);
        let output = program::run(&selvedge, line.split_whitespace())?;
        program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())?;
        pictures.extend([text("exemplar")?.to_owned(), out]);
    }
    let mut args = vec!["run", "--quiet", "--release", "--package", "selvedge", "--example", "collage", "--", STRIP];
    args.extend(pictures.iter().map(String::as_str));
    cargo_with(&args, &[])
}
