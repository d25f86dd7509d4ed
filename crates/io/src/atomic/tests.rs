//! Every step made to fail, and folders that tests of other modules use.

use std::fs::TryLockError;
use std::sync::atomic::AtomicU32;

use super::parts::link_then_remove;
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

fn replace(steps: &impl Steps, path: &Path, bytes: &[u8], no_clobber: bool) -> Result<(), Error> {
    let part = stage(steps, path, bytes, no_clobber).map_err(|e| Error::new(path, Problem::file_system(e, 0)))?;
    finish_with(
        steps,
        vec![StagedFile { path: path.into(), bytes: bytes.into(), len: 3, no_clobber, part, sent: false }],
    )
}

/// A file system without hard links.
struct Unlinked;
impl Steps for Unlinked {
    fn link(&self, _: &Path, _: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[test]
fn names_are_kept_without_hard_links_too() {
    let folder = Folder::new("unlinked");
    let path = folder.path("a.png");
    replace(&Unlinked, &path, b"old", true).unwrap();
    let part = stage(&Unlinked, &folder.path("b.png"), b"new", true).unwrap();
    fs::write(folder.path("b.png"), b"meanwhile").unwrap();
    let (other, bytes) = (folder.path("b.png").into(), b"new".into());
    let staged = StagedFile { path: other, bytes, len: 3, no_clobber: true, part, sent: false };
    assert!(matches!(finish_with(&Unlinked, vec![staged]), Err(Error { problem: Problem::Exists, .. })));
    assert!(link_then_remove(&Unlinked, &path, &folder.path("b.png")).is_err(), "taken in the last moment");
    assert!(matches!(replace(&Unlinked, &path, b"new", true), Err(Error { problem: Problem::Exists, .. })));
    let expected = [("a.png".to_owned(), b"old".to_vec()), ("b.png".to_owned(), b"meanwhile".to_vec())];
    assert_eq!(folder.files(), expected);
}

#[test]
fn of_a_set_all_names_are_taken_or_none() {
    let folder = Folder::new("set");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    let staged = [&a, &b].map(|path| StagedFile::new(path, b"new", true).unwrap());
    fs::write(&b, b"meanwhile").unwrap();
    assert!(matches!(finish_all(staged.into()), Err(Error { problem: Problem::Exists, .. })));
    assert_eq!(folder.files(), [("b.png".to_owned(), b"meanwhile".to_vec())]);
    let staged = [&a, &b].map(|path| StagedFile::new(path, b"new", false).unwrap());
    fs::remove_file(&b).unwrap();
    fs::create_dir(&b).unwrap();
    assert!(matches!(finish_all(staged.into()), Err(Error { problem: Problem::Folder, .. })));
    assert!(!a.exists());
}

#[test]
fn a_part_that_was_swept_before_it_was_locked_is_made_again() {
    /// Another writer sweeps each of the first three parts as soon as they are there.
    struct Swept(AtomicU32);
    impl Steps for Swept {
        fn create(&self, part: &Path) -> io::Result<File> {
            let file = Disk.create(part)?;
            if self.0.fetch_add(1, Ordering::Relaxed) < 3 {
                sweep(&Disk, &part.with_file_name("a.png"));
                assert!(!part.exists());
            }
            Ok(file)
        }
    }
    let folder = Folder::new("swept");
    replace(&Swept(AtomicU32::new(0)), &folder.path("a.png"), b"new", false).unwrap();
    assert_eq!(folder.files(), [("a.png".to_owned(), b"new".to_vec())]);
}

#[test]
fn write_protected_files_stay() {
    let folder = Folder::new("protected");
    let path = folder.path("a.png");
    fs::write(&path, b"old").unwrap();
    let mut permissions = fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).unwrap();
    let refused = write_bytes(&path, b"new", false).unwrap_err();
    assert!(matches!(refused.problem, Problem::WriteProtected), "{refused}");
    assert!(try_part(&path).is_err(), "known before");
    assert_eq!(folder.files(), [("a.png".to_owned(), b"old".to_vec())]);
}

#[test]
fn a_file_system_that_can_only_be_read_is_no_lack_of_permission() {
    let error = io::Error::from(io::ErrorKind::ReadOnlyFilesystem);
    assert_eq!(Problem::file_system(error, 1).to_string(), "its file system is read-only");
}

/// Names the folder and the set of a writer that this process is to be.
const WRITER: &str = "SELVEDGE_IO_WRITER";
const SET: [&str; 3] = ["a.png", "b.png", "c.exr"];

/// Not a test by itself: what [`two_processes_of_the_same_names`] starts.
#[test]
fn writer_of_a_set() {
    let Some(folder) = std::env::var_os(WRITER).map(PathBuf::from) else { return };
    let mut set = String::new();
    io::stdin().read_line(&mut set).unwrap();
    let paths = SET.map(|name| folder.join(name));
    let staged = paths.iter().map(|path| StagedFile::new(path, set.as_bytes(), false));
    finish_all(staged.collect::<Result<_, _>>().unwrap()).unwrap();
}

/// A part that is swept stays locked until it is gone: its writer may have made it and be about to lock it.
#[test]
fn what_is_swept_is_locked_until_it_is_gone() {
    struct Locked(AtomicU32);
    impl Steps for Locked {
        fn remove(&self, part: &Path) -> io::Result<()> {
            assert!(matches!(File::open(part)?.try_lock(), Err(TryLockError::WouldBlock)));
            self.0.fetch_add(1, Ordering::Relaxed);
            Disk.remove(part)
        }
    }
    let folder = Folder::new("sweeping");
    let steps = Locked(AtomicU32::new(0));
    fs::write(folder.path(".a.png.99-1.part"), b"part").unwrap();
    sweep(&steps, &folder.path("a.png"));
    assert_eq!((steps.0.into_inner(), folder.files()), (1, Vec::new()));
}

/// Many more with `SELVEDGE_SOAK`.
#[test]
fn two_processes_of_the_same_names() {
    use std::process::{Command, Stdio};
    let more = std::env::var("SELVEDGE_SOAK").ok().and_then(|n| n.parse::<u32>().ok()).unwrap_or(1);
    let folder = Folder::new("race");
    let program = std::env::current_exe().unwrap();
    for round in 0..100 * more {
        let start = || {
            Command::new(&program)
                .args(["writer_of_a_set", "--test-threads=1", "--nocapture"])
                .env(WRITER, &folder.0)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap()
        };
        let mut pair = [start(), start()];
        // Both are there before the first one may begin.
        for (i, one) in pair.iter_mut().enumerate() {
            one.stdin.take().unwrap().write_all(format!("run {i} of {round}\n").as_bytes()).unwrap();
        }
        for one in pair.map(|one| one.wait_with_output().unwrap()) {
            let told = [one.stdout, one.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
            assert!(one.status.success(), "round {round}: {told:?}");
        }
        let files = folder.files();
        assert_eq!(files.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), SET, "round {round}");
        assert!(files.iter().all(|(_, bytes)| *bytes == files[0].1), "a mixed set in round {round}");
    }
}

#[test]
fn what_is_staged_is_not_there_yet_and_goes_with_its_owner() {
    let folder = Folder::new("staged");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    write_bytes(&a, b"old", false).unwrap();
    let first = StagedFile::new(&a, b"new", false).unwrap();
    let second = StagedFile::new(&b, b"new", false).unwrap();
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
    assert!(link_then_remove(&Disk, &path, &path).is_err(), "a name taken in the last moment is not replaced");
    assert_eq!(folder.files(), [("a.png".to_owned(), b"old".to_vec())]);
}

/// A folder stands for a file on a file system without hard links: it has none anywhere, and can be renamed.
#[test]
fn without_hard_links_a_name_is_taken_if_it_is_free() {
    let folder = Folder::new("no-links");
    let (part, path) = (folder.path("part"), folder.path("a.png"));
    fs::create_dir(&part).unwrap();
    fs::write(&path, b"old").unwrap();
    let taken = link_then_remove(&Disk, &part, &path).unwrap_err();
    assert_eq!((taken.kind(), part.exists()), (io::ErrorKind::AlreadyExists, true));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    fs::remove_file(&path).unwrap();
    link_then_remove(&Disk, &part, &path).unwrap();
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
        let (nowhere, chain) = (folder.0.join("nowhere.png"), folder.0.join("chain.png"));
        std::os::unix::fs::symlink("nowhere.png", folder.0.join("half.png")).unwrap();
        std::os::unix::fs::symlink("half.png", &chain).unwrap();
        write_bytes(&chain, b"there", false).unwrap();
        assert_eq!(fs::read(&nowhere).unwrap(), b"there", "a link that led to nothing is followed as well");
        assert!(fs::symlink_metadata(&chain).unwrap().is_symlink());
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }
}

#[test]
fn files_for_folders_folders_and_full_devices_are_told_apart() {
    let folder = Folder::new("kinds");
    let problem = |path: &Path| write_bytes(path, b"new", false).unwrap_err().problem;
    fs::write(folder.path("a"), b"").unwrap();
    assert!(matches!(problem(&folder.path("a/b.png")), Problem::NoFolder));
    fs::remove_file(folder.path("a")).unwrap();
    assert!(matches!(problem(&folder.0), Problem::Folder));
    if Path::new("/dev/full").exists() {
        assert!(matches!(problem(Path::new("/dev/full")), Problem::NoSpace { bytes: 3 }));
    }
    assert_eq!(folder.files(), []);
}

/// A second lock of one folder would wait for the first one for ever.
#[test]
fn a_folder_of_several_spellings_is_locked_once() {
    let folder = Folder::new("spellings");
    let other = folder.path("..").join(folder.0.file_name().unwrap());
    assert_eq!(locked_folders([folder.0.as_path(), &other, &folder.path(".")].into_iter()).len(), 1);
    let names = [folder.path("a"), other.join("b")];
    let staged = names.iter().map(|path| StagedFile {
        path: path.into(),
        bytes: b"x".into(),
        len: 1,
        no_clobber: false,
        part: stage(&Disk, path, b"x", false).unwrap(),
        sent: false,
    });
    finish_all(staged.collect()).unwrap();
    assert_eq!(folder.files().len(), 2);
}

#[test]
fn missing_folders_are_made_with_the_names_and_not_before() {
    let folder = Folder::new("made");
    let (a, b) = (folder.path("x/y/a.png"), folder.path("x/b.png"));
    let stage = || [&a, &b].map(|path| StagedFile::new(path, b"new", false).unwrap());
    drop(stage());
    assert_eq!(folder.files(), []);
    // A part that a killed run left is found where it lies.
    fs::write(folder.path(".a.png.99-1.part"), b"part").unwrap();
    let staged = stage();
    assert!(!folder.path("x").exists());
    fs::create_dir_all(&b).unwrap();
    assert!(matches!(finish_all(staged.into()), Err(Error { problem: Problem::Folder, .. })));
    assert!(!folder.path("x/y").exists(), "what was made for nothing is removed");
    fs::remove_dir_all(folder.path("x")).unwrap();
    finish_all(stage().into()).unwrap();
    assert_eq!([fs::read(&a).unwrap(), fs::read(&b).unwrap()], [b"new", b"new"]);
    assert_eq!(fs::read_dir(folder.path("")).unwrap().count(), 1, "no part is left");
}

#[cfg(unix)]
#[test]
fn an_output_that_became_a_link_to_an_input_is_refused() {
    let folder = Folder::new("became");
    let (input, output) = (folder.path("in.png"), folder.path("out.png"));
    fs::write(&input, b"old").unwrap();
    let inputs = [input.clone()];
    crate::check_output(&output, &inputs, false).unwrap();
    std::os::unix::fs::symlink(&input, &output).unwrap();
    let refused = StagedFile::beside(&output, b"new", false, &inputs);
    assert!(matches!(refused, Err(Error { problem: Problem::IsInput { .. }, .. })), "{refused:?}");
    fs::remove_file(&output).unwrap();
    StagedFile::beside(&output, b"new", false, &inputs).unwrap().finish().unwrap();
    let written = [("in.png".to_owned(), b"old".to_vec()), ("out.png".to_owned(), b"new".to_vec())];
    assert_eq!(folder.files(), written);
}

/// Whatever is named first: what a device refuses is known before a file has its name.
#[test]
fn devices_are_written_before_names_are_taken() {
    let (folder, full) = (Folder::new("devices"), Path::new("/dev/full"));
    if !full.exists() {
        return;
    }
    let path = folder.path("a.png");
    let staged = [path.as_path(), full].map(|path| StagedFile::new(path, b"new", false).unwrap());
    assert!(matches!(finish_all(staged.into()), Err(Error { problem: Problem::NoSpace { bytes: 3 }, .. })));
    assert_eq!(folder.files(), []);
}
