//! Files of a set that could not be put back as they were.

use std::path::PathBuf;

use crate::name::quoted;

/// A file that has its new content though the set that it belongs to was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftFile {
    /// Its name.
    pub path: PathBuf,
    /// The file that holds its old content, if that is left.
    pub old: Option<PathBuf>,
}

impl LeftFile {
    pub(super) fn shown(&self) -> String {
        let old = self.old.as_ref().map(|old| format!(" (its old content is in {})", quoted(old)));
        quoted(&self.path) + &old.unwrap_or_default()
    }
}
