//! Errors as the user sees them: one line, a code, and with `--json` an object.

use std::path::Path;
use std::sync::OnceLock;

use selvedge_core::ErrorKind;
use selvedge_io::one_line;
use serde_json::json;

use crate::stdio;

/// Where the first panic was.
static PLACE: OnceLock<String> = OnceLock::new();

/// Panics are noted instead of told: whoever catches one tells it with [`Failure::internal`].
pub(crate) fn catch_panics() {
    std::panic::set_hook(Box::new(|info| {
        if let Some(place) = info.location() {
            let _ = PLACE.set(format!("{}:{}", place.file(), place.line()));
        }
    }));
}

/// What ended the program.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    /// Exit code: 2 usage, 3 input, 4 files, 5 space, 6 memory, 70 ours, 130 and 143 signals.
    pub(crate) exit: u8,
    /// The file it is about.
    pub(crate) path: Option<String>,
    /// What is wrong, with the numbers.
    pub(crate) message: String,
    /// What to do.
    pub(crate) remedy: Option<String>,
}

impl Failure {
    /// From a message that names its remedy after a semicolon, if it names one.
    pub(crate) fn new(exit: u8, message: impl Into<String>) -> Self {
        let message = message.into();
        match message.split_once("; ") {
            Some((what, remedy)) => Self { exit, path: None, message: what.into(), remedy: Some(remedy.into()) },
            None => Self { exit, path: None, message, remedy: None },
        }
    }

    /// The same, about a file.
    #[must_use]
    pub(crate) fn about(self, path: &Path) -> Self {
        self.named(selvedge_io::path_text(path))
    }

    /// The same, about a file that is called so.
    #[must_use]
    pub(crate) fn named(mut self, path: impl Into<String>) -> Self {
        self.path = Some(path.into());
        self
    }

    /// The same with another remedy.
    #[must_use]
    pub(crate) fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// An error of a method or of the core; a wrong option that was fine by itself is wrong input.
    pub(crate) fn of(kind: ErrorKind, message: impl Into<String>) -> Self {
        let exit = match kind {
            ErrorKind::Option => 2,
            ErrorKind::Input => 3,
            ErrorKind::Memory => 6,
            _ => 70,
        };
        Self::new(exit, message)
    }

    /// A problem with a file that has a name only here.
    pub(crate) fn from_problem(path: &Path, problem: selvedge_io::Problem) -> Self {
        Self::from(selvedge_io::Error { path: path.to_path_buf(), problem })
    }

    /// The run was ended by a signal.
    pub(crate) fn interrupted(signal: u8) -> Self {
        // There is nothing to mend.
        Self { exit: 128 + signal, path: None, message: "interrupted; nothing was written".into(), remedy: None }
    }

    /// The run was ended by a signal, and what there was is in a file.
    pub(crate) fn kept(signal: u8, partial: &Path) -> Self {
        let message = format!("interrupted; the best so far is in '{}'", shown(partial));
        Self { message, ..Self::interrupted(signal) }
    }

    /// A panic was caught.
    pub(crate) fn internal(panic: &(dyn std::any::Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let (text, version) = (text.unwrap_or("no message"), env!("CARGO_PKG_VERSION"));
        let place = PLACE.get().map_or(String::new(), |place| format!(" at {place}"));
        let message = format!("internal error in version {version}{place}: {text}");
        Self { exit: 70, path: None, message, remedy: None }.remedy("please report it with the command and its input")
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> u8 {
        let path = self.path.as_ref().map_or(String::new(), |p| format!("'{p}': "));
        let remedy = self.remedy.as_ref().map_or(String::new(), |r| format!("; {r}"));
        stdio::tell(&format!("error: {}", one_line(&format!("{path}{}{remedy}", self.message))));
        if json {
            let error = json!({"exit": self.exit, "path": self.path, "message": self.message, "remedy": self.remedy});
            // Standard error has it already.
            let _ = stdio::answer(format!("{}\n", json!({ "error": error })).as_bytes());
        }
        self.exit
    }
}

impl From<selvedge_quilting::Error> for Failure {
    fn from(error: selvedge_quilting::Error) -> Self {
        Self::of(error.kind(), error.to_string())
    }
}

impl From<selvedge_graphcut_textures::Error> for Failure {
    fn from(error: selvedge_graphcut_textures::Error) -> Self {
        Self::of(error.kind(), error.to_string())
    }
}

impl From<selvedge_blending::Error> for Failure {
    fn from(error: selvedge_blending::Error) -> Self {
        Self::of(error.kind(), error.to_string())
    }
}

impl From<selvedge_core::Error> for Failure {
    fn from(error: selvedge_core::Error) -> Self {
        Self::of(error.kind(), error.to_string())
    }
}

/// A number of things: `1 block`, `2 blocks`.
pub(crate) fn n(thing: &str, number: impl Into<usize>) -> String {
    let number = number.into();
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// A path as text in one line, whatever bytes it holds.
pub(crate) fn shown(path: &Path) -> String {
    one_line(&selvedge_io::path_text(path))
}
