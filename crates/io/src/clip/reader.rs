//! Reading clips, frame by frame.

use std::fmt;
use std::path::{Path, PathBuf};

use selvedge_core::Plane;

use super::info::{ClipInfo, Frames};
use super::names::{ClipName, clip_files};
use super::range::Range;
use super::rate::Rate;
use super::sequence::Sequence;
use crate::error::Error;
use crate::name::file_of;
use crate::{Fingerprint, ReadOptions, Warning, display_name};

/// How to read a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipOptions {
    /// How each of its frames is read.
    pub frame: ReadOptions,
    /// Which frames; default: all.
    pub range: Option<Range>,
    /// How fast it plays, whatever the file says.
    pub rate: Option<Rate>,
}

/// A clip that is read frame by frame.
pub struct ClipReader {
    path: PathBuf,
    info: ClipInfo,
    frames: Box<dyn Frames>,
    read: u32,
}

impl ClipReader {
    /// Whether a name is that of a clip rather than of a picture.
    pub fn is_clip(path: impl AsRef<Path>) -> bool {
        ClipName::parse(file_of(path.as_ref())).is_some()
    }

    /// Looks at a clip: all headers are read and compared.
    ///
    /// # Errors
    /// [`Error`] that names the frame, or the whole clip.
    pub fn open(path: impl AsRef<Path>, options: &ClipOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        let (info, frames) = Sequence::open(path, clip_files(path, options.range)?, &options.frame)?;
        let info = ClipInfo { rate: options.rate.or(info.rate), ..info };
        Ok(Self { path: path.to_path_buf(), info, frames: Box::new(frames), read: 0 })
    }

    /// What the clip is.
    pub fn info(&self) -> &ClipInfo {
        &self.info
    }

    /// The name it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// [`Error`] that names the frame.
    #[expect(clippy::should_implement_trait, reason = "an iterator would not answer with an error first")]
    pub fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        if self.read == self.info.frames {
            return Ok(None);
        }
        self.read += 1;
        self.frames.next()
    }

    /// Goes back to the first frame.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn rewind(&mut self) -> Result<(), Error> {
        self.read = 0;
        self.frames.rewind()
    }

    /// The clip by name and content, once all frames were read.
    pub fn fingerprint(&self) -> Fingerprint {
        Fingerprint { name: display_name(file_of(&self.path)), blake3: self.frames.blake3() }
    }

    /// What was odd in the frames read so far.
    pub fn warnings(&self) -> &[Warning] {
        self.frames.warnings()
    }
}

impl fmt::Debug for ClipReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClipReader").field("path", &self.path).field("info", &self.info).finish_non_exhaustive()
    }
}
