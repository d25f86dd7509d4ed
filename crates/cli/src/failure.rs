//! Errors as the user sees them: one line, a code, and with `--json` an object.

use std::path::Path;
use std::process::ExitCode;

use selvedge_core::ErrorKind;
use serde_json::json;

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
    /// From a message that names its remedy after a semicolon.
    pub(crate) fn new(exit: u8, message: impl Into<String>) -> Self {
        let message = message.into();
        match message.split_once("; ") {
            Some((what, remedy)) => Self { exit, path: None, message: what.into(), remedy: Some(remedy.into()) },
            None => Self { exit, path: None, message, remedy: None },
        }
    }

    /// The same, about a file.
    #[must_use]
    pub(crate) fn about(mut self, path: &Path) -> Self {
        self.path = Some(shown(path));
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

    /// The run was ended by a signal.
    pub(crate) fn interrupted(signal: u8) -> Self {
        Self::new(128 + signal, "interrupted; nothing was written")
    }

    /// A panic was caught.
    pub(crate) fn internal(panic: &(dyn std::any::Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let (text, version) = (text.unwrap_or("no message"), env!("CARGO_PKG_VERSION"));
        Self::new(
            70,
            format!("internal error in version {version}: {text}; please report it with the command and its input"),
        )
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> ExitCode {
        let path = self.path.as_ref().map_or(String::new(), |p| format!("'{p}': "));
        let remedy = self.remedy.as_ref().map_or(String::new(), |r| format!("; {r}"));
        eprintln!("error: {}", one_line(&format!("{path}{}{remedy}", self.message)));
        if json {
            let error = json!({"exit": self.exit, "path": self.path, "message": self.message, "remedy": self.remedy});
            println!("{}", json!({ "error": error }));
        }
        ExitCode::from(self.exit)
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

impl From<selvedge_core::Error> for Failure {
    fn from(error: selvedge_core::Error) -> Self {
        Self::of(error.kind(), error.to_string())
    }
}

/// A path as text; bytes that are no UTF-8 are replaced.
pub(crate) fn shown(path: &Path) -> String {
    one_line(&path.to_string_lossy())
}

/// Control characters are escaped, so that a message stays one line.
fn one_line(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect::<Vec<_>>() } else { vec![c] }).collect()
}

/// Help and version are answers; anything else is a usage error in one line.
pub(crate) fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Nobody listens: that is the listener's business.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.to_string();
    let lines: Vec<&str> = text.lines().take_while(|l| !l.starts_with("Usage:")).map(str::trim).collect();
    let joined = lines.join(" ");
    let message = joined
        .strip_prefix("error: ")
        .unwrap_or(&joined)
        .trim()
        .trim_end_matches("For more information, try '--help'.")
        .trim();
    let json = std::env::args_os().any(|a| a == "--json");
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    Failure { exit: 2, path: None, message, remedy: Some("see --help".into()) }.tell(json)
}
