//! The surroundings of one command.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use selvedge_core::{Limits, Run, Seed, SimdLevel};
use selvedge_io::Fingerprint;

use crate::args::Global;
use crate::available;
use crate::failure::{Failure, shown};
use crate::made;
use crate::stdio;
use crate::used::Used;
use crate::watch::Watch;

/// The surroundings of one command: options of all commands, who watches, how much it may use.
pub(crate) struct Session<'a> {
    pub(crate) global: &'a Global,
    pub(crate) watch: Watch,
    pub(crate) limits: Limits,
    /// The options that change samples, as typed.
    pub(crate) options: Used,
    /// Long names of the options that were typed.
    typed: Vec<String>,
    /// All that the run reads, as far as it is known.
    inputs: Arc<Mutex<Vec<PathBuf>>>,
    /// The marks of what was read, where some are expected.
    marks: Arc<Mutex<Vec<String>>>,
    /// Frames of containers, as files by names of their own.
    frames: Arc<Mutex<BTreeMap<PathBuf, Vec<u8>>>>,
    /// The folder from which the run can be gone on with.
    kept: Arc<OnceLock<PathBuf>>,
}

impl<'a> Session<'a> {
    pub(crate) fn new(global: &'a Global, options: Used, typed: Vec<String>) -> Self {
        let memory = global.max_memory.map_or_else(half_of_available, |bytes| bytes.0);
        Self {
            global,
            watch: Watch::new(global),
            limits: Limits { memory, ..Limits::default() },
            options,
            typed,
            inputs: Arc::default(),
            marks: Arc::default(),
            frames: Arc::default(),
            kept: Arc::default(),
        }
    }

    /// A run within this one: it is watched as this one is, has `held` bytes less to use, and what it reads is read by
    /// both.
    pub(crate) fn within<'g>(
        &self,
        global: &'g Global,
        (options, typed): (Used, Vec<String>),
        held: u64,
    ) -> Session<'g> {
        let limits = Limits { memory: self.limits.memory.saturating_sub(held), ..self.limits };
        let (inputs, marks, frames) = (self.inputs.clone(), self.marks.clone(), self.frames.clone());
        let (watch, kept) = (self.watch.clone(), self.kept.clone());
        Session { global, watch, limits, options, typed, inputs, marks, frames, kept }
    }

    /// The first option of these that was typed, as it is typed.
    pub(crate) fn first_typed(&self, names: &[impl AsRef<str>]) -> Option<String> {
        let typed = |name: &str| self.typed.iter().any(|typed| typed == name);
        names.iter().map(AsRef::as_ref).find(|name| typed(name)).map(|name| format!("--{name}"))
    }

    /// Notes files that the run reads.
    pub(crate) fn reads(&self, files: impl IntoIterator<Item = PathBuf>) {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner).extend(files);
    }

    /// All that the run reads, as far as it is known.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Holds a frame of a container as a file that is read from there, once.
    pub(crate) fn hold(&self, path: PathBuf, bytes: Vec<u8>) {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner).insert(path, bytes);
    }

    /// Hands out what is held by this name.
    pub(crate) fn held(&self, path: &Path) -> Option<Vec<u8>> {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner).remove(path)
    }

    /// Refuses a file that is none of those of `--expect`.
    pub(crate) fn expect(&self, input: &Fingerprint) -> Result<(), Failure> {
        let expected = &self.global.expect;
        if expected.is_empty() {
            return Ok(());
        }
        let mark = made::mark(input);
        if expected.contains(&mark) {
            self.marks.lock().unwrap_or_else(PoisonError::into_inner).push(mark);
            return Ok(());
        }
        let failure = Failure::new(3, "is not the file that it was").named(&input.name);
        Err(failure.remedy("give the one that the picture was made from; 'selvedge again' finds it by its content"))
    }

    /// Refuses a run that did not read all files of `--expect`: of two that had one name it read one twice.
    pub(crate) fn expected(&self) -> Result<(), Failure> {
        let marks = self.marks.lock().unwrap_or_else(PoisonError::into_inner);
        match self.global.expect.iter().find(|mark| !marks.contains(mark)) {
            Some(mark) if !self.global.dry_run => {
                let failure = Failure::new(3, format!("no file that was read has the mark {mark} of --expect"));
                Err(failure.remedy("use 'selvedge again', which finds files by their content"))
            }
            _ => Ok(()),
        }
    }

    /// What methods are handed.
    pub(crate) fn run<const D: usize>(&self) -> Run<'_, D> {
        Run { seed: Seed(self.global.seed()), limits: self.limits, observer: &self.watch, simd: SimdLevel::Auto }
    }

    /// Ends a run that a signal cancelled. Called between the steps of commands that cannot be cancelled within.
    pub(crate) fn check_signal(&self) -> Result<(), Failure> {
        self.watch.signal().map_or(Ok(()), |signal| Err(self.interrupted(signal)))
    }

    /// What a signal ended, and whether that can be gone on with.
    pub(crate) fn interrupted(&self, signal: u8) -> Failure {
        self.kept.get().map_or_else(|| Failure::interrupted(signal), |folder| Failure::resumable(signal, folder))
    }

    /// Notes that the run can be gone on with from what is kept in a folder.
    pub(crate) fn is_kept_in(&self, folder: &Path) {
        self.kept.get_or_init(|| folder.to_path_buf());
    }

    /// A line for people, on standard error.
    pub(crate) fn say(&self, line: &str) {
        if !self.global.quiet {
            stdio::tell(line);
        }
    }

    /// A line for people who want to know more.
    pub(crate) fn detail(&self, line: &str) {
        if self.global.verbose {
            stdio::tell(line);
        }
    }

    /// A line about something odd that stops nobody.
    pub(crate) fn warn(&self, path: &Path, what: &dyn std::fmt::Display) {
        self.say(&format!("warning: '{}': {what}", shown(path)));
    }
}

/// Half of the memory that is available; no bound where the system does not say.
fn half_of_available() -> u64 {
    available::memory().map_or(u64::MAX, |bytes| bytes / 2)
}
