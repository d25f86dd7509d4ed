//! Files that hold all frames of a clip.

use std::path::Path;

use super::y4m::is_y4m;
use crate::Format;

/// A kind of file that holds all frames of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// Animated PNG: 8 and 16 bits, alpha.
    Apng,
    /// GIF: 256 colours, a pixel shows or does not.
    Gif,
    /// Animated WebP: 8 bits, alpha; only read.
    Webp,
    /// YUV4MPEG2: raw luma and chroma.
    Y4m,
}

impl Container {
    /// The container that a name's extension stands for; `-` is y4m.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "png" | "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            "webp" => Some(Self::Webp),
            "y4m" => Some(Self::Y4m),
            _ => (path.as_os_str() == "-").then_some(Self::Y4m),
        }
    }

    /// The container whose files begin like this.
    pub(super) fn of_content(start: &[u8]) -> Option<Self> {
        match Format::of_content(start) {
            Some(Format::Png) => Some(Self::Apng),
            Some(Format::Gif) => Some(Self::Gif),
            Some(Format::Webp) => Some(Self::Webp),
            _ => is_y4m(start).then_some(Self::Y4m),
        }
    }
}
