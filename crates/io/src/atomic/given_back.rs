//! Sets of files of which a later one cannot take its name.

use super::tests::Folder;
use super::*;

/// A file system on which the last of some names cannot be taken.
struct FailsFor(PathBuf);
impl Steps for FailsFor {
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        if path == self.0 { Err(io::ErrorKind::StorageFull.into()) } else { Disk.take_name(part, path, no_clobber) }
    }
}

#[test]
fn names_that_were_taken_are_given_back_when_a_later_one_is_refused() {
    let folder = Folder::new("back");
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(|name| folder.path(name));
    fs::write(&a, b"old").unwrap();
    fs::write(&c, b"last").unwrap();
    let last = fs::canonicalize(&c).unwrap();
    let staged = [&a, &b, &c].map(|path| StagedFile::new(path, b"new", false).unwrap());
    let refused = finish_with(&FailsFor(last), staged.into());
    assert!(matches!(refused, Err(Error { problem: Problem::NoSpace { .. }, .. })));
    let expected = [("a.png".to_owned(), b"old".to_vec()), ("c.png".to_owned(), b"last".to_vec())];
    assert_eq!(folder.files(), expected, "b is gone again, and nothing else lies there");
    let staged = [&a, &b, &c].map(|path| StagedFile::new(path, b"new", false).unwrap());
    finish_all(staged.into()).unwrap();
    assert_eq!(folder.files(), ["a.png", "b.png", "c.png"].map(|name| (name.to_owned(), b"new".to_vec())));
}

/// The same without hard links: nothing is kept of the old files.
struct FailsUnlinked(FailsFor);
impl Steps for FailsUnlinked {
    fn link(&self, _: &Path, _: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        self.0.take_name(part, path, no_clobber)
    }
}

#[test]
fn what_cannot_be_given_back_is_told() {
    let folder = Folder::new("not-back");
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(|name| folder.path(name));
    fs::write(&a, b"old").unwrap();
    fs::write(&c, b"last").unwrap();
    let last = fs::canonicalize(&c).unwrap();
    let staged = [&a, &b, &c].map(|path| StagedFile::new(path, b"new", false).unwrap());
    let refused = finish_with(&FailsUnlinked(FailsFor(last)), staged.into()).unwrap_err();
    let Problem::Left { cause, files } = &refused.problem else { panic!("{refused}") };
    assert!(
        matches!(**cause, Problem::NoSpace { .. }) && *files == [LeftFile { path: a.clone(), old: None }],
        "{refused}"
    );
    assert!(refused.to_string().contains("a.png' could not be put back as before"), "{refused}");
    assert!(!b.exists() && fs::read(a).unwrap() == b"new");
}

/// A name that can be taken once only: neither is the last one taken nor the first one given back.
struct FailsTwice {
    last: FailsFor,
    taken: std::cell::RefCell<Vec<PathBuf>>,
}
impl Steps for FailsTwice {
    fn take_name(&self, part: &Path, path: &Path, no_clobber: bool) -> io::Result<()> {
        if self.taken.borrow().iter().any(|taken| taken == path) {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        self.taken.borrow_mut().push(path.to_path_buf());
        self.last.take_name(part, path, no_clobber)
    }
}

#[test]
fn old_content_that_cannot_be_given_back_is_kept_and_named() {
    let folder = Folder::new("aside");
    let [a, b] = ["a.png", "b.png"].map(|name| folder.path(name));
    for path in [&a, &b] {
        fs::write(path, b"old").unwrap();
    }
    fs::write(folder.path("a.png.old"), b"older").unwrap();
    let last = FailsFor(fs::canonicalize(&b).unwrap());
    let staged = [&a, &b].map(|path| StagedFile::new(path, b"new", false).unwrap());
    let refused = finish_with(&FailsTwice { last, taken: Default::default() }, staged.into()).unwrap_err();
    assert!(refused.to_string().contains("(its old content is in '"), "{refused}");
    let Problem::Left { files, .. } = &refused.problem else { panic!("{refused}") };
    let old = files[0].old.as_ref().unwrap();
    assert!(old.ends_with("a.png.old.1") && fs::read(old).unwrap() == b"old");
    // The next run of these names leaves it where it is.
    let staged = [&a, &b].map(|path| StagedFile::new(path, b"new", false).unwrap());
    finish_all(staged.into()).unwrap();
    let names: Vec<String> = folder.files().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.png", "a.png.old", "a.png.old.1", "b.png"]);
}

#[cfg(unix)]
#[test]
fn what_a_run_keeps_to_give_back_is_swept_by_no_other() {
    let folder = Folder::new("kept");
    let (path, kept) = (folder.path("a.png"), folder.path(".a.png.12-3.0.part"));
    fs::write(&kept, b"old").unwrap();
    let of_writer = File::open(folder.path("")).unwrap();
    of_writer.lock().unwrap();
    super::parts::sweep(&Disk, &path);
    assert!(kept.exists(), "its writer has the folder");
    drop(of_writer);
    super::parts::sweep(&Disk, &path);
    assert!(!kept.exists(), "its writer is gone");
}
