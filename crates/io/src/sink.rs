//! Where encoders write to: memory that may be refused.

use std::fmt::Display;
use std::io::{self, Seek, SeekFrom, Write};

use crate::Format;
use crate::error::Problem;

/// Bytes that stay free while a file grows: encoders take some for themselves, and cannot be refused them.
const SPARE: usize = 6 << 20;

/// Files from this size on grow by a quarter: doubling would ask for as much memory again as a large file holds.
const LARGE: usize = 16 << 20;

/// A file in memory. Where the system gives no more of it, writing fails; a plain `Vec` would abort.
#[derive(Debug, Default)]
pub(crate) struct Sink {
    bytes: Vec<u8>,
    at: usize,
    /// Bytes that were asked for and not given.
    refused: Option<u64>,
}

impl Sink {
    /// What was written.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// What was written, as the file that it is.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Puts bytes between those that are there.
    pub(crate) fn insert(&mut self, at: usize, bytes: &[u8]) -> io::Result<()> {
        self.reserve(bytes.len())?;
        self.bytes.splice(at..at, bytes.iter().copied());
        Ok(())
    }

    /// Asks for memory that an encoder will take for itself, and gives it back: it would abort where this fails.
    pub(crate) fn ask_for(&mut self, bytes: usize) -> io::Result<()> {
        let asked = Vec::<u8>::new().try_reserve_exact(bytes);
        asked.map_err(|_| self.refuse(bytes))
    }

    fn reserve(&mut self, more: usize) -> io::Result<()> {
        if more <= self.bytes.capacity() - self.bytes.len() {
            return Ok(());
        }
        // Twice what there is makes writing cheap; of large files, which systems move without a copy, a quarter more
        // does. What is needed is enough.
        let ahead = if self.bytes.len() < LARGE { self.bytes.len() } else { self.bytes.len() / 4 };
        let given = self.bytes.try_reserve_exact(more.max(ahead)).or_else(|_| self.bytes.try_reserve_exact(more));
        given.map_err(|_| self.refuse(self.bytes.len().saturating_add(more)))?;
        self.ask_for(SPARE)
    }

    fn refuse(&mut self, bytes: usize) -> io::Error {
        self.refused = Some(bytes as u64);
        io::ErrorKind::OutOfMemory.into()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let end = self.at.checked_add(bytes.len()).ok_or(io::ErrorKind::OutOfMemory)?;
        if self.bytes.len() < end {
            self.reserve(end - self.bytes.len())?;
            self.bytes.resize(end, 0);
        }
        self.bytes[self.at..end].copy_from_slice(bytes);
        self.at = end;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => i64::try_from(at).ok(),
            SeekFrom::End(by) => (self.bytes.len() as i64).checked_add(by),
            SeekFrom::Current(by) => (self.at as i64).checked_add(by),
        };
        self.at = at.and_then(|at| usize::try_from(at).ok()).ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at as u64)
    }
}

/// What an encoder writes. Whatever it says when memory ran out, it is told as that.
pub(crate) fn encoded<E: Display>(
    format: Format,
    encode: impl FnOnce(&mut Sink) -> Result<(), E>,
) -> Result<Vec<u8>, Problem> {
    let mut sink = Sink::default();
    let outcome = sink.ask_for(SPARE).map(|()| encode(&mut sink));
    match (outcome.unwrap_or(Ok(())), sink.refused) {
        (_, Some(bytes)) => Err(selvedge_core::Error::Allocation { bytes }.into()),
        (Err(e), None) => Err(Problem::encoder(format, e)),
        (Ok(()), None) => Ok(sink.bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_file_in_memory() {
        let bytes = encoded(Format::Tiff, |sink| {
            sink.write_all(b"....body")?;
            sink.seek(SeekFrom::Start(0))?;
            sink.write_all(b"head")?;
            sink.seek(SeekFrom::End(1))?;
            sink.write_all(b"end")?;
            sink.insert(4, b"-")
        });
        assert_eq!(bytes.unwrap(), b"head-body\0end");
    }

    #[test]
    fn memory_that_is_not_there_is_said_to_be_so_whatever_the_encoder_makes_of_it() {
        let refused = encoded(Format::Png, |sink| sink.ask_for(usize::MAX / 2).map_err(|_| "something else"));
        let Err(Problem::Core(selvedge_core::Error::Allocation { bytes })) = refused else { panic!("{refused:?}") };
        assert_eq!(bytes, u64::MAX / 2);
        assert!(matches!(encoded(Format::Png, |_| Err("why")), Err(Problem::Encoder { .. })));
    }
}
