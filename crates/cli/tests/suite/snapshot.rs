//! A recipe's outcome as text: what was said, without what may differ from run to run, and a hash of every output.

use std::collections::BTreeMap;
use std::path::Path;

use selvedge_core::{Limits, Plane, Samples, SourceMap};
use selvedge_io::{ReadOptions, decode, decode_map};
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
        text += &format!("$ selvedge {line}\nexit {expected}\n{}", shown(&said, &name).replace(&name, "{out}"));
    }
    let files = files_in(folder);
    for (file, bytes) in &files {
        text += &format!("{file}: {}\n", contents(file, bytes));
    }
    let _ = std::fs::remove_dir_all(folder);
    Ok(Outcome { text, files })
}

/// Standard output as redacted JSON, standard error behind `>`.
fn shown(said: &Said, folder: &str) -> String {
    let stdout = match serde_json::from_str(&said.stdout) {
        Ok(mut value) => {
            redact(&mut value, folder);
            format!("{value:#}\n")
        }
        Err(_) => said.stdout.clone(),
    };
    let stderr: String =
        said.stderr.lines().map(|line| format!("> {}\n", without_memory(&without_times(line)))).collect();
    stdout + &stderr
}

/// Takes out what may differ: the version, times, threads, memory, and the bytes of the files that were made in
/// `folder` (encoders may change; the samples are hashed by [`contents`]).
fn redact(value: &mut Value, folder: &str) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| redact(item, folder)),
        Value::Object(parts) => {
            let made = parts.get("path").and_then(Value::as_str).is_some_and(|path| path.starts_with(folder));
            for (key, part) in parts {
                match key.as_str() {
                    "version" | "seconds" | "threads" | "peak_memory_bytes" | "estimated_memory_bytes" => {
                        *part = json!(format!("[{key}]"));
                    }
                    "message" | "remedy" if part.is_string() => {
                        *part = json!(without_memory(part.as_str().unwrap_or_default()));
                    }
                    "blake3" if made => *part = json!("[file]"),
                    _ => redact(part, folder),
                }
            }
        }
        _ => {}
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

/// The text without amounts of memory, and sizes that follow from them: more threads hold more.
fn without_memory(text: &str) -> String {
    if !text.contains("memory") && !text.contains("--max-memory") {
        return text.to_owned();
    }
    let words: Vec<&str> = text.split(' ').collect();
    let bare = |word: &str| word.trim_end_matches([';', ',', '.']).to_owned();
    let is_unit = |word: &&str| ["KiB", "MiB", "GiB"].contains(&bare(word).as_str());
    let redacted = |i: usize| match words[i] {
        _ if i != 0 && words[i - 1] == "--max-memory" => "[memory]",
        word if words.get(i + 1).is_some_and(is_unit) && word.parse::<f64>().is_ok() => "[memory]",
        word if bare(word).split_once('x').is_some_and(|(w, h)| [w, h].iter().all(|n| n.parse::<u32>().is_ok()))
            && text.contains("--max-memory") =>
        {
            "[size]"
        }
        word => word,
    };
    (0..words.len()).map(redacted).collect::<Vec<_>>().join(" ")
}

/// Shape, depth and hash of the samples of a picture; hash of the numbers of a source map; of the bytes of any other
/// file.
fn contents(name: &str, bytes: &[u8]) -> String {
    match decode(bytes, name, &ReadOptions::default()) {
        Ok(picture) => {
            let plane = &picture.plane;
            format!("{}, samples {}", selvedge_testkit::describe(plane), blake3::hash(&sample_bytes(plane)).to_hex())
        }
        Err(_) => match decode_map(bytes, name, &Limits::default()) {
            Ok(file) => format!("source map, ids {}", blake3::hash(&id_bytes(&file.map)).to_hex()),
            Err(_) => format!("{} bytes, {}", bytes.len(), blake3::hash(bytes).to_hex()),
        },
    }
}

/// Sample numbers in a fixed order and form.
fn id_bytes(map: &SourceMap<2>) -> Vec<u8> {
    map.ids.samples().iter().flat_map(|id| id.get().to_le_bytes()).collect()
}

/// All samples in a fixed order and form: planar, little-endian.
fn sample_bytes(plane: &Plane<2>) -> Vec<u8> {
    match &plane.samples {
        Samples::U8(g) => g.samples().to_vec(),
        Samples::U16(g) | Samples::F16(g) => g.samples().iter().flat_map(|v| v.to_le_bytes()).collect(),
        Samples::F32(g) => g.samples().iter().flat_map(|v| v.to_le_bytes()).collect(),
    }
}
