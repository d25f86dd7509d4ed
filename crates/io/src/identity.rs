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

/// Where a name leads, through links of any kind: to a file, or to where one would be made. Of many names those that
/// meet are found by a set of these, where asking of each pair would take the square of their number.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Destination(Leads);

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Leads {
    There(Identity),
    Missing(PathBuf),
    Nowhere(PathBuf),
}

impl Destination {
    /// That of a name, as the file system is now.
    pub fn of(path: &Path) -> Self {
        let missing = || place(path).map(Leads::Missing);
        let leads = identity(path).map(Leads::There).or_else(missing);
        Self(leads.unwrap_or_else(|| Leads::Nowhere(path.to_path_buf())))
    }
}

/// Whether two names lead to one file, through links of any kind, or would once it is made.
pub fn same_file(a: &Path, b: &Path) -> bool {
    Destination::of(a) == Destination::of(b)
}

/// Where a file that does not exist would be, once the folders that it lacks were made.
fn place(path: &Path) -> Option<PathBuf> {
    let whole = Path::new(".").join(dangling(path));
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

/// More links than this one after the other are a ring, as systems have it.
const MOST_LINKS: usize = 40;

/// Where a chain of links that leads to nothing leads.
pub(crate) fn dangling(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(to) = std::fs::read_link(&path) else { break };
        path = path.parent().unwrap_or(Path::new("")).join(to);
    }
    path
}

/// The input that a name leads to.
pub(crate) fn input_at<'i>(output: &Path, inputs: &'i [PathBuf]) -> Option<&'i PathBuf> {
    let at = Destination::of(output);
    inputs.iter().find(|input| Destination::of(file_of(input)) == at)
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn links_that_lead_to_nothing_yet_are_followed() {
        let folder = std::env::temp_dir().join(format!("selvedge-identity-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("sub")).unwrap();
        for (to, link) in
            [("o.png", "m.exr"), ("m.exr", "n.exr"), ("../o.png", "sub/index.html"), ("b", "a"), ("a", "b")]
        {
            symlink(to, folder.join(link)).unwrap();
        }
        let same = |a: &str, b: &str| same_file(&folder.join(a), &folder.join(b));
        for (a, b) in [("o.png", "m.exr"), ("m.exr", "n.exr"), ("sub/index.html", "o.png"), ("sub/index.html", "n.exr")]
        {
            assert!(same(a, b) && same(b, a), "{a} {b}");
        }
        assert!(!same("o.png", "p.png") && !same("m.exr", "sub/o.png") && !same("a", "o.png"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
