//! `selvedge again`: the command that a picture carries, run once more over the same files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Arg, Args, Command, ValueHint};
use selvedge_io::clip::Range;
use selvedge_io::{Fingerprint, Provenance, one_line};

use crate::clips;
use crate::config;
use crate::failure::{Failure, shown};
use crate::inputs::{Either, Input};
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::is_used;

/// Options of `again`.
#[derive(Args, Debug)]
pub(crate) struct Again {
    /// A picture or a source map that carries how it was made. See 'selvedge info'.
    #[arg(value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    picture: PathBuf,
    /// The picture to write. Where the command lays planes with --with, '{name}' or '{stem}' stand for their names.
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
    /// Folders where its inputs may lie, besides that of PICTURE and the working folder; they are known by their
    /// content.
    #[arg(long, value_name = "DIR", num_args = 1.., value_hint = ValueHint::DirPath)]
    look_in: Vec<PathBuf>,
}

impl Again {
    /// Runs the command: hands the words of what the picture carries, a command of `program`, to `run`, with its seed
    /// and its inputs as they are here.
    pub(crate) fn run(
        &self,
        session: &Session<'_>,
        program: &Command,
        run: &dyn Fn(&[OsString]) -> Result<Done, Failure>,
    ) -> Result<Done, Failure> {
        let mut report = Report::new("again");
        outputs::check(session, &[&self.output], std::slice::from_ref(&self.picture))?;
        let input = Input::new(session, &self.picture)?;
        // A picture that is written in its own format by the version that made it has the same bytes.
        let (metadata, format) = match input.look(session, &mut report)? {
            Either::Picture(header) => (header.metadata, Some(header.format)),
            Either::Map(file) => (file.metadata, None),
        };
        let nothing = || Failure::new(3, "does not say how it was made").remedy("give a picture that selvedge wrote");
        let made = metadata.provenance.ok_or_else(|| nothing().about(&self.picture))?;
        if made.version != env!("CARGO_PKG_VERSION") {
            let what = format!("was made by version {}; this one may make it otherwise", made.version);
            session.warn(&self.picture, &what);
        }
        let words = self.words(&made, program)?;
        let mut done = run(&words)?;
        let before = input.hash();
        let same = done.report.outputs.iter().any(|output| output["blake3"] == before.as_str());
        if let Some(name) = twice(&made).filter(|_| !same && !session.global.dry_run) {
            let is_expected =
                made.version == env!("CARGO_PKG_VERSION") && format == outputs::format(&self.output, None, None).ok();
            let what = format!("two of its files had the name '{name}'");
            if is_expected {
                let what = format!("{what}, and as they were found they do not give it");
                let remedy = "run the command that 'selvedge info' tells, with each file in its place";
                return Err(Failure::new(3, what).about(&self.picture).remedy(remedy));
            }
            session.warn(&self.picture, &format!("{what}: look whether each stands in its place"));
        }
        let verdict = if same { "the same bytes as" } else { "made as" };
        if let Some(line) = done.lines.last_mut() {
            *line += &format!("; {verdict} '{}'", shown(&self.picture));
        }
        Ok(done)
    }

    /// The command of a picture with its inputs where they are now.
    fn words(&self, made: &Provenance, program: &Command) -> Result<Vec<OsString>, Failure> {
        let words = unquoted(&made.command);
        if words.len() < 2 || words[0] != "selvedge" || words[1] == "again" {
            let what = format!("carries no command of selvedge: {}", made.command);
            return Err(Failure::new(3, what).about(&self.picture).remedy("give a picture that selvedge wrote"));
        }
        let command = config::command(program, &words[1]);
        if let Some(option) = words[2..].iter().find(|word| !is_canonical(word, &command)) {
            let what = format!("carries the option {}, which no picture of selvedge does", one_line(option));
            return Err(Failure::new(3, what).about(&self.picture).remedy("give a picture that selvedge wrote"));
        }
        let range = words.iter().skip_while(|word| *word != "--range").nth(1).and_then(|word| clips::range(word).ok());
        let files = made.inputs.iter().map(|input| self.find(input, range)).collect::<Result<Vec<_>, Failure>>()?;
        let mut left: Vec<Option<(&str, &Path)>> =
            made.inputs.iter().zip(&files).map(|(input, file)| Some((input.name.as_str(), file.as_path()))).collect();
        let mut found = |word: &str| {
            let word = if word.starts_with("./-") { &word[2..] } else { word };
            let named = |one: &Option<(&str, &Path)>| one.is_some_and(|(name, _)| name == word);
            // Files of one name are told apart by their order, in which they were read.
            left.iter().position(named).and_then(|i| left[i].take()).map(|(_, file)| file.to_path_buf())
        };
        let mut all: Vec<OsString> = words[..2].iter().map(OsString::from).collect();
        let mut names_files = true;
        for word in &words[2..] {
            if let Some(long) = word.strip_prefix("--") {
                names_files = command.get_arguments().any(|arg| arg.get_long() == Some(long) && takes_files(arg));
            }
            if !names_files {
                all.push(word.into());
                continue;
            }
            if let Some(file) = found(word) {
                all.push(file.into_os_string());
                continue;
            }
            let mut listed = || {
                let parts: Vec<PathBuf> = word.split(',').map(&mut found).collect::<Option<_>>()?;
                let mut list = OsString::new();
                for (i, part) in parts.into_iter().enumerate() {
                    list.push(if i == 0 { "" } else { "," });
                    list.push(part);
                }
                Some(list)
            };
            all.push(listed().unwrap_or_else(|| word.into()));
        }
        all.extend(["-o".into(), self.output.clone().into_os_string()]);
        Ok(all)
    }

    /// The file of this content, sought by its name first; or the name of files that have it together.
    fn find(&self, input: &Fingerprint, range: Option<Range>) -> Result<PathBuf, Failure> {
        let here = self.picture.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folders: Vec<&Path> = self.look_in.iter().map(PathBuf::as_path).chain([here, Path::new(".")]).collect();
        let (file, selector) = match input.name.strip_suffix(']').and_then(|name| name.rsplit_once('[')) {
            Some((file, channels)) => (file, format!("[{channels}]")),
            None => (input.name.as_str(), String::new()),
        };
        let mut other = None;
        if clips::is_pattern(Path::new(&input.name)) {
            for path in folders.iter().map(|folder| folder.join(&input.name)) {
                match frames(&path, range) {
                    Some(found) if found == input.blake3 => return Ok(path),
                    Some(_) => other = other.or(Some(path)),
                    None => {}
                }
            }
        }
        for folder in &folders {
            for (name, selector) in [(input.name.as_str(), ""), (file, selector.as_str())] {
                let path = folder.join(name);
                if path.is_file() {
                    if hash(&path) == input.blake3 {
                        return Ok(with_selector(path, selector));
                    }
                    other.get_or_insert(path);
                }
            }
        }
        // A name that is no text, or another one now.
        let entries = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
        files.sort();
        if let Some(path) = files.into_iter().find(|path| hash(path) == input.blake3) {
            return Ok(with_selector(path, &selector));
        }
        let shown = |path: &Path| Failure::new(3, "is not the file that it was").about(path);
        let failure = match other {
            Some(path) => shown(&path),
            None => Failure::new(4, "was read for it and is not found").named(&input.name),
        };
        Err(failure.remedy("name the folder of the right one with --look-in"))
    }
}

/// Whether a word is none of an option, or of one that a canonical command may have: one that changes samples, by its
/// long name, which its values follow as words of their own. A picture is anyone's file: it must not write or read
/// what its reader did not name.
fn is_canonical(word: &str, command: &Command) -> bool {
    let is_short = |rest: &str| rest.starts_with(|c: char| c.is_alphabetic());
    match word.strip_prefix("--") {
        Some("seed") => true,
        Some(long) => {
            let named = |arg: &Arg| arg.get_long() == Some(long) && !arg.is_global_set() && is_used(long);
            command.get_arguments().any(named)
        }
        None => !word.strip_prefix('-').is_some_and(is_short),
    }
}

/// Whether the values of an option are names of files.
fn takes_files(arg: &Arg) -> bool {
    matches!(arg.get_value_hint(), ValueHint::FilePath | ValueHint::DirPath | ValueHint::AnyPath)
}

/// A name that two different inputs had: which stood where, the command does not say.
fn twice(made: &Provenance) -> Option<&str> {
    let other = |a: &Fingerprint, b: &Fingerprint| a.name == b.name && a.blake3 != b.blake3;
    let found = made.inputs.iter().enumerate().find(|(i, one)| made.inputs[..*i].iter().any(|b| other(one, b)));
    found.map(|(_, one)| one.name.as_str())
}

fn with_selector(path: PathBuf, selector: &str) -> PathBuf {
    let mut path = path.into_os_string();
    path.push(selector);
    path.into()
}

/// What tells a sequence, in whole or as a range of it was read, or one of its frames alone.
fn frames(pattern: &Path, range: Option<Range>) -> Option<String> {
    let files = clips::files(pattern, range).or_else(|_| clips::files(pattern, None)).ok()?;
    let each = |path: &PathBuf| Fingerprint { name: String::new(), blake3: hash(path) };
    let each: Vec<Fingerprint> = files.iter().map(each).collect();
    Some(clips::fingerprint(pattern, &each).blake3)
}

/// The file's BLAKE3 in hexadecimal; empty where it cannot be read.
fn hash(path: &Path) -> String {
    let mut hasher = blake3::Hasher::new();
    let read = std::fs::File::open(path).and_then(|file| hasher.update_reader(file).map(drop));
    read.map_or(String::new(), |()| hasher.finalize().to_hex().to_string())
}

/// The words of a command as pictures carry it: single quotes, and within them a quote as `'\''`.
fn unquoted(command: &str) -> Vec<String> {
    let (mut words, mut word, mut any, mut within) = (Vec::new(), String::new(), false, false);
    let mut signs = command.chars();
    while let Some(sign) = signs.next() {
        match sign {
            '\'' => (within, any) = (!within, true),
            '\\' if !within => word.extend(signs.next()),
            ' ' if !within => {
                if any || !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
                any = false;
            }
            other => word.push(other),
        }
    }
    if any || !word.is_empty() {
        words.push(word);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::used::quoted;

    #[test]
    fn words_come_back_as_they_were() {
        let words = ["selvedge", "quilt", "it's.png", "", "a b", "\\'", "-x", "é\\n.png"];
        let command = words.map(quoted).join(" ");
        assert_eq!(unquoted(&command), words, "{command}");
    }
}
