//! Files that appear whole or not at all.
//!
//! The bytes go to a part beside the final name, are flushed to the disk, and take the name in one step. A part is
//! locked while its writer lives; parts without a living writer are swept when the same name is written again.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Problem};

/// Writes a file whole or not at all: on failure the old file, or none, is left.
///
/// A link is followed, permissions of a replaced file are kept. Devices and pipes are written as they are.
///
/// # Errors
/// Of kind `FileSystem` or `NoSpace`; [`Problem::Exists`] if `no_clobber` and there is such a file.
pub fn write_bytes(path: &Path, bytes: &[u8], no_clobber: bool) -> Result<(), Error> {
    Staged::new(path, bytes, no_clobber)?.finish()
}

/// A file whose bytes are safely on the disk, but which has not its name yet. Several files that belong together are
/// staged first and finished then, so that a full disk leaves none of them. Dropped, it leaves nothing.
#[derive(Debug)]
pub struct Staged<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    no_clobber: bool,
    part: Option<Part>,
}

impl<'a> Staged<'a> {
    /// Writes the bytes beside the final name; those of devices and pipes are kept for [`finish`](Self::finish).
    ///
    /// # Errors
    /// Those of [`write_bytes`].
    pub fn new(path: &'a Path, bytes: &'a [u8], no_clobber: bool) -> Result<Self, Error> {
        let part = stage(&Disk, path, bytes, no_clobber);
        let part = part.map_err(|e| file_problem(path, e, bytes.len() as u64))?;
        Ok(Self { path, bytes, no_clobber, part })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// Those of [`write_bytes`].
    pub fn finish(self) -> Result<(), Error> {
        let finished = match self.part {
            Some(part) => part.finish(&Disk, self.no_clobber),
            None => OpenOptions::new().write(true).open(self.path).and_then(|mut file| file.write_all(self.bytes)),
        };
        finished.map_err(|e| file_problem(self.path, e, self.bytes.len() as u64))
    }
}

/// A file that is to be made cannot be missing: its folder is.
fn file_problem(path: &Path, error: io::Error, bytes: u64) -> Error {
    let missing = || path.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.exists());
    let problem = match error.kind() {
        io::ErrorKind::NotFound if missing() => Problem::NoFolder,
        io::ErrorKind::NotFound => Problem::FileSystem(error),
        _ => Problem::file_system(error, bytes),
    };
    Error::new(path, problem)
}

/// Makes a part and takes it away again: what hinders the one hinders the file.
pub(crate) fn try_part(path: &Path) -> Result<(), Error> {
    let tried = target(path).and_then(|(path, existing)| {
        if existing.is_some_and(|m| !m.is_file()) {
            return Ok(());
        }
        sweep(&path);
        create_part(&Disk, &path).and_then(|(part, _)| {
            forget(&part);
            fs::remove_file(part)
        })
    });
    tried.map_err(|e| file_problem(path, e, 0))
}

/// The steps that may fail, so that tests can make each of them fail.
trait Steps {
    fn create(&self, part: &Path) -> io::Result<File> {
        OpenOptions::new().write(true).create_new(true).open(part)
    }
    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        file.write_all(bytes)
    }
    fn sync(&self, file: &File) -> io::Result<()> {
        file.sync_all()
    }
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        if no_clobber { link_then_remove(part, path) } else { fs::rename(part, path) }
    }
}

struct Disk;
impl Steps for Disk {}

/// A whole part beside the name that it is to take; gone when it is dropped.
#[derive(Debug)]
struct Part {
    part: PathBuf,
    path: PathBuf,
    /// Keeps the lock.
    file: File,
}

impl Part {
    fn finish(self, steps: &impl Steps, no_clobber: bool) -> io::Result<()> {
        steps.take_name(&self.part, &self.path, no_clobber)?;
        sync_folder(&self.path);
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        forget(&self.part);
        // After success there is none; one that stays is swept by the next writer.
        let _ = fs::remove_file(&self.part);
    }
}

/// Writes a part; `None` for devices and pipes, which have none.
fn stage(steps: &impl Steps, path: &Path, bytes: &[u8], no_clobber: bool) -> io::Result<Option<Part>> {
    if no_clobber && fs::symlink_metadata(path).is_ok() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    let (path, existing) = target(path)?;
    if existing.as_ref().is_some_and(|m| !m.is_file()) {
        return Ok(None);
    }
    sweep(&path);
    let (part, file) = create_part(steps, &path)?;
    let mut part = Part { part, path, file };
    write_part(steps, &mut part.file, bytes, existing.as_ref())?;
    Ok(Some(part))
}

/// What is to be replaced, links followed, and what it is now.
fn target(path: &Path) -> io::Result<(PathBuf, Option<fs::Metadata>)> {
    match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(existing) if existing.is_file() => Ok((fs::canonicalize(path)?, Some(existing))),
        Ok(existing) => Ok((path.to_path_buf(), Some(existing))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok((path.to_path_buf(), None)),
        Err(e) => Err(e),
    }
}

fn write_part(steps: &impl Steps, file: &mut File, bytes: &[u8], old: Option<&fs::Metadata>) -> io::Result<()> {
    steps.write(file, bytes)?;
    if let Some(old) = old {
        file.set_permissions(old.permissions())?;
    }
    steps.sync(file)
}

/// Parts that this process is writing; `None` once it may write no more.
static PARTS: Mutex<Option<Vec<PathBuf>>> = Mutex::new(Some(Vec::new()));

fn parts() -> MutexGuard<'static, Option<Vec<PathBuf>>> {
    PARTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what this process is about to write, and fails all writing from now on: for a program that ends at once,
/// whatever its other threads are doing. Files that have their names stay.
pub fn remove_parts() {
    for part in parts().take().into_iter().flatten() {
        // A part that stays is swept by the next writer.
        let _ = fs::remove_file(part);
    }
}

fn forget(part: &Path) {
    if let Some(parts) = parts().as_mut() {
        parts.retain(|p| p != part);
    }
}

/// A new part, locked by us.
fn create_part(steps: &impl Steps, path: &Path) -> io::Result<(PathBuf, File)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let mut parts = parts();
    let parts = parts.as_mut().ok_or(io::ErrorKind::Interrupted)?;
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let mut name = part_prefix(path)?;
        name.push(format!("{}-{number}.part", std::process::id()));
        let part = path.with_file_name(name);
        match steps.create(&part) {
            Ok(file) => {
                // A file system without locks only loses the sweeping.
                let _ = file.try_lock();
                parts.push(part.clone());
                return Ok((part, file));
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    }
}

/// `.NAME.`, cut so that the part's name is not longer than file systems allow.
fn part_prefix(path: &Path) -> io::Result<OsString> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let mut prefix = OsString::from(".");
    match name.to_str() {
        Some(text) if 200 < text.len() => prefix.push(&text[..text.floor_char_boundary(200)]),
        None if 200 < name.len() => prefix.push("long-name"),
        _ => prefix.push(name),
    }
    prefix.push(".");
    Ok(prefix)
}

/// Takes a name only if it is free. Where the file system has no hard links, a name taken in the last moment is lost.
fn link_then_remove(part: &Path, path: &Path) -> io::Result<()> {
    match fs::hard_link(part, path) {
        Ok(()) => fs::remove_file(part),
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(e),
        Err(_) if path.exists() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(part, path),
    }
}

/// Removes parts of this name whose writer is gone: nobody holds their lock.
fn sweep(path: &Path) {
    let Ok(prefix) = part_prefix(path) else { return };
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let bytes = name.as_encoded_bytes();
        let Some(middle) = bytes.strip_prefix(prefix.as_encoded_bytes()).and_then(|r| r.strip_suffix(b".part")) else {
            continue;
        };
        if middle.iter().all(|b| b.is_ascii_digit() || *b == b'-')
            && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Makes the new name itself durable. Not every system can; the file is whole in any case.
fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
pub(crate) mod tests;
