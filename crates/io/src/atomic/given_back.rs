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
