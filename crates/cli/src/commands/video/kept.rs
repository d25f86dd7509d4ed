//! What a run of patches has come to, in a folder, from where another goes on.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, ValueHint};
use selvedge_core::{SourceMap, Start, Woven};
use selvedge_graphcut_textures::{Checkpoint, Error, Plan, Stats};
use serde_json::{Value, json};

use crate::clips::Clip;
use crate::failure::Failure;
use crate::session::Session;
use crate::stdio;
use crate::used::Used;

/// The one file in the folder.
const NAME: &str = "checkpoint";
/// How much time of a run may be lost at most, where no signal says that it ends.
const EVERY: Duration = Duration::from_secs(10);

/// Where runs are kept.
#[derive(Args, Clone, Debug)]
pub(super) struct KeptArgs {
    /// Keep what was woven so far in this folder, every ten seconds and when a signal ends the run.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    checkpoint: Option<PathBuf>,
    /// Go on from what --checkpoint kept in this folder: the clip is the same as if the run had not ended.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    resume: Option<PathBuf>,
}

/// A run that is kept.
pub(super) struct Kept<'a> {
    session: &'a Session<'a>,
    file: Option<PathBuf>,
    /// What it follows from.
    head: Value,
    from: Option<Checkpoint<3>>,
}

impl KeptArgs {
    /// Whether anything is kept or read.
    pub(super) fn is_asked(&self) -> bool {
        self.checkpoint.is_some() || self.resume.is_some()
    }

    /// Reads what there is to go on from; a run of another clip, options or seed is refused.
    pub(super) fn open<'a>(&self, session: &'a Session<'a>, clip: &Clip, used: &Used) -> Result<Kept<'a>, Failure> {
        let head = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "clip": clip.fingerprint.blake3,
            "seed": session.global.seed(),
            "options": used.command("video", &[]),
        });
        let from = self.resume.as_ref().map(|folder| read(&folder.join(NAME), &head)).transpose()?;
        if let Some(folder) = &self.checkpoint {
            let failed = |e| Failure::new(4, stdio::plain(&e)).about(folder).remedy("choose another folder");
            fs::create_dir_all(folder).map_err(failed)?;
        }
        Ok(Kept { session, file: self.checkpoint.as_ref().map(|folder| folder.join(NAME)), head, from })
    }
}

impl Kept<'_> {
    /// Weaves from where it was, and keeps where it is.
    pub(super) fn weave(&self, plan: &Plan<'_, 3>, start: Start<3>) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
        let last = Cell::new(Instant::now());
        let mut keep = |made: &dyn Fn() -> Checkpoint<3>| {
            let Some(file) = &self.file else { return };
            if last.get().elapsed() < EVERY && self.session.watch.signal().is_none() {
                return;
            }
            if let Err(failure) = self.write(file, &made()) {
                self.session.say(&format!("warning: {}", failure.message));
            }
            last.set(Instant::now());
        };
        plan.weave_on(start, self.from.as_ref(), &self.session.run(), &mut keep)
    }

    fn write(&self, file: &Path, checkpoint: &Checkpoint<3>) -> Result<(), Failure> {
        let woven = checkpoint.to_bytes();
        let mut head = self.head.clone();
        head["blake3"] = blake3::hash(&woven).to_hex().as_str().into();
        let bytes = [stdio::object(&head).as_bytes(), b"\n", &woven].concat();
        Ok(selvedge_io::write_bytes(file, &bytes, false)?)
    }
}

/// A checkpoint of the run that this head tells of.
fn read(file: &Path, expected: &Value) -> Result<Checkpoint<3>, Failure> {
    let wrong = |what: String| Failure::new(3, what).about(file).remedy("begin again, without --resume");
    let bytes = fs::read(file).map_err(|e| Failure::new(4, stdio::plain(&e)).about(file).remedy("check the folder"))?;
    let damaged = || wrong("is no checkpoint, or is damaged".into());
    let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(damaged)?;
    let (head, woven) = (&bytes[..end], &bytes[end + 1..]);
    let head: Value = serde_json::from_slice(head).map_err(|_| damaged())?;
    if head["blake3"] != blake3::hash(woven).to_hex().as_str() {
        return Err(damaged());
    }
    for (field, expected) in expected.as_object().into_iter().flatten() {
        if head[field] != *expected {
            let what = format!("is the checkpoint of another {field}, {}", head[field]);
            return Err(wrong(what));
        }
    }
    Checkpoint::of_bytes(woven).map_err(|_| damaged())
}
