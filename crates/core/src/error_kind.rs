//! Who can mend an error.

/// Who can mend an error, in every crate but max-flow's, which stands alone; the program's exit code follows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An option is wrong by itself.
    Option,
    /// The input is wrong, or does not fit an option.
    Input,
    /// A file is missing, denied, read-only, or in the way.
    FileSystem,
    /// The disk or the quota is full.
    NoSpace,
    /// The memory budget does not suffice.
    Memory,
    /// A promise of the library was broken.
    Internal,
}
