//! Containers of other programs, by an `ffmpeg` that is installed: mp4, mov, webm, mkv and avi. Sound is left out.
//!
//! Frames come and go raw, through pipes: a header of their own tells size and depth of those that come (PAM), so that
//! nothing else has to be asked. Arguments are a list, no shell sees them; files are named as such, so that no name is
//! taken for an option or for an address.

mod decoder;
mod encoder;
mod pam;
mod process;

use std::ffi::OsString;
use std::io;
use std::path::Path;
use std::process::Command;

pub(super) use self::decoder::Decoder;
pub(super) use self::encoder::Encoder;
pub use self::process::end_children;
use super::problem::ClipProblem;
use crate::error::Problem;

/// The program, which asks nothing and says no more than what is wrong.
fn ffmpeg() -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-hide_banner", "-nostdin", "-loglevel", "error"]);
    command
}

/// A file as the program is to read it: as one, whatever its name looks like.
fn named(path: &Path) -> OsString {
    let mut name = OsString::from("file:");
    name.push(path);
    name
}

/// Why the program did not start.
fn not_started(error: io::Error, writes: bool) -> Problem {
    match error.kind() {
        io::ErrorKind::NotFound => ClipProblem::NoFfmpeg { writes }.into(),
        _ => Problem::file_system(error, 0),
    }
}
