//! What a long run has come to, in a folder, from where another goes on.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain};
use serde_json::Value;

use crate::failure::Failure;
use crate::session::Session;
use crate::stdio;

/// The one file in the folder.
const NAME: &str = "checkpoint";

/// Where runs are kept.
#[derive(Args, Clone, Debug)]
pub(crate) struct KeptArgs {
    /// Keep what was woven so far in this folder, every ten seconds and when a signal ends the run.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    checkpoint: Option<PathBuf>,
    /// Go on from what --checkpoint kept in this folder: the output is the same as if the run had not ended.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    resume: Option<PathBuf>,
}

/// A run that is kept.
pub(crate) struct Kept<'a> {
    session: &'a Session<'a>,
    file: Option<PathBuf>,
    /// What it follows from.
    head: Value,
}

/// A run that is gone on from.
pub(crate) struct Begun<T> {
    /// What the method needs of it.
    pub(crate) from: T,
    /// What else is told of it.
    pub(crate) head: Value,
}

impl KeptArgs {
    /// Whether anything is kept or read.
    pub(crate) fn is_asked(&self) -> bool {
        self.checkpoint.is_some() || self.is_resumed()
    }

    /// Whether it goes on from another run.
    pub(crate) fn is_resumed(&self) -> bool {
        self.resume.is_some()
    }

    /// Refuses several sizes of what is woven: what is kept is what stands at one.
    pub(crate) fn check_levels(&self, levels: Option<u32>) -> Result<(), Failure> {
        match levels {
            Some(2..) if self.is_asked() => {
                let what = "--checkpoint and --resume are for runs at one size";
                Err(Failure::new(2, what).remedy("use --levels 1, or leave them out"))
            }
            _ => Ok(()),
        }
    }

    /// What keeping what was woven of an output takes.
    pub(crate) fn bytes<const D: usize>(&self, output: Domain<D>) -> Bytes {
        // What is read again stands beside the output until the run ends.
        let of_sample = if self.is_resumed() { 16 } else { 12 };
        if self.is_asked() { Bytes::of_samples(output, of_sample) + Bytes(1 << 20) } else { Bytes(0) }
    }

    /// What there is to go on from, as `read` takes it; a run that followed from anything else than `head`, and what
    /// `read` takes for damaged, is refused.
    pub(crate) fn begun<T>(
        &self,
        head: &Value,
        read: impl FnOnce(&[u8]) -> Option<T>,
    ) -> Result<Option<Begun<T>>, Failure> {
        let Some(folder) = &self.resume else { return Ok(None) };
        let file = folder.join(NAME);
        let wrong = |what: String| Failure::new(3, what).about(&file).remedy("begin again, without --resume");
        let no_file = |e| Failure::new(4, stdio::plain(&e)).about(&file).remedy("check the folder");
        let bytes = fs::read(&file).map_err(no_file)?;
        let damaged = || wrong("is no checkpoint, or is damaged".into());
        let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(damaged)?;
        let (found, made) = (&bytes[..end], &bytes[end + 1..]);
        let found: Value = serde_json::from_slice(found).map_err(|_| damaged())?;
        if found["blake3"] != blake3::hash(made).to_hex().as_str() {
            return Err(damaged());
        }
        for (field, expected) in head.as_object().into_iter().flatten() {
            if found[field] != *expected {
                let differs = match (found[field].as_str(), expected.as_str()) {
                    (Some(was), Some(is)) if field == "options" => differing(was, is),
                    _ => found[field].to_string(),
                };
                return Err(wrong(format!("is the checkpoint of another {field}, {differs}")));
            }
        }
        Ok(Some(Begun { from: read(made).ok_or_else(damaged)?, head: found }))
    }

    /// Where the run is kept that follows from what `head` tells.
    pub(crate) fn open<'a>(&self, session: &'a Session<'a>, head: Value) -> Result<Kept<'a>, Failure> {
        if let Some(folder) = &self.checkpoint {
            let failed = |e| Failure::new(4, stdio::plain(&e)).about(folder).remedy("choose another folder");
            fs::create_dir_all(folder).map_err(failed)?;
        }
        Ok(Kept { session, file: self.checkpoint.as_ref().map(|folder| folder.join(NAME)), head })
    }
}

/// The first option by which a command differs from what is asked for.
fn differing(was: &str, is: &str) -> String {
    let options = |command: &str| command.split(" --").skip(1).map(str::to_owned).collect::<Vec<_>>();
    let (was_with, is_with) = (options(was), options(is));
    let only = |of: &[String], in_other: &[String]| of.iter().find(|option| !in_other.contains(option)).cloned();
    match (only(&was_with, &is_with), only(&is_with, &was_with)) {
        (Some(option), _) => format!("with --{option}"),
        (None, Some(option)) => format!("without --{option}"),
        (None, None) => was.to_owned(),
    }
}

impl Kept<'_> {
    /// Keeps it as it is, if that is asked, with what else is told of it; a folder that takes no more is warned of.
    pub(crate) fn keep(&self, more: &[(&str, Value)], made: &dyn Fn() -> Vec<u8>) {
        let Some(file) = &self.file else { return };
        let made = made();
        let mut head = self.head.clone();
        head["blake3"] = blake3::hash(&made).to_hex().as_str().into();
        more.iter().for_each(|(field, value)| head[*field] = value.clone());
        let bytes = [stdio::object(&head).as_bytes(), b"\n", &made].concat();
        match selvedge_io::write_bytes(file, &bytes, false) {
            Ok(_) => file.parent().into_iter().for_each(|folder| self.session.is_kept_in(folder)),
            Err(error) => self.session.say(&format!("warning: {}", Failure::from(error).message)),
        }
    }
}
