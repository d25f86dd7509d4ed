//! `gallery`: makes the pictures of README.md again, with the program itself.

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
            let text = |key: &str| {
                row.get(key).and_then(|v| v.as_str()).ok_or(format!("{ROWS}: row {number} of `{name}` has no `{key}`"))
            };
            let out = format!("target/gallery/{name}-{number}.png");
            let line = text("run")?.replace("{out}", &out);
            let output = program::run(&selvedge, line.split_whitespace())?;
            program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())?;
            pictures.extend([text("exemplar")?.to_owned(), out]);
        }
        let strip = format!("docs/{name}.jpg");
        let mut args =
            vec!["run", "--quiet", "--release", "--package", "selvedge", "--example", "collage", "--", &strip];
        args.extend(pictures.iter().map(String::as_str));
        cargo_with(&args, &[])?;
    }
    Ok(())
}
