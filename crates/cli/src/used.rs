//! Options as used: what `--json` shows, and the canonical command that pictures carry.

use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, ArgMatches, Command};
use serde_json::{Map, Value};

/// The options that change samples, by their long names, with every choice of the program made.
///
/// Equal runs have equal lists, however their options were typed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Used(Vec<(String, Value)>);

/// Options that say where a run writes and what it is called, not what it makes.
pub(crate) const BESIDE: [&str; 15] = [
    "output",
    "map",
    "explain",
    "label-map",
    "mapped",
    "preview",
    "report",
    "sheet",
    "sweep",
    "each",
    "diff",
    "format",
    "help",
    "version",
    "save-config",
];

/// Whether an option is shown as used: not one of those, nor one that stands for others, which are shown instead.
pub(crate) fn is_used(long: &str) -> bool {
    !BESIDE.contains(&long) && !["paper", "surface"].contains(&long)
}

impl Used {
    /// All options of a command that change samples, as typed or by default, in the order of its help but for size and
    /// topology, which come first. No command lists its options: so none is forgotten.
    pub(crate) fn of(command: &Command, matches: &ArgMatches) -> Self {
        let own = |arg: &&Arg| arg.get_long().is_some_and(is_used) && !arg.is_positional() && !arg.is_global_set();
        let name = |arg: &Arg| arg.get_long().unwrap_or_default().to_owned();
        let mut all: Vec<(String, Value)> =
            command.get_arguments().filter(own).map(|arg| (name(arg), value(arg, matches))).collect();
        all.sort_by_key(|(name, _)| match name.as_str() {
            "size" => 0,
            "tile" => 1,
            _ => 2,
        });
        Self(all)
    }

    /// True if the command has an option.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(other, _)| other == name)
    }

    /// The value of an option that the program chose, or wrote in its one way.
    #[must_use]
    pub(crate) fn set(mut self, name: &str, chosen: impl Into<Value>) -> Self {
        debug_assert!(self.has(name), "no option --{name}");
        let chosen = chosen.into();
        self.0.iter_mut().filter(|(other, _)| other == name).for_each(|(_, value)| *value = chosen.clone());
        self
    }

    /// Without an option that does not act in this run.
    #[must_use]
    pub(crate) fn without(mut self, name: &str) -> Self {
        debug_assert!(self.has(name), "no option --{name}");
        self.0.retain(|(other, _)| other != name);
        self
    }

    /// Without an option that has this value, with which it does nothing.
    #[must_use]
    pub(crate) fn unless(mut self, name: &str, idle: impl Into<Value>) -> Self {
        let idle = idle.into();
        self.0.retain(|(other, value)| other != name || *value != idle);
        self
    }

    /// Adds an option; one without a value, or a switch that is off, is shown but not typed.
    #[must_use]
    pub(crate) fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.0.push((name.to_owned(), value.into()));
        self
    }

    /// Adds options before the first of some others, or at the end: where another command's help has them.
    #[must_use]
    pub(crate) fn before(mut self, others: &[&str], added: impl IntoIterator<Item = (String, Value)>) -> Self {
        let at = self.0.iter().position(|(name, _)| others.contains(&name.as_str())).unwrap_or(self.0.len());
        self.0.splice(at..at, added);
        self
    }

    /// As a JSON object.
    pub(crate) fn json(&self) -> Value {
        self.0.iter().map(|(name, value)| (name.clone(), value.clone())).collect::<Map<_, _>>().into()
    }

    /// The canonical command: files without their folders, options in the order of the command's help, never an
    /// output or anything else that leaves the samples as they are.
    pub(crate) fn command(&self, name: &str, files: &[PathBuf]) -> String {
        let mut words = vec!["selvedge".to_owned(), name.to_owned()];
        words.extend(files.iter().map(|path| file_name(path)));
        for (name, value) in &self.0 {
            words.extend(typed(name, value));
        }
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
    }
}

/// A file's name without its folders, so that it can be typed: one that begins with a dash is no option.
fn file_name(path: &Path) -> String {
    match selvedge_io::display_name(path) {
        name if name.starts_with('-') && name != "-" => format!("./{name}"),
        name => name,
    }
}

/// What an option was given: numbers as numbers, files by their names, all else as it was typed.
fn value(arg: &Arg, matches: &ArgMatches) -> Value {
    let id = arg.get_id().as_str();
    if !arg.get_action().takes_values() {
        return matches.get_flag(id).into();
    }
    let values = values(id, matches);
    if !matches!(arg.get_action(), ArgAction::Append) {
        values.into_iter().next().unwrap_or_default()
    } else if arg.get_value_delimiter().is_some() {
        // One list, as short as it can be written.
        let word = |v: &Value| match v {
            Value::String(text) => text.clone(),
            number => number.as_f64().map_or_else(|| number.to_string(), |n| n.to_string()),
        };
        (!values.is_empty()).then(|| values.iter().map(word).collect::<Vec<_>>().join(",")).into()
    } else {
        values.into()
    }
}

fn values(id: &str, matches: &ArgMatches) -> Vec<Value> {
    macro_rules! numbers {
        ($($number:ty),+) => {
            $(if let Ok(Some(values)) = matches.try_get_many::<$number>(id) {
                return values.map(|v| Value::from(*v)).collect();
            })+
        };
    }
    numbers!(f64, u64, u32, u8, usize);
    if let Ok(Some(files)) = matches.try_get_many::<PathBuf>(id) {
        return files.map(|file| file_name(file).into()).collect();
    }
    let typed = matches.get_raw(id).into_iter().flatten();
    typed.map(|raw| raw.to_string_lossy().into_owned().into()).collect()
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
        let dashed = Used::default().command("quilt", &["in/-a.png".into(), "-".into()]);
        assert_eq!(dashed, "selvedge quilt ./-a.png -");
        let files = ["some/where/it's.png".into(), "b.png".into()];
        assert_eq!(
            used.command("quilt", &files),
            r"selvedge quilt 'it'\''s.png' b.png --size 64x48 --fast --tolerance 0.1 --mask 'm 1.png' --mask none --guide a.png b.png --guide c.png d.png"
        );
        assert_eq!(used.json()["tile"], Value::Null);
    }
}
