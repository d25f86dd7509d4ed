//! Options in a file: `--config` and `--save-config`.
//!
//! A file of options is TOML whose keys are the long options without their dashes. Paths in it are taken from the
//! working folder, as if they were typed.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use toml::de::{DeArray, DeTable, DeValue};

use crate::failure::Failure;
use crate::used::BESIDE;
use crate::wrong::Wrong;

/// No file of options comes near this many bytes.
const LARGEST: u64 = 1 << 20;

/// Options of a file, as words of the command line.
pub(crate) struct FromFile {
    pub(crate) path: PathBuf,
    pub(crate) words: Vec<OsString>,
}

/// The options of the file that `--config` names, without those that were typed.
pub(crate) fn words(all: &Command, typed: &ArgMatches) -> Result<Option<FromFile>, Failure> {
    let Some((name, matches)) = typed.subcommand() else { return Ok(None) };
    let Some(path) = matches.get_one::<PathBuf>("config") else { return Ok(None) };
    let text = read(path)?;
    let wrong = |at: Range<usize>, Wrong { what, remedy }: Wrong| {
        let (line, column) = place(&text, at.start);
        Failure::new(2, format!("line {line}, column {column}: {what}")).remedy(remedy).about(path)
    };
    let no_toml = |e: toml::de::Error| wrong(e.span().unwrap_or(0..0), Wrong::new(e.message(), "mend it"));
    let table = DeTable::parse(&text).map_err(no_toml)?;
    let mut words = Vec::new();
    let command = command(all, name);
    for (key, value) in table.get_ref() {
        let Some(arg) = option(&command, key.get_ref()) else {
            let what = format!("'{}' is no option of 'selvedge {name}'", key.get_ref());
            return Err(wrong(key.span(), Wrong::new(what, format!("see 'selvedge help {name}'"))));
        };
        if !was_typed(arg, matches) && !goes_with_none(&command, arg, matches) {
            words.extend(words_of(arg, value.get_ref()).map_err(|what| wrong(value.span(), what))?);
        }
    }
    Ok(Some(FromFile { path: path.clone(), words }))
}

/// A regular file of text.
fn read(path: &Path) -> Result<String, Failure> {
    let failed = |e: std::io::Error| Failure::new(4, e.to_string()).remedy("check the name").about(path);
    let refused = |what: &str| Failure::new(2, what).remedy("give a file of options in TOML").about(path);
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() || LARGEST < metadata.len() {
        return Err(refused("is no regular file of at most 1 MiB"));
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(LARGEST).read_to_end(&mut bytes)).map_err(failed)?;
    String::from_utf8(bytes).map_err(|_| refused("is no UTF-8 text"))
}

/// Line and column, from 1.
fn place(text: &str, at: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(at)];
    let line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}

/// A command with the options that all commands have.
pub(crate) fn command(all: &Command, name: &str) -> Command {
    let mut all = all.clone();
    all.build();
    all.find_subcommand(name).cloned().unwrap_or_default()
}

/// The command with nothing required.
pub(crate) fn optional(command: Command) -> Command {
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let command = command.mut_args(|arg| arg.required(false));
    names.into_iter().fold(command, |command, name| command.mut_subcommand(name, optional))
}

/// The option of this long name, unless a file of options cannot hold it.
fn option<'a>(command: &'a Command, long: &str) -> Option<&'a Arg> {
    let never = ["config", "save-config", "help", "version"].contains(&long);
    command.get_arguments().find(|arg| !never && arg.get_long() == Some(long))
}

pub(crate) fn was_typed(arg: &Arg, matches: &ArgMatches) -> bool {
    matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine)
}

/// True if words or a file say anything but what it is by default.
pub(crate) fn says_other(arg: &Arg, matches: &ArgMatches) -> bool {
    let values = matches.get_raw(arg.get_id().as_str()).into_iter().flatten();
    was_typed(arg, matches) && !values.eq(arg.get_default_values().iter().map(|value| &**value))
}

/// Something was typed that the option cannot go with.
fn goes_with_none(command: &Command, arg: &Arg, matches: &ArgMatches) -> bool {
    let names = |a: &Arg, b: &Arg| command.get_arg_conflicts_with(a).iter().any(|c| c.get_id() == b.get_id());
    command.get_arguments().any(|other| (names(arg, other) || names(other, arg)) && was_typed(other, matches))
}

/// `--option=value`, as often as it is given.
fn words_of(arg: &Arg, value: &DeValue<'_>) -> Result<Vec<OsString>, Wrong> {
    let long = arg.get_long().unwrap_or_default();
    let takes_value = arg.get_action().takes_values();
    let word = |text: &str| OsString::from(format!("--{long}={text}"));
    match value {
        DeValue::Boolean(on) if !takes_value => Ok(if *on { vec![format!("--{long}").into()] } else { vec![] }),
        _ if !takes_value => Err(Wrong::new(format!("'{long}' is a switch"), "write true or false")),
        DeValue::String(text) => Ok(vec![word(text)]),
        DeValue::Integer(number) => Ok(vec![word(&number.to_string())]),
        DeValue::Float(number) => Ok(vec![word(&number.to_string())]),
        DeValue::Array(values) if matches!(arg.get_action(), ArgAction::Append) => {
            let several = arg.get_num_args().map_or(1, |n| n.min_values());
            if 1 < several {
                return words_of_several(long, several, values);
            }
            values.iter().map(|v| words_of(arg, v.get_ref())).collect::<Result<Vec<_>, _>>().map(|w| w.concat())
        }
        _ => Err(Wrong::new(format!("'{long}' takes text or a number"), "write it as on the command line")),
    }
}

/// `--option a b`, as often as there are so many values.
fn words_of_several(long: &str, several: usize, values: &DeArray<'_>) -> Result<Vec<OsString>, Wrong> {
    let remedy = format!("write a list of a multiple of {several}");
    let wrong = || Wrong::new(format!("'{long}' takes {several} texts each time"), remedy);
    let texts = values.iter().map(|v| v.get_ref().as_str().map(OsString::from)).collect::<Option<Vec<_>>>();
    let texts = texts.filter(|t| t.len().is_multiple_of(several)).ok_or_else(wrong)?;
    let option = OsString::from(format!("--{long}"));
    Ok(texts.chunks(several).flat_map(|some| std::iter::once(option.clone()).chain(some.iter().cloned())).collect())
}

/// The options of a command as used, defaults among them, in the form that `--config` reads. What a run reads and
/// writes and how it is watched stays out, and so do defaults that something typed overrules.
pub(crate) fn saved(all: &Command, typed: &ArgMatches) -> Result<String, Failure> {
    let Some((name, matches)) = typed.subcommand() else { return Ok(String::new()) };
    let mut table = toml::Table::new();
    let command = command(all, name);
    for arg in command.get_arguments() {
        let Some(long) = arg.get_long() else { continue };
        let stays_out = BESIDE.contains(&long) || long == "config" || (arg.is_global_set() && long != "seed");
        if stays_out || (!was_typed(arg, matches) && goes_with_none(&command, arg, matches)) {
            continue;
        }
        if let Some(value) = value_of(arg, matches)? {
            table.insert(long.to_owned(), value);
        }
    }
    Ok(format!("# Options of `selvedge {name}`, version {}.\n{table}", env!("CARGO_PKG_VERSION")))
}

fn value_of(arg: &Arg, matches: &ArgMatches) -> Result<Option<toml::Value>, Failure> {
    let id = arg.get_id().as_str();
    if !arg.get_action().takes_values() {
        return Ok(Some(toml::Value::Boolean(matches.get_flag(id))));
    }
    let Some(raw) = matches.get_raw(id) else { return Ok(None) };
    let values = raw.map(text_or_number).collect::<Result<Vec<_>, _>>()?;
    Ok(match arg.get_action() {
        ArgAction::Append => Some(toml::Value::Array(values)),
        _ => values.into_iter().next(),
    })
}

/// Numbers stay numbers where nothing is lost by it.
fn text_or_number(raw: &OsStr) -> Result<toml::Value, Failure> {
    let no_text =
        || Failure::new(2, format!("'{}' is no text for --save-config", raw.to_string_lossy())).remedy("rename it");
    let text = raw.to_str().ok_or_else(no_text)?;
    let integer = text.parse::<i64>().ok().filter(|n| n.to_string() == text).map(toml::Value::Integer);
    let float = || text.parse::<f64>().ok().filter(|n| n.is_finite() && n.to_string() == text).map(toml::Value::Float);
    Ok(integer.or_else(float).unwrap_or_else(|| toml::Value::String(text.to_owned())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_from_one() {
        assert_eq!(place("a = 1\nb = é2", 0), (1, 1));
        assert_eq!(place("a = 1\nbé = 2", 9), (2, 3));
        assert_eq!(place("a", 99), (1, 2));
    }

    #[test]
    fn numbers_are_kept_only_where_nothing_is_lost() {
        let value = |text: &str| text_or_number(OsStr::new(text)).unwrap().to_string();
        assert_eq!([value("12"), value("0.1"), value("-3")], ["12", "0.1", "-3"]);
        assert_eq!([value("0012"), value("1e3"), value("nan")], ["\"0012\"", "\"1e3\"", "\"nan\""]);
        assert_eq!(value("18446744073709551615"), "\"18446744073709551615\"", "beyond what TOML counts");
    }
}
