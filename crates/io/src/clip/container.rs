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
    /// MP4, and those below: by an `ffmpeg` that is installed.
    Mp4,
    /// QuickTime.
    Mov,
    /// WebM.
    Webm,
    /// Matroska.
    Mkv,
    /// AVI.
    Avi,
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
            "mp4" | "m4v" => Some(Self::Mp4),
            "mov" => Some(Self::Mov),
            "webm" => Some(Self::Webm),
            "mkv" => Some(Self::Mkv),
            "avi" => Some(Self::Avi),
            _ => (path.as_os_str() == "-").then_some(Self::Y4m),
        }
    }

    /// Refuses frames that the container does not hold.
    pub(super) fn check(self, colors: usize, alpha: bool, depth: Depth, shape: [u32; 2]) -> Result<(), Problem> {
        if matches!(self, Self::Apng | Self::Webp) {
            return Format::Png.check(shape, colors, alpha, depth);
        }
        let container = self.name();
        let no = |what: String| Err(ClipProblem::Unsupported { container, what }.into());
        if self.muxer().is_some() && depth.bytes() <= 2 && depth != Depth::F16 && matches!(colors, 1 | 3) {
            return Ok(());
        }
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

    /// What `ffmpeg` calls it, where that reads and writes it.
    pub fn muxer(self) -> Option<&'static str> {
        match self {
            Self::Mp4 | Self::Mov | Self::Webm | Self::Avi => Some(self.name()),
            Self::Mkv => Some("matroska"),
            Self::Apng | Self::Gif | Self::Webp | Self::Y4m => None,
        }
    }

    /// What it is called.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Apng => "apng",
            Self::Gif => "gif",
            Self::Webp => "webp",
            Self::Y4m => "y4m",
            Self::Mp4 => "mp4",
            Self::Mov => "mov",
            Self::Webm => "webm",
            Self::Mkv => "mkv",
            Self::Avi => "avi",
        }
    }

    /// The container whose files begin like this.
    pub(super) fn of_content(start: &[u8]) -> Option<Self> {
        match Format::of_content(start) {
            Some(Format::Png) => Some(Self::Apng),
            Some(Format::Gif) => Some(Self::Gif),
            Some(Format::Webp) => Some(Self::Webp),
            _ if is_y4m(start) => Some(Self::Y4m),
            _ => Self::foreign(start),
        }
    }

    /// Those of other programs. [ISO/IEC 14496-12, 4.3; RFC 8794, 8; AVI RIFF]
    fn foreign(start: &[u8]) -> Option<Self> {
        let at = |from: usize| start.get(from..from + 4).unwrap_or_default();
        match (at(0), at(4), at(8)) {
            (_, b"ftyp", b"qt  ") | (_, b"moov" | b"mdat" | b"wide", _) => Some(Self::Mov),
            (_, b"ftyp", _) => Some(Self::Mp4),
            (b"\x1a\x45\xdf\xa3", ..) => Some(Self::Mkv),
            (b"RIFF", _, b"AVI ") => Some(Self::Avi),
            _ => None,
        }
    }
}
