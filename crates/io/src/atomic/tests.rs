//! Every step made to fail, and folders that tests of other modules use.

use super::*;

/// Fails at one of the four steps.
struct Fails(usize);
impl Fails {
    fn at(&self, step: usize) -> io::Result<()> {
        if self.0 == step { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }
}
impl Steps for Fails {
    fn create(&self, part: &Path) -> io::Result<File> {
        self.at(0)?;
        Disk.create(part)
    }
    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        Disk.write(file, &bytes[..bytes.len() / 2])?;
        self.at(1)?;
        Disk.write(file, &bytes[bytes.len() / 2..])
    }
    fn sync(&self, file: &File) -> io::Result<()> {
        self.at(2)?;
        Disk.sync(file)
    }
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        self.at(3)?;
        Disk.take_name(part, path, no_clobber)
    }
}

/// A folder into which not even a superuser writes: the system's own, where it lets nobody make files.
#[cfg(unix)]
pub(crate) fn closed_to_all() -> Option<&'static Path> {
    let closed = Path::new("/sys");
    let probe = File::create_new(closed.join("selvedge-probe"));
    let denied = [io::ErrorKind::PermissionDenied, io::ErrorKind::ReadOnlyFilesystem];
    probe.is_err_and(|e| denied.contains(&e.kind())).then_some(closed)
}

/// A folder of its own, removed at the end.
pub(crate) struct Folder(PathBuf);
impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("selvedge-io-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
    pub(crate) fn files(&self) -> Vec<(String, Vec<u8>)> {
        let names = fs::read_dir(&self.0).unwrap().map(|e| e.unwrap());
        let mut files: Vec<_> =
            names.map(|e| (e.file_name().to_string_lossy().into_owned(), fs::read(e.path()).unwrap())).collect();
        files.sort();
        files
    }
}
impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn replace(steps: &impl Steps, path: &Path, bytes: &[u8], no_clobber: bool) -> io::Result<()> {
    stage(steps, path, bytes, no_clobber)?.expect("a regular file").finish(steps, no_clobber)
}

#[test]
fn what_is_staged_is_not_there_yet_and_goes_with_its_owner() {
    let folder = Folder::new("staged");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    write_bytes(&a, b"old", false).unwrap();
    let first = Staged::new(&a, b"new", false).unwrap();
    let second = Staged::new(&b, b"new", false).unwrap();
    assert_eq!(folder.files().len(), 3, "the old file and two parts");
    drop(second);
    assert_eq!(fs::read(&a).unwrap(), b"old");
    first.finish().unwrap();
    assert_eq!(folder.files(), [("a.png".to_owned(), b"new".to_vec())]);
}

#[test]
fn a_failure_at_any_step_leaves_the_old_file_and_nothing_else() {
    let folder = Folder::new("steps");
    let path = folder.path("a.png");
    for old in [None, Some(b"old".to_vec())] {
        if let Some(old) = &old {
            write_bytes(&path, old, false).unwrap();
        }
        let before = folder.files();
        for step in 0..4 {
            assert!(replace(&Fails(step), &path, b"new bytes", false).is_err());
            assert_eq!(folder.files(), before, "step {step}");
        }
        assert!(replace(&Fails(4), &path, b"new bytes", false).is_ok());
        assert_eq!(folder.files(), [("a.png".to_owned(), b"new bytes".to_vec())]);
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn parts_of_dead_writers_are_swept_and_others_stay() {
    let folder = Folder::new("sweep");
    let path = folder.path("a.png");
    for name in [".a.png.99-1.part", ".a.png.mine.part", ".b.png.99-1.part"] {
        fs::write(folder.0.join(name), b"part").unwrap();
    }
    let living = File::create(folder.0.join(".a.png.98-1.part")).unwrap();
    living.try_lock().unwrap();
    write_bytes(&path, b"new", false).unwrap();
    let names: Vec<String> = folder.files().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, [".a.png.98-1.part", ".a.png.mine.part", ".b.png.99-1.part", "a.png"]);
}

#[test]
fn no_clobber_keeps_what_is_there() {
    let folder = Folder::new("clobber");
    let path = folder.path("a.png");
    write_bytes(&path, b"old", true).unwrap();
    assert!(matches!(write_bytes(&path, b"new", true), Err(Error { problem: Problem::Exists, .. })));
    assert!(link_then_remove(&path, &path).is_err(), "a name taken in the last moment is not replaced");
    assert_eq!(folder.files(), [("a.png".to_owned(), b"old".to_vec())]);
}

/// A folder stands for a file on a file system without hard links: it has none anywhere, and can be renamed.
#[test]
fn without_hard_links_a_name_is_taken_if_it_is_free() {
    let folder = Folder::new("no-links");
    let (part, path) = (folder.path("part"), folder.path("a.png"));
    fs::create_dir(&part).unwrap();
    fs::write(&path, b"old").unwrap();
    let taken = link_then_remove(&part, &path).unwrap_err();
    assert_eq!((taken.kind(), part.exists()), (io::ErrorKind::AlreadyExists, true));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    fs::remove_file(&path).unwrap();
    link_then_remove(&part, &path).unwrap();
    assert_eq!((part.exists(), path.is_dir()), (false, true));
}

#[test]
fn links_are_followed_and_long_names_fit() {
    let folder = Folder::new("links");
    let (path, link) = (folder.0.join("x".repeat(251) + ".png"), folder.0.join("link.png"));
    write_bytes(&path, b"old", false).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_bytes(&link, b"new", false).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }
}

#[test]
fn missing_folders_folders_and_full_devices_are_told_apart() {
    let folder = Folder::new("kinds");
    let problem = |path: &Path| write_bytes(path, b"new", false).unwrap_err().problem;
    assert!(matches!(problem(&folder.path("none/a.png")), Problem::NoFolder));
    assert!(matches!(problem(&folder.0), Problem::Folder));
    if Path::new("/dev/full").exists() {
        assert!(matches!(problem(Path::new("/dev/full")), Problem::NoSpace { bytes: 3 }));
    }
    assert_eq!(folder.files(), []);
}
