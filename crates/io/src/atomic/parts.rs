//! Parts: what is written beside the name that it is to take, locked while its writer lives, and swept after it.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The steps that may fail, so that tests can make each of them fail.
pub(super) trait Steps {
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

pub(super) struct Disk;
impl Steps for Disk {}

/// A whole part beside the name that it is to take; gone when it is dropped.
#[derive(Debug)]
pub(crate) struct Part {
    pub(super) part: PathBuf,
    pub(super) path: PathBuf,
    /// Keeps the lock; `None` beyond [`LOCKED`].
    pub(super) file: Option<File>,
}

/// So many parts of a run are locked at once: a process may have some hundred files open. Others of its names are
/// swept by a run that takes the same names meanwhile, and then none of the first run takes its own.
pub(super) const LOCKED: usize = 100;

impl Part {
    /// Where it lies.
    pub(crate) fn file(&self) -> &Path {
        &self.part
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        forget(&self.part);
        // After success there is none; one that stays is swept by the next writer.
        let _ = fs::remove_file(&self.part);
    }
}

/// Parts that this process is writing; `None` once it may write no more.
static PARTS: Mutex<Option<Vec<PathBuf>>> = Mutex::new(Some(Vec::new()));

pub(super) fn parts() -> MutexGuard<'static, Option<Vec<PathBuf>>> {
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
pub(super) static FINISHED: AtomicBool = AtomicBool::new(false);

pub(super) fn forget(part: &Path) {
    if let Some(parts) = parts().as_mut() {
        parts.retain(|p| p != part);
    }
}

/// A new part, locked by us.
pub(super) fn create_part(steps: &impl Steps, path: &Path) -> io::Result<(PathBuf, File)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let mut parts = parts();
    let parts = parts.as_mut().ok_or(io::ErrorKind::Interrupted)?;
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let mut name = part_prefix(path)?;
        name.push(format!("{}-{number}.part", std::process::id()));
        let part = nearest(path).join(name);
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

/// Takes a name only if it is free. Where the file system has no hard links, a name that something else than this
/// program takes in the last moment is lost.
pub(super) fn link_then_remove(steps: &(impl Steps + ?Sized), part: &Path, path: &Path) -> io::Result<()> {
    match steps.link(part, path) {
        Ok(()) => fs::remove_file(part),
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(e),
        Err(_) if path.exists() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(part, path),
    }
}

/// Removes parts of this name whose writer is gone: nobody holds their lock.
pub(super) fn sweep(steps: &impl Steps, path: &Path) {
    let Ok(prefix) = part_prefix(path) else { return };
    let Ok(entries) = fs::read_dir(nearest(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let bytes = name.as_encoded_bytes();
        let Some(middle) = bytes.strip_prefix(prefix.as_encoded_bytes()).and_then(|r| r.strip_suffix(b".part")) else {
            continue;
        };
        if !middle.iter().all(|b| b.is_ascii_digit() || matches!(b, b'-' | b'.')) {
            continue;
        }
        // What was kept of the old file has a point in its number. Nobody locks that file: while its writer lives, and
        // may have to give it back, it has the folder's lock.
        if middle.contains(&b'.') {
            let Ok(folder) = File::open(nearest(path)) else { continue };
            if folder.try_lock().is_ok() {
                remove_unlocked(steps, &entry.path());
            }
        } else {
            remove_unlocked(steps, &entry.path());
        }
    }
}

/// Removes a part that nobody has locked. Its lock is held until it is gone: given back before, the part's own writer
/// could lock it between both, and would lose what it holds to be its own.
fn remove_unlocked(steps: &impl Steps, part: &Path) {
    let Ok(file) = File::open(part) else { return };
    if file.try_lock().is_ok() && leads_to(part, &file) {
        let _ = steps.remove(part);
    }
}

/// The folder in which a file's part lies: its own, or while that is missing the first one above that is there.
pub(super) fn nearest(path: &Path) -> &Path {
    let folder = folder(path);
    folder.ancestors().find(|folder| !is_missing(folder)).unwrap_or(folder)
}

/// True for a name that leads to nothing; the empty one stands for where we are.
pub(super) fn is_missing(path: &Path) -> bool {
    let found = if path.as_os_str().is_empty() { Ok(()) } else { fs::metadata(path).map(drop) };
    found.is_err_and(|e| e.kind() == io::ErrorKind::NotFound)
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_link_to_nothing_keeps_its_name() {
        let folder = std::env::temp_dir().join(format!("selvedge-io-dangling-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (part, path) = (folder.join("part"), folder.join("a.png"));
        fs::write(&part, b"new").unwrap();
        std::os::unix::fs::symlink(folder.join("nothing"), &path).unwrap();
        let refused = link_then_remove(&Disk, &part, &path).map_err(|e| e.kind());
        let is_link = fs::symlink_metadata(&path).unwrap().is_symlink();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!((refused, is_link), (Err(io::ErrorKind::AlreadyExists), true));
    }
}
