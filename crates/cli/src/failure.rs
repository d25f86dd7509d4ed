//! Errors as the user sees them: one line, a code, and with `--json` an object.

use std::io;
use std::path::Path;
use std::sync::OnceLock;

use selvedge_core::ErrorKind;
use selvedge_io::{Format, Problem, one_line};
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
    /// Exit code: 2 usage, 3 input, 4 files, 5 space, 6 memory, 70 ours, 129, 130 and 143 signals.
    pub(crate) exit: u8,
    /// The file it is about.
    pub(crate) path: Option<String>,
    /// What is wrong, with the numbers.
    pub(crate) message: String,
    /// What to do.
    pub(crate) remedy: Option<String>,
    /// If a signal ended the run: what is left of it.
    pub(crate) left: Option<String>,
}

impl Failure {
    /// What is wrong; a remedy goes beside it, since either may hold any sign.
    pub(crate) fn new(exit: u8, message: impl Into<String>) -> Self {
        Self { exit, path: None, message: message.into(), remedy: None, left: None }
    }

    /// The same, about a file.
    #[must_use]
    pub(crate) fn about(self, path: &Path) -> Self {
        self.named(selvedge_io::path_text(path))
    }

    /// The same, about a file where it is about none yet.
    #[must_use]
    pub(crate) fn or_about(self, path: &Path) -> Self {
        if self.path.is_some() { self } else { self.about(path) }
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

    /// An error of a crate: what is wrong, what to do, and who can mend it. A wrong option that was fine by itself is
    /// wrong input.
    pub(crate) fn of(kind: ErrorKind, what: &dyn std::fmt::Display, remedy: impl Into<String>) -> Self {
        Self::new(exit(kind), what.to_string()).remedy(remedy)
    }

    /// A problem with a file that has a name only here.
    pub(crate) fn from_problem(path: &Path, problem: Problem) -> Self {
        Self::from(selvedge_io::Error { path: path.to_path_buf(), problem })
    }

    /// The run was ended by a signal.
    pub(crate) fn interrupted(signal: u8) -> Self {
        // There is nothing to mend.
        Self::new(128 + signal, "interrupted; nothing was written")
    }

    /// The run was ended by a signal when its files, or those of its first frames, had their names.
    pub(crate) fn late(signal: u8) -> Self {
        Self::leaving(signal, "what was finished is written".into())
    }

    /// The run was ended by a signal, and what there was is in a file.
    pub(crate) fn kept(signal: u8, partial: &Path) -> Self {
        Self::leaving(signal, format!("the best so far is in '{}'", shown(partial)))
    }

    /// The run was ended by a signal, and can be gone on with from what is kept in a folder.
    pub(crate) fn resumable(signal: u8, folder: &Path) -> Self {
        Self::leaving(signal, format!("go on with --resume '{}'", shown(folder)))
    }

    fn leaving(signal: u8, left: String) -> Self {
        Self { left: Some(left.clone()), ..Self::new(128 + signal, format!("interrupted; {left}")) }
    }

    /// The same where so many runs or frames before it are written.
    pub(crate) fn after(self, thing: &str, number: usize) -> Self {
        let rest = self.left.as_ref().map_or(String::new(), |left| format!(", and {left}"));
        let (things, were) = (n(thing, number), if number == 1 { "was" } else { "were" });
        let message = format!("interrupted; {things} before {were} written{rest}");
        Self { message, ..self }
    }

    /// What ended a run, by a signal or not, where so many frames are written.
    pub(crate) fn among(self, by_signal: bool, thing: &str, number: usize) -> Self {
        if number == 0 {
            return self;
        }
        if by_signal {
            return self.after(thing, number);
        }
        let there = format!("{} before {} written", n(thing, number), are(number));
        let remedy = self.remedy.as_ref().map_or(String::new(), |remedy| format!("{remedy}; "));
        self.remedy(format!("{remedy}{there}"))
    }

    /// A panic was caught.
    pub(crate) fn internal(panic: &(dyn std::any::Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let (text, version) = (text.unwrap_or("no message"), env!("CARGO_PKG_VERSION"));
        let place = PLACE.get().map_or(String::new(), |place| format!(" at {place}"));
        let message = format!("internal error in version {version}{place}: {text}");
        Self::new(70, message).remedy("please report it with the command and its input")
    }

    /// Standard output took nothing more.
    pub(crate) fn of_stream(error: &io::Error) -> Self {
        use io::ErrorKind as Io;
        let no_space = matches!(error.kind(), Io::StorageFull | Io::QuotaExceeded | Io::FileTooLarge);
        let what = if error.kind() == Io::BrokenPipe { "its reader has left".into() } else { stdio::plain(error) };
        Self::new(if no_space { 5 } else { 4 }, what).remedy("redirect it elsewhere").named("standard output")
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> u8 {
        self.shortened().tell_all(json)
    }

    /// The same in a line that people can read: of what is too long both ends are kept.
    fn shortened(&self) -> Self {
        if one_line(&self.line()).len() <= stdio::LONGEST {
            return self.clone();
        }
        // Together with what stands between them they are less than the longest line.
        let cut = |text: &String, most| stdio::shortened(&one_line(text), most);
        let [path, message, remedy] = [120, 250, 110];
        Self {
            exit: self.exit,
            path: self.path.as_ref().map(|text| cut(text, path)),
            message: cut(&self.message, message),
            remedy: self.remedy.as_ref().map(|text| cut(text, remedy)),
            left: None,
        }
    }

    /// The line for people.
    fn line(&self) -> String {
        let path = self.path.as_ref().map_or(String::new(), |p| format!("'{p}': "));
        let remedy = self.remedy.as_ref().map_or(String::new(), |r| format!("; {r}"));
        format!("error: {path}{}{remedy}", self.message)
    }

    fn tell_all(&self, json: bool) -> u8 {
        stdio::tell(&self.line());
        if json {
            let error = json!({"exit": self.exit, "path": self.path, "message": self.message, "remedy": self.remedy});
            // Standard error has it already.
            let _ = stdio::answer(format!("{}\n", stdio::object(&json!({ "error": error }))).as_bytes());
        }
        self.exit
    }
}

/// The exit code of an error that so many can mend.
pub(crate) fn exit(kind: ErrorKind) -> u8 {
    match kind {
        ErrorKind::Option => 2,
        ErrorKind::Input => 3,
        ErrorKind::FileSystem => 4,
        ErrorKind::NoSpace => 5,
        ErrorKind::Memory => 6,
        _ => 70,
    }
}

/// Errors of crates, all of one shape.
macro_rules! from_errors {
    ($($error:ty),+) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::of(error.kind(), &error, error.remedy())
            }
        })+
    };
}
from_errors!(
    selvedge_blending::Error,
    selvedge_cms_analogies::Error,
    selvedge_core::Error,
    selvedge_analysis::Error,
    selvedge_guides::Error,
    selvedge_metrics::Error,
    selvedge_synthesis::Error,
    selvedge_quilting::Error,
    selvedge_graphcut_textures::Error,
    selvedge_hybrid::Error,
    selvedge_texture_optimization::Error
);

impl From<selvedge_io::Error> for Failure {
    fn from(error: selvedge_io::Error) -> Self {
        let remedy = by_option(&error.problem).unwrap_or_else(|| error.remedy());
        Self::new(exit(error.kind()), error.message()).remedy(remedy).about(&error.path)
    }
}

/// What an option of this program does about a problem with a file.
fn by_option(problem: &Problem) -> Option<String> {
    Some(match problem {
        Problem::DepthNotHeld { format, depth } => {
            let depths: Vec<&str> = format.depths().iter().map(|d| d.name()).collect();
            format!("use --depth {}, or write {}", depths.join("|"), Format::holding(*depth))
        }
        Problem::NotFinite { .. } => "use --nonfinite zero or --nonfinite clamp".into(),
        Problem::NotAMap { .. } => "give a file written with --map".into(),
        Problem::Special => "give a regular file, or '-' for a stream".into(),
        Problem::Exists => "choose another name, or leave out --no-clobber".into(),
        Problem::Memory { .. } => "give a smaller picture, or raise --max-memory".into(),
        _ => return None,
    })
}

/// A number of things: `1 block`, `2 blocks`.
pub(crate) fn n(thing: &str, number: impl Into<usize>) -> String {
    let number = number.into();
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// What so many things do: one is, others are.
pub(crate) fn are(number: usize) -> &'static str {
    if number == 1 { "is" } else { "are" }
}

/// A path as text in one line, whatever bytes it holds.
pub(crate) fn shown(path: &Path) -> String {
    one_line(&selvedge_io::path_text(path))
}
