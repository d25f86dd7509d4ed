//! Files that appear whole or not at all.
//!
//! The bytes go to a part beside the final name, are flushed to the disk, and take the name in one step. A part is
//! locked while its writer lives; parts without a living writer are swept when the same name is written again. Files
//! that belong together take their names while their folders are locked, so that those of two runs do not mix. Folders
//! that are missing are made when names are taken: until then a part lies in the first folder above that there is.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

mod parts;

pub(crate) use self::parts::Part;
pub use self::parts::remove_parts;
use self::parts::{
    Disk, FINISHED, LOCKED, Steps, create_part, folder, forget, is_missing, link_then_remove, parts, sweep,
};
use crate::error::{Error, LeftFile, LostFolder, Problem, WriteProtected};
use crate::identity::{Identity, dangling, identity, input_at};

/// Writes a file whole or not at all: on failure the old file, or none, is left.
///
/// A link is followed, permissions of a replaced file are kept, folders that are missing are made. Devices and pipes
/// are written as they are.
///
/// # Errors
/// Of kind `FileSystem` or `NoSpace`; [`Problem::Exists`] if `no_clobber` and there is such a file.
pub fn write_bytes(path: &Path, bytes: &[u8], no_clobber: bool) -> Result<(), Error> {
    StagedFile::new(path, bytes, no_clobber)?.finish()
}

/// Gives several files their names at once: a second run of the same names takes them before or after all of these, and
/// a signal that calls [`remove_parts`] comes before or after them as well. Devices and pipes are written before the
/// first name is taken.
///
/// # Errors
/// Those of [`write_bytes`]. A name that is taken or a folder is found before any file has its name.
pub fn finish_all(staged: Vec<StagedFile<'_>>) -> Result<(), Error> {
    finish_with(&Disk, staged)
}

fn finish_with(steps: &impl Steps, mut staged: Vec<StagedFile<'_>>) -> Result<(), Error> {
    staged.iter_mut().try_for_each(StagedFile::send)?;
    let folders = locked_folders(staged.iter().filter_map(|one| Some(folder(&one.part.as_ref()?.part))));
    {
        // While this is held, nobody removes the parts.
        let held = parts();
        if held.is_none() {
            let interrupted = || io::Error::from(io::ErrorKind::Interrupted);
            return staged.first().map_or(Ok(()), |one| Err(one.problem(interrupted())));
        }
        let mut made = Vec::new();
        let taken = take_names(steps, &staged, &mut made);
        if taken.is_err() {
            // Those that hold a file stay.
            made.iter().rev().for_each(|folder| drop(fs::remove_dir(folder)));
        }
        taken?;
    }
    // Makes the new names themselves durable. Not every system can; the files are whole in any case.
    for folder in &folders {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Makes the folders that are missing and notes them, then gives all files their names.
fn take_names(steps: &impl Steps, staged: &[StagedFile<'_>], made: &mut Vec<PathBuf>) -> Result<(), Error> {
    for one in staged {
        one.make_folders(made).map_err(|e| one.problem(e))?;
    }
    for one in staged {
        one.still_free().map_err(|e| one.problem(e))?;
    }
    let mut taken: Vec<(&StagedFile<'_>, Before)> = Vec::new();
    for one in staged {
        // Of one file there is nothing that could be taken back.
        let before = if staged.len() == 1 { Before::Lost } else { one.before(steps) };
        if let Err(e) = one.take_name(steps) {
            before.forget();
            let not_back = taken.into_iter().rev().filter_map(|(one, before)| one.give_back(steps, before).err());
            let left: Vec<LeftFile> = not_back.collect();
            let refused = one.problem(e);
            return Err(if left.is_empty() { refused } else { refused.leaving(left) });
        }
        taken.push((one, before));
    }
    taken.iter().for_each(|(_, before)| before.forget());
    FINISHED.store(!staged.is_empty() || FINISHED.load(Ordering::Relaxed), Ordering::Relaxed);
    Ok(())
}

/// What a name led to before it was taken, for as long as others of its set may still fail.
enum Before {
    Nothing,
    /// The old file, under a name that is swept like a part's.
    Kept(PathBuf),
    /// A file of which no second name could be made.
    Lost,
}

impl Before {
    fn forget(&self) {
        if let Self::Kept(old) = self {
            let _ = fs::remove_file(old);
        }
    }
}

/// Opens and locks each of these folders once, however often and in however many spellings it is named: a second lock
/// of ours would wait for the first one. In one order for all, so that no two runs wait for each other. A system
/// without such locks only loses what they are for.
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
pub struct StagedFile<'a> {
    path: Cow<'a, Path>,
    /// What a device or a pipe is to have, or a caller holds.
    bytes: Cow<'a, [u8]>,
    len: u64,
    no_clobber: bool,
    part: Option<Part>,
    /// Whether a device or a pipe has its bytes.
    sent: bool,
}

impl<'a> StagedFile<'a> {
    /// Writes the bytes beside the final name; those of devices and pipes are kept for [`finish`](Self::finish).
    ///
    /// # Errors
    /// Those of [`write_bytes`].
    pub fn new(path: &'a Path, bytes: &'a [u8], no_clobber: bool) -> Result<Self, Error> {
        Self::of(path.into(), bytes.into(), no_clobber)
    }

    fn of(path: Cow<'a, Path>, bytes: Cow<'a, [u8]>, no_clobber: bool) -> Result<Self, Error> {
        let (len, part) = (bytes.len() as u64, stage(&Disk, &path, &bytes, no_clobber));
        let part = part.map_err(|e| Error::new(&path, Problem::file_system(e, len)))?;
        Ok(Self { path, bytes, len, no_clobber, part, sent: false })
    }

    /// The same, unless the name leads to one of these files by now: what a run reads is not replaced, whatever became
    /// of its names meanwhile.
    ///
    /// # Errors
    /// Those of [`write_bytes`], and [`Problem::IsInput`].
    pub fn beside(path: &'a Path, bytes: &'a [u8], no_clobber: bool, inputs: &[PathBuf]) -> Result<Self, Error> {
        Self::new(path, bytes, no_clobber)?.apart_from(inputs)
    }

    fn apart_from(self, inputs: &[PathBuf]) -> Result<Self, Error> {
        let target = self.part.as_ref().map_or(&*self.path, |part| &part.path);
        match input_at(target, inputs) {
            Some(input) => Err(Error::new(&self.path, Problem::IsInput { input: input.clone() })),
            None => Ok(self),
        }
    }

    /// Writes to a device or a pipe, which can take bytes only once and for as long as it likes; files wait for their
    /// names.
    ///
    /// # Errors
    /// Those of [`write_bytes`].
    pub fn send(&mut self) -> Result<(), Error> {
        if self.part.is_none() && !self.sent {
            self.sent = true;
            let sent =
                OpenOptions::new().write(true).open(&*self.path).and_then(|mut file| file.write_all(&self.bytes));
            sent.map_err(|e| self.problem(e))?;
        }
        Ok(())
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
        self.part.as_ref().map_or(Ok(()), |part| steps.take_name(&part.part, &part.path, self.no_clobber))
    }

    /// Keeps what its name leads to under a second one.
    fn before(&self, steps: &impl Steps) -> Before {
        let Some(part) = &self.part else { return Before::Lost };
        if fs::symlink_metadata(&part.path).is_err() {
            return Before::Nothing;
        }
        let kept = part.part.with_extension("0.part");
        match steps.link(&part.path, &kept) {
            Ok(()) => Before::Kept(kept),
            Err(_) => Before::Lost,
        }
    }

    /// Takes back that it took its name; the error is the file that stays as it is now.
    fn give_back(&self, steps: &impl Steps, before: Before) -> Result<(), LeftFile> {
        let Some(part) = &self.part else { return Ok(()) };
        let left = |old| LeftFile { path: self.path.to_path_buf(), old };
        match before {
            Before::Nothing => steps.remove(&part.path).map_err(|_| left(None)),
            Before::Kept(old) => {
                steps.take_name(&old, &part.path, false).map_err(|_| left(Some(put_aside(&old, &part.path))))
            }
            Before::Lost => Err(left(None)),
        }
    }

    /// Makes the folders that its name needs, outermost first.
    fn make_folders(&self, made: &mut Vec<PathBuf>) -> io::Result<()> {
        let Some(part) = &self.part else { return Ok(()) };
        let missing: Vec<&Path> = folder(&part.path).ancestors().take_while(|folder| is_missing(folder)).collect();
        for folder in missing.into_iter().rev() {
            match fs::create_dir(folder) {
                Ok(()) => made.push(folder.to_path_buf()),
                // Another run has made it.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    fn problem(&self, error: io::Error) -> Error {
        Error::new(&self.path, Problem::file_system(error, self.len))
    }
}

impl StagedFile<'static> {
    /// As [`beside`](StagedFile::beside), of bytes that are let go once they are on the disk: of many files that are
    /// made one after the other none is held.
    ///
    /// # Errors
    /// Those of [`beside`](StagedFile::beside).
    pub fn owned(path: PathBuf, bytes: Vec<u8>, no_clobber: bool, inputs: &[PathBuf]) -> Result<Self, Error> {
        let mut staged = Self::of(path.into(), bytes.into(), no_clobber)?.apart_from(inputs)?;
        if staged.part.is_some() {
            staged.bytes = Cow::Borrowed(&[]);
        }
        Ok(staged)
    }
}

/// Gives what was kept of an old file a name that nobody sweeps.
fn put_aside(kept: &Path, path: &Path) -> PathBuf {
    let named = |n: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(if n == 0 { ".old".to_owned() } else { format!(".old.{n}") });
        PathBuf::from(name)
    };
    let free = (0..1000).map(named).find(|aside| link_then_remove(&Disk, kept, aside).is_ok());
    free.unwrap_or_else(|| kept.to_path_buf())
}

/// An empty part beside a name, which another program is to fill. It is gone when it is dropped.
pub(crate) fn part_beside(path: &Path) -> io::Result<Part> {
    sweep(&Disk, path);
    let (part, file) = create_part(&Disk, path)?;
    // Where locks hold off other programs as well, it has none.
    if cfg!(not(unix)) {
        let _ = file.unlock();
    }
    Ok(Part { part, path: path.to_path_buf(), file: Some(file) })
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
    tried.map_err(|e| Error::new(path, Problem::file_system(e, 0)))
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
    let mut part = Part { part, path, file: Some(file) };
    let written = part.file.as_mut().map_or(Ok(()), |file| write_part(steps, file, bytes, existing.as_ref()));
    written?;
    if parts().as_ref().is_some_and(|parts| LOCKED < parts.len()) {
        part.file = None;
    }
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
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let path = dangling(path);
            // Nor could it be made: its name is taken.
            let is_lost = |folder: &Path| is_missing(folder) && fs::symlink_metadata(folder).is_ok();
            if path.ancestors().skip(1).any(is_lost) {
                return Err(io::Error::other(LostFolder));
            }
            Ok((path, None))
        }
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

#[cfg(test)]
mod given_back;
#[cfg(test)]
pub(crate) mod tests;
