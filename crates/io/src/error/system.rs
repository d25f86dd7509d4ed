//! What a file system refuses, as a problem of ours.

use std::io;

use super::{LostFolder, Problem, WriteProtected};

impl Problem {
    /// A file system's refusal, while `bytes` were to be written.
    pub(crate) fn file_system(error: io::Error, bytes: u64) -> Self {
        use io::ErrorKind as Io;
        match error.kind() {
            Io::NotFound => Self::Missing,
            Io::NotADirectory => Self::NoFolder,
            Io::PermissionDenied => Self::Denied,
            Io::ReadOnlyFilesystem => Self::ReadOnly,
            Io::Other if error.get_ref().is_some_and(|e| e.is::<WriteProtected>()) => Self::WriteProtected,
            Io::Other if error.get_ref().is_some_and(|e| e.is::<LostFolder>()) => Self::LostFolder,
            Io::AlreadyExists => Self::Exists,
            Io::IsADirectory => Self::Folder,
            Io::StorageFull | Io::QuotaExceeded | Io::FileTooLarge => Self::NoSpace { bytes },
            Io::OutOfMemory => Self::Core(selvedge_core::Error::Allocation { bytes }),
            _ => Self::FileSystem(error),
        }
    }
}
