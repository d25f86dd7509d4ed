//! Files that hold all frames of a clip.

use std::path::Path;

use super::problem::ClipProblem;
use super::y4m::is_y4m;
use crate::error::Problem;
use crate::{Depth, Format};

/// A kind of file that holds all frames of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// Animated PNG: 8 and 16 bits, alpha.
    Apng,
    /// GIF: 256 colours, a pixel shows or does not.
    Gif,
    /// Animated WebP: 8 bits, alpha; only read.
    Webp,
    /// YUV4MPEG2: raw luma and chroma of 8 or 16 bits.
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

    /// Refuses frames that the container does not hold.
    pub(super) fn check(self, colors: usize, alpha: bool, depth: Depth, shape: [u32; 2]) -> Result<(), Problem> {
        let container = match self {
            Self::Apng | Self::Webp => return Format::Png.check(shape, colors, alpha, depth),
            Self::Gif => "gif",
            Self::Y4m => "y4m",
        };
        let no = |what: String| Err(ClipProblem::Unsupported { container, what }.into());
        match (depth, colors) {
            (Depth::U8 | Depth::U16, 1 | 3) if self == Self::Y4m => {
                if alpha {
                    no("alpha".into())
                } else {
                    Ok(())
                }
            }
            (Depth::U8, 1 | 3) if self == Self::Gif && shape.iter().any(|side| u32::from(u16::MAX) < *side) => {
                no("a side over 65,535 px".into())
            }
            (Depth::U8, 1 | 3) => Ok(()),
            (Depth::U8, n) => no(format!("a clip of {n} channels")),
            _ => no(format!("a clip of {} samples", depth.name())),
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
