//! Options as used: what `--json` shows, and the canonical command that pictures carry.

use std::path::PathBuf;

use serde_json::{Map, Value};

/// The options that change samples, by their long names, with every choice of the program made.
///
/// Equal runs have equal lists, however their options were typed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Used(Vec<(&'static str, Value)>);

impl Used {
    /// Adds an option; one without a value, or a switch that is off, is shown but not typed.
    #[must_use]
    pub(crate) fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.0.push((name, value.into()));
        self
    }

    /// As a JSON object.
    pub(crate) fn json(&self) -> Value {
        self.0.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect::<Map<_, _>>().into()
    }

    /// The canonical command: files without their folders, options in the order of the command's help, never an
    /// output or anything else that leaves the samples as they are.
    pub(crate) fn command(&self, name: &str, files: &[PathBuf]) -> String {
        let mut words = vec!["selvedge".to_owned(), name.to_owned()];
        words.extend(files.iter().map(|path| selvedge_io::display_name(path)));
        for (name, value) in &self.0 {
            words.extend(typed(name, value));
        }
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
    }
}

fn typed(name: &str, value: &Value) -> Vec<String> {
    let flag = format!("--{name}");
    match value {
        Value::Null | Value::Bool(false) => Vec::new(),
        Value::Bool(true) => vec![flag],
        Value::Array(values) => values.iter().flat_map(|v| typed_once(name, v)).collect(),
        Value::String(text) => vec![flag, text.clone()],
        other => vec![flag, other.to_string()],
    }
}

/// An option that may be given several times, once: a list is its several values.
fn typed_once(name: &str, value: &Value) -> Vec<String> {
    let Value::Array(values) = value else { return typed(name, value) };
    let words = values.iter().map(|v| v.as_str().map_or_else(|| v.to_string(), str::to_owned));
    std::iter::once(format!("--{name}")).chain(words).collect()
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_can_be_typed_again() {
        let used = Used::default()
            .with("size", "64x48")
            .with("tile", Value::Null)
            .with("paper", false)
            .with("fast", true)
            .with("tolerance", 0.1)
            .with("mask", vec!["m 1.png", "none"])
            .with("guide", vec![vec!["a.png", "b.png"], vec!["c.png", "d.png"]]);
        let files = ["some/where/it's.png".into(), "b.png".into()];
        assert_eq!(
            used.command("quilt", &files),
            r"selvedge quilt 'it'\''s.png' b.png --size 64x48 --fast --tolerance 0.1 --mask 'm 1.png' --mask none --guide a.png b.png --guide c.png d.png"
        );
        assert_eq!(used.json()["tile"], Value::Null);
    }
}
