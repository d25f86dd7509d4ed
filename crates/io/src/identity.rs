//! Which file or folder a name leads to, however it is spelled.

use std::path::{Component, Path, PathBuf};

use crate::name::file_of;

/// What two names of one file have in common.
#[cfg(unix)]
pub(crate) type Identity = (u64, u64);
/// What two names of one file have in common.
#[cfg(not(unix))]
pub(crate) type Identity = PathBuf;

/// That of an existing file or folder, through links of any kind.
#[cfg(unix)]
pub(crate) fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt as _;
    std::fs::metadata(path).ok().map(|m| (m.dev(), m.ino()))
}

/// That of an existing file or folder, through links of any kind.
#[cfg(not(unix))]
pub(crate) fn identity(path: &Path) -> Option<Identity> {
    std::fs::canonicalize(path).ok()
}

/// Whether two names lead to one file, through links of any kind, or would once it is made.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let same = |a: Option<PathBuf>, b: Option<PathBuf>| a.is_some() && a == b;
    match (identity(a), identity(b)) {
        (Some(a), Some(b)) => a == b,
        (None, None) => a == b || same(place(a), place(b)),
        _ => false,
    }
}

/// Where a file that does not exist would be, once the folders that it lacks were made.
fn place(path: &Path) -> Option<PathBuf> {
    let whole = Path::new(".").join(path);
    let there = whole.ancestors().skip(1).find_map(|folder| Some((folder, std::fs::canonicalize(folder).ok()?)));
    let (folder, mut place) = there?;
    for part in whole.strip_prefix(folder).ok()?.components() {
        match part {
            Component::ParentDir => drop(place.pop()),
            part => place.push(part),
        }
    }
    Some(place)
}

/// The input that a name leads to.
pub(crate) fn input_at<'i>(output: &Path, inputs: &'i [PathBuf]) -> Option<&'i PathBuf> {
    inputs.iter().find(|input| same_file(output, file_of(input)))
}
