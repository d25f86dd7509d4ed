//! Standard output and standard error, where whoever listens may leave at any time.

use std::io::{ErrorKind, Write as _};

use crate::failure::Failure;

/// Writes an answer to standard output. A reader that has left has what it wanted: that is no failure.
pub(crate) fn answer(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            let exit = if e.kind() == ErrorKind::StorageFull { 5 } else { 4 };
            Err(Failure::new(exit, format!("{e}; redirect it elsewhere")).named("standard output"))
        }
        _ => Ok(()),
    }
}

/// A line for people, on standard error. If nobody can be told, nobody is told.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
