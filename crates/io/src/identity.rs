//! Which file or folder a name leads to, however it is spelled.

use std::path::Path;

/// What two names of one file have in common.
#[cfg(unix)]
pub(crate) type Identity = (u64, u64);
/// What two names of one file have in common.
#[cfg(not(unix))]
pub(crate) type Identity = std::path::PathBuf;

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
