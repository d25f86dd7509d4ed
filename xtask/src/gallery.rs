//! `gallery`: makes the pictures of README.md again, with the program itself.

use std::fs;
use std::path::Path;

use selvedge_core::Role;
use selvedge_testkit::from_png;

use crate::banner::{self, Banner};
use crate::outcome::Outcome;
use crate::program::cargo_with;
use crate::tree::{Tree, root};
use crate::{fixtures, program};

/// Where the rows stand.
const ROWS: &str = "docs/gallery.toml";
/// What they were when the strips were made: a line `STRIP-NUMBER HASH` each.
const ANSWERS: &str = "docs/gallery.answers";

/// A row of a strip: an exemplar, and what is made of it.
struct Row {
    strip: String,
    number: usize,
    exemplar: String,
    /// Whether it stands in the line of the row before.
    beside: bool,
    /// Pictures that its runs follow, if any.
    targets: Vec<String>,
    runs: Vec<String>,
}

/// Runs every row and puts exemplars and outputs side by side, strip by strip.
pub(crate) fn run(args: &[String]) -> Outcome {
    let selvedge = program::build()?;
    program::fresh("gallery")?;
    let (rows, mut answers) = (rows()?, answers());
    let mut strips: Vec<&String> = rows.iter().map(|row| &row.strip).collect();
    strips.dedup();
    for name in strips.into_iter().filter(|name| args.is_empty() || args.contains(name)) {
        let mut pictures = Vec::new();
        for row in rows.iter().filter(|row| row.strip == *name) {
            let (made, hash) = made(row, &selvedge)?;
            if !pictures.is_empty() && !row.beside {
                pictures.push("/".into());
            }
            pictures.push(row.exemplar.clone());
            pictures.extend(made);
            answers.retain(|(key, _)| *key != row.key());
            answers.push((row.key(), hash));
        }
        collage(name, &pictures)?;
    }
    if args.is_empty() || args.iter().any(|name| name == "banner") {
        let Banner { letter, word } = banner::make(&selvedge, "target/gallery")?;
        collage("merge", &letter)?;
        collage("overlap", &banner::overlap(&selvedge, "target/gallery")?)?;
        collage("banner", &[word])?;
    }
    answers.retain(|(key, _)| rows.iter().any(|row| row.key() == *key));
    answers.sort();
    let text: String = answers.iter().map(|(key, hash)| format!("{key} {hash}\n")).collect();
    fs::write(root().join(ANSWERS), text).map_err(|e| format!("{ANSWERS}: {e}"))
}

/// Writes docs/NAME.jpg of pictures in rows.
fn collage(name: &str, pictures: &[String]) -> Outcome {
    let strip = format!("docs/{name}.jpg");
    let mut args = vec!["run", "--quiet", "--release", "--package", "selvedge", "--example", "collage", "--", &strip];
    args.extend(pictures.iter().map(String::as_str));
    cargo_with(&args, &[])
}

impl Row {
    fn key(&self) -> String {
        format!("{}-{}", self.strip, self.number)
    }
}

/// All rows, strip by strip.
fn rows() -> Result<Vec<Row>, String> {
    let table = Tree::of_project().manifest(ROWS).map_err(|why| format!("{ROWS} {why}"))?;
    let strips =
        table.get("strip").and_then(|s| s.as_table()).ok_or_else(|| format!("{ROWS} has no [[strip.NAME]]"))?;
    let mut all = Vec::new();
    for (name, rows) in strips {
        let rows = rows.as_array().ok_or_else(|| format!("{ROWS}: `{name}` has no rows"))?;
        for (number, row) in rows.iter().enumerate() {
            let exemplar = row.get("exemplar").and_then(|v| v.as_str());
            let exemplar = exemplar.ok_or(format!("{ROWS}: row {number} of `{name}` has no `exemplar`"))?.to_owned();
            let texts = |key: &str| {
                let all = row.get(key).and_then(|v| v.as_array()).into_iter().flatten();
                all.filter_map(|v| v.as_str()).map(str::to_owned).collect::<Vec<_>>()
            };
            let beside = row.get("beside").and_then(toml::Value::as_bool).unwrap_or(false);
            let (targets, runs) = (texts("targets"), texts("runs"));
            program::check(!runs.is_empty(), || format!("{ROWS}: row {number} of `{name}` has no `runs`"))?;
            all.push(Row { strip: name.clone(), number, exemplar, beside, targets, runs });
        }
    }
    Ok(all)
}

/// The pictures of a row beside its exemplar, each target before what was made of it, and the hash of what was made.
fn made(row: &Row, selvedge: &Path) -> Result<(Vec<String>, String), String> {
    let (mut pictures, mut hashes) = (Vec::new(), Vec::new());
    for (i, run) in row.runs.iter().enumerate() {
        let out = format!("target/gallery/{}-{i}.png", row.key());
        let output = program::run(selvedge, run.replace("{out}", &out).split_whitespace())?;
        program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).into_owned())?;
        let file = fs::read(root().join(&out)).map_err(|e| format!("{out}: {e}"))?;
        let plane = from_png(Role::Color, &file).map_err(|e| e.to_string())?;
        hashes.push(fixtures::hash(selvedge_testkit::bytes(&plane)));
        pictures.extend(row.targets.get(i).cloned());
        pictures.push(out);
    }
    Ok((pictures, hashes.join("+")))
}

fn answers() -> Vec<(String, String)> {
    let text = fs::read_to_string(root().join(ANSWERS)).unwrap_or_default();
    let pair = |line: &str| line.split_once(' ').map(|(key, hash)| (key.to_owned(), hash.to_owned()));
    text.lines().filter_map(pair).collect()
}
