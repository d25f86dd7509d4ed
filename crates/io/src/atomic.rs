//! Files that appear whole or not at all.
//!
//! The bytes go to a part beside the final name, are flushed to the disk, and take the name in one step. A part is
//! locked while its writer lives; parts without a living writer are swept when the same name is written again. Files that
//! belong together take their names while their folders are locked, so that those of two runs do not mix.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Problem};
use crate::identity::{Identity, identity};

/// Writes a file whole or not at all: on failure the old file, or none, is left.
///
/// A link is followed, permissions of a replaced file are kept. Devices and pipes are written as they are.
///
/// # Errors
/// Of kind `FileSystem` or `NoSpace`; [`Problem::Exists`] if `no_clobber` and there is such a file.
pub fn write_bytes(path: &Path, bytes: &[u8], no_clobber: bool) -> Result<(), Error> {
    Staged::new(path, bytes, no_clobber)?.finish()
}

/// Gives several files their names at once: a second run of the same names takes them before or after all of these, and a
/// signal that calls [`remove_parts`] comes before or after them as well.
///
/// # Errors
/// Those of [`write_bytes`]. A name that is taken or a folder is found before any file has its name.
pub fn finish_all(staged: Vec<Staged<'_>>) -> Result<(), Error> {
    finish_with(&Disk, &staged)
}

fn finish_with(steps: &impl Steps, staged: &[Staged<'_>]) -> Result<(), Error> {
    let problem = |one: &Staged<'_>, e| file_problem(one.path, e, one.bytes.len() as u64);
    let folders = locked_folders(staged.iter().filter_map(|one| Some(folder(&one.part.as_ref()?.path))));
    {
        // While this is held, nobody removes the parts.
        let held = parts();
        if held.is_none() {
            let interrupted = || io::Error::from(io::ErrorKind::Interrupted);
            return staged.first().map_or(Ok(()), |one| Err(problem(one, interrupted())));
        }
        for one in staged {
            one.still_free().map_err(|e| problem(one, e))?;
        }
        for one in staged {
            one.take_name(steps).map_err(|e| problem(one, e))?;
            FINISHED.store(true, Ordering::Relaxed);
        }
    }
    // Makes the new names themselves durable. Not every system can; the files are whole in any case.
    for folder in &folders {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Opens and locks each of these folders once, however often and in however many spellings it is named: a second lock of
/// ours would wait for the first one. In one order for all, so that no two runs wait for each other. A system without such
/// locks only loses what they are for.
fn locked_folders<'p>(folders: impl Iterator<Item = &'p Path>) -> Vec<File> {
    let folders: BTreeMap<Identity, File> =
        folders.filter_map(|folder| Some((identity(folder)?, File::open(folder).ok()?))).collect();
    for folder in folders.values() {
        let _ = folder.lock();
    }
    folders.into_values().collect()
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
        finish_all(vec![self])
    }

    /// Whether the name can still be taken.
    fn still_free(&self) -> io::Result<()> {
        match &self.part {
            Some(part) if self.no_clobber && fs::symlink_metadata(&part.path).is_ok() => {
                Err(io::ErrorKind::AlreadyExists.into())
            }
            Some(part) if part.path.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            _ => Ok(()),
        }
    }

    fn take_name(&self, steps: &impl Steps) -> io::Result<()> {
        match &self.part {
            Some(part) => steps.take_name(&part.part, &part.path, self.no_clobber),
            None => OpenOptions::new().write(true).open(self.path).and_then(|mut file| file.write_all(self.bytes)),
        }
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
        sweep(&Disk, &path);
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
    fn remove(&self, part: &Path) -> io::Result<()> {
        fs::remove_file(part)
    }
    fn link(&self, part: &Path, path: &Path) -> io::Result<()> {
        fs::hard_link(part, path)
    }
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        if no_clobber { link_then_remove(self, part, path) } else { fs::rename(part, path) }
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
    sweep(steps, &path);
    let (part, file) = create_part(steps, &path)?;
    let mut part = Part { part, path, file };
    write_part(steps, &mut part.file, bytes, existing.as_ref())?;
    Ok(Some(part))
}

/// What is to be replaced, links followed, and what it is now.
fn target(path: &Path) -> io::Result<(PathBuf, Option<fs::Metadata>)> {
    match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        // Taking its name would replace it all the same, but whoever made it so does not want that.
        Ok(existing) if existing.permissions().readonly() => Err(io::Error::other(WriteProtected)),
        Ok(existing) if existing.is_file() => Ok((fs::canonicalize(path)?, Some(existing))),
        Ok(existing) => Ok((path.to_path_buf(), Some(existing))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok((dangling(path), None)),
        Err(e) => Err(e),
    }
}

/// Where a chain of links that leads to nothing leads.
fn dangling(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    // A ring has another error than one that ends nowhere, so this comes to an end.
    while let Ok(to) = fs::read_link(&path) {
        path = folder(&path).join(to);
    }
    path
}

/// A file that nobody may write.
#[derive(Debug, thiserror::Error)]
#[error("is write-protected")]
pub(crate) struct WriteProtected;

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
/// whatever its other threads are doing. Files that have their names stay; whether there are any.
pub fn remove_parts() -> bool {
    for part in parts().take().into_iter().flatten() {
        // A part that stays is swept by the next writer.
        let _ = fs::remove_file(part);
    }
    FINISHED.load(Ordering::Relaxed)
}

/// Whether a file of this process has its name.
static FINISHED: AtomicBool = AtomicBool::new(false);

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
                // Between both, another writer of this name may have taken the part for one that was left.
                match file.try_lock() {
                    Err(TryLockError::WouldBlock) => continue,
                    // A file system without locks only loses the sweeping.
                    Ok(()) | Err(TryLockError::Error(_)) => {}
                }
                if leads_to(&part, &file) {
                    parts.push(part.clone());
                    return Ok((part, file));
                }
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    }
}

/// Whether a name is still that of an open file.
#[cfg(unix)]
fn leads_to(path: &Path, file: &File) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let same = |a: fs::Metadata, b: fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    fs::symlink_metadata(path).and_then(|named| Ok(same(named, file.metadata()?))).unwrap_or(false)
}

/// Elsewhere a file that is open cannot be removed.
#[cfg(not(unix))]
fn leads_to(path: &Path, _: &File) -> bool {
    path.exists()
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

/// Takes a name only if it is free. Where the file system has no hard links, a name that something else than this program
/// takes in the last moment is lost.
fn link_then_remove(steps: &(impl Steps + ?Sized), part: &Path, path: &Path) -> io::Result<()> {
    match steps.link(part, path) {
        Ok(()) => fs::remove_file(part),
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(e),
        Err(_) if path.exists() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(part, path),
    }
}

/// Removes parts of this name whose writer is gone: nobody holds their lock.
fn sweep(steps: &impl Steps, path: &Path) {
    let Ok(prefix) = part_prefix(path) else { return };
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let bytes = name.as_encoded_bytes();
        let Some(middle) = bytes.strip_prefix(prefix.as_encoded_bytes()).and_then(|r| r.strip_suffix(b".part")) else {
            continue;
        };
        if middle.iter().all(|b| b.is_ascii_digit() || *b == b'-') {
            remove_unlocked(steps, &entry.path());
        }
    }
}

/// Removes a part that nobody has locked. Its lock is held until it is gone: given back before, the part's own writer could
/// lock it between both, and would lose what it holds to be its own.
fn remove_unlocked(steps: &impl Steps, part: &Path) {
    let Ok(file) = File::open(part) else { return };
    if file.try_lock().is_ok() && leads_to(part, &file) {
        let _ = steps.remove(part);
    }
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
pub(crate) mod tests;
