//! The formats: what they are called, how they begin, and what they hold.

use std::fmt;
use std::path::Path;

use crate::Depth;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Format {
    /// Portable Network Graphics.
    Png,
}

const ALL: [Format; 1] = [Format::Png];

impl Format {
    /// Its name in messages and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
        }
    }

    /// The format that a name's extension stands for.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" | "apng" => Some(Self::Png),
            _ => None,
        }
    }

    /// The format whose files begin like this; 16 bytes suffice.
    pub fn of_content(start: &[u8]) -> Option<Self> {
        if start.starts_with(b"\x89PNG\r\n\x1a\n") {
            return Some(Self::Png);
        }
        None
    }

    /// The depths that can be written.
    pub const fn depths(self) -> &'static [Depth] {
        match self {
            Self::Png => &[Depth::U8, Depth::U16],
        }
    }

    /// Names of all formats that can be read.
    pub(crate) fn read() -> String {
        names(|_| true)
    }

    /// Names of all formats that can be written.
    pub(crate) fn written() -> String {
        names(|f| !f.depths().is_empty())
    }

    /// Names of the formats that hold a depth.
    pub(crate) fn holding(depth: Depth) -> String {
        names(|f| f.depths().contains(&depth))
    }
}

fn names(which: impl Fn(Format) -> bool) -> String {
    ALL.iter().filter(|f| which(**f)).map(|f| f.name()).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
