//! A recipe's outcome as text: what was said, without what may differ from run to run, and a hash of every output.

use std::collections::BTreeMap;
use std::path::Path;

use selvedge_core::{Plane, Samples};
use selvedge_io::{ReadOptions, decode};
use serde_json::{Value, json};

use crate::program::{Said, files_in, fresh, selvedge};
use crate::recipe::Recipe;

/// Everything that a recipe led to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Outcome {
    /// For the reference.
    pub(crate) text: String,
    /// What was written.
    pub(crate) files: BTreeMap<String, Vec<u8>>,
}

/// Runs a recipe on so many threads, writing into `folder`, which it takes away again.
pub(crate) fn outcome(recipe: &Recipe, folder: &Path, threads: u32) -> Result<Outcome, String> {
    let name = folder.strip_prefix(crate::root()).unwrap_or(folder).to_string_lossy().replace('\\', "/");
    fresh(folder);
    let mut text = String::new();
    for (number, line) in (1..).zip(&recipe.run) {
        let typed = line.replace("{out}", &name);
        let threads = threads.to_string();
        let said = selvedge(typed.split_whitespace().chain(["--json", "--progress", "none", "-j", &threads]));
        let expected = if number == recipe.run.len() { recipe.exit } else { 0 };
        if said.exit != Some(expected) {
            return Err(format!("`selvedge {typed}` ended with {:?}, not {expected}: {}", said.exit, said.stderr));
        }
        text += &format!("$ selvedge {line}\nexit {expected}\n{}", shown(&said).replace(&name, "{out}"));
    }
    let files = files_in(folder);
    for (file, bytes) in &files {
        text += &format!("{file}: {}\n", contents(file, bytes));
    }
    let _ = std::fs::remove_dir_all(folder);
    Ok(Outcome { text, files })
}

/// Standard output as redacted JSON, standard error behind `>`.
fn shown(said: &Said) -> String {
    let stdout = match serde_json::from_str(&said.stdout) {
        Ok(mut value) => {
            redact(&mut value);
            format!("{value:#}\n")
        }
        Err(_) => said.stdout.clone(),
    };
    let stderr: String = said.stderr.lines().map(|line| format!("> {}\n", without_times(line))).collect();
    stdout + &stderr
}

/// Takes out what may differ: the version, times, threads, memory, and the bytes of files (encoders may change; the
/// samples are hashed by [`contents`]).
fn redact(run: &mut Value) {
    for key in ["version", "seconds", "threads", "peak_memory_bytes"] {
        if let Some(value) = run.get_mut(key) {
            *value = json!(format!("[{key}]"));
        }
    }
    for output in run.get_mut("outputs").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(hash) = output.get_mut("blake3") {
            *hash = json!("[file]");
        }
    }
}

/// The line with `1.25 s` made `[time] s`.
fn without_times(line: &str) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    let is_time = |i: usize| {
        words.get(i + 1).is_some_and(|unit| unit.trim_end_matches('.') == "s") && words[i].parse::<f64>().is_ok()
    };
    (0..words.len()).map(|i| if is_time(i) { "[time]" } else { words[i] }).collect::<Vec<_>>().join(" ")
}

/// Shape, depth and hash of the samples of a picture; of the bytes of any other file.
fn contents(name: &str, bytes: &[u8]) -> String {
    match decode(bytes, name, &ReadOptions::default()) {
        Ok(picture) => {
            let plane = &picture.plane;
            format!("{}, samples {}", selvedge_testkit::describe(plane), blake3::hash(&sample_bytes(plane)).to_hex())
        }
        Err(_) => format!("{} bytes, {}", bytes.len(), blake3::hash(bytes).to_hex()),
    }
}

/// All samples in a fixed order and form: planar, little-endian.
fn sample_bytes(plane: &Plane<2>) -> Vec<u8> {
    match &plane.samples {
        Samples::U8(g) => g.samples().to_vec(),
        Samples::U16(g) | Samples::F16(g) => g.samples().iter().flat_map(|v| v.to_le_bytes()).collect(),
        Samples::F32(g) => g.samples().iter().flat_map(|v| v.to_le_bytes()).collect(),
    }
}
