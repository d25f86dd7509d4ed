//! What benchmarks (tests/bench) and README.md's pictures (docs/gallery.toml) are known to make: the program makes it
//! today.

use std::fs;

use libtest_mimic::{Failed, Trial};
use selvedge_core::Role;
use selvedge_testkit::from_png;

use crate::program::{fresh, selvedge};

/// Where the rows of pictures stand, and what each was when it was made: a line `STRIP-NUMBER HASH+HASH` each.
const GALLERY: [&str; 2] = ["docs/gallery.toml", "docs/gallery.answers"];

/// A run whose picture is known.
struct Known {
    name: String,
    run: String,
    answer: String,
    /// What makes the answer anew, if that is meant.
    anew: &'static str,
}

/// One test a benchmark, and one a picture of README.md.
pub(crate) fn trials() -> Vec<Trial> {
    match benches().and_then(|mut all| gallery().map(|pictures| all.extend(pictures)).map(|()| all)) {
        Ok(all) => all.into_iter().map(|known| Trial::test(known.name.clone(), move || check(&known))).collect(),
        Err(why) => vec![Trial::test("known answers can be read", move || Err(why.into()))],
    }
}

fn check(known: &Known) -> Result<(), Failed> {
    let name = known.name.replace(": ", "-");
    let folder = crate::out_dir().join(&name);
    fresh(&folder);
    let line = known.run.replace("{out}/out.png", "{out}").replace("{out}", &format!("tests/out/{name}/out.png"));
    let said = selvedge(line.split_whitespace().chain(["--quiet"]));
    if said.exit != Some(0) {
        return Err(format!("`selvedge {line}` ended with {:?}: {}", said.exit, said.stderr).into());
    }
    let file = fs::read(folder.join("out.png")).map_err(|e| format!("out.png: {e}"))?;
    let plane = from_png(Role::Color, &file).map_err(|e| e.to_string())?;
    let answer = blake3::hash(selvedge_testkit::bytes(&plane)).to_hex();
    if known.answer != answer.as_str() {
        return Err(format!("its samples hash to {answer} today\nif this is meant: {}", known.anew).into());
    }
    let _ = fs::remove_dir_all(&folder);
    Ok(())
}

/// tests/bench/NAME.toml.
fn benches() -> Result<Vec<Known>, String> {
    let entries = fs::read_dir(crate::root().join("tests/bench")).map_err(|e| format!("tests/bench: {e}"))?;
    let mut names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let known = |name: &String| {
        let path = format!("tests/bench/{name}");
        let table = table(&path)?;
        let text = |key: &str| table.get(key).and_then(|v| v.as_str()).map(str::to_owned);
        let (run, answer) = text("run").zip(text("answer")).ok_or(format!("{path} needs `run` and `answer`"))?;
        let name = format!("bench: {}", name.trim_end_matches(".toml"));
        Ok(Known { name, run, answer, anew: "write it into the benchmark as its `answer`" })
    };
    names.iter().map(known).collect()
}

/// docs/gallery.toml with its answers.
fn gallery() -> Result<Vec<Known>, String> {
    let [rows, answers] = GALLERY;
    let table = table(rows)?;
    let answers = fs::read_to_string(crate::root().join(answers)).map_err(|e| format!("{answers}: {e}"))?;
    let answer = |key: &str| answers.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(' '));
    let mut all = Vec::new();
    for (strip, rows) in table.get("strip").and_then(|s| s.as_table()).into_iter().flatten() {
        for (number, row) in rows.as_array().into_iter().flatten().enumerate() {
            let runs = row.get("runs").and_then(|v| v.as_array()).into_iter().flatten().filter_map(|run| run.as_str());
            let mut hashes = answer(&format!("{strip}-{number}")).unwrap_or_default().split('+');
            all.extend(runs.zip(0..).map(|(run, i)| Known {
                name: format!("gallery: {strip}-{number}-{i}"),
                run: run.to_owned(),
                answer: hashes.next().unwrap_or_default().to_owned(),
                anew: "cargo xtask gallery",
            }));
        }
    }
    if all.is_empty() { Err("docs/gallery.toml has no [[strip.NAME]] with `runs`".into()) } else { Ok(all) }
}

fn table(path: &str) -> Result<toml::Table, String> {
    let text = fs::read_to_string(crate::root().join(path)).map_err(|e| format!("{path}: {e}"))?;
    text.parse().map_err(|e: toml::de::Error| format!("{path}: {e}"))
}
