//! Standard output and standard error, where whoever listens may leave at any time.

use std::io::{ErrorKind, Write as _};

use crate::failure::Failure;

/// Writes an answer to standard output. A reader that has left has what it wanted: that is no failure.
pub(crate) fn answer(bytes: &[u8]) -> Result<(), Failure> {
    match write(bytes) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|e| failed(&e)),
    }
}

/// Writes the bytes of a picture, of which a part is of no use: a reader that has left did not get it.
pub(crate) fn picture(bytes: &[u8]) -> Result<(), Failure> {
    write(bytes).map_err(|e| failed(&e))
}

fn write(bytes: &[u8]) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

fn failed(error: &std::io::Error) -> Failure {
    let no_space = matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge);
    let what = if error.kind() == ErrorKind::BrokenPipe { "its reader has left".into() } else { plain(error) };
    Failure::new(if no_space { 5 } else { 4 }, what).remedy("redirect it elsewhere").named("standard output")
}

/// A refusal of the system without its number.
pub(crate) fn plain(error: &std::io::Error) -> String {
    let text = error.to_string();
    let words = text.split_once(" (os error").map_or(&text[..], |(words, _)| words);
    words[..1].to_lowercase() + &words[1..]
}

/// A line for people, on standard error. If nobody can be told, nobody is told.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
