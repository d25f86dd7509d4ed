//! What all frames of a clip have in common, and where they come from.

use std::fmt;
use std::path::Path;

use selvedge_core::{Association, Depth, Plane};

use super::problem::ClipProblem;
use super::rate::Rate;
use crate::error::{Error, Problem};
use crate::{Fingerprint, Metadata, Warning};

/// What a clip is, known before its frames are read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClipInfo {
    /// Samples along x of every frame, the right way up.
    pub width: u32,
    /// Samples along y of every frame.
    pub height: u32,
    /// Frames.
    pub frames: u32,
    /// How fast it plays, where it says so.
    pub rate: Option<Rate>,
    /// Channels, alpha included.
    pub channels: usize,
    /// Whether the last channel is alpha.
    pub alpha: bool,
    /// How colour and alpha go together.
    pub association: Association,
    /// How samples are stored.
    pub depth: Depth,
    /// What the first frame says besides.
    pub metadata: Metadata,
    /// What it lies in: `png sequence`, `gif`.
    pub container: String,
}

/// What all frames of a clip have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) channels: usize,
    pub(super) alpha: bool,
    pub(super) association: Association,
    pub(super) depth: Depth,
}

impl Layout {
    pub(super) fn of(plane: &Plane<2>) -> Self {
        let [height, width] = plane.domain().shape;
        let (channels, depth) = (plane.samples.channels(), plane.samples.depth());
        Self { width, height, channels, alpha: plane.alpha, association: plane.association, depth }
    }

    /// So many frames that are pictures, of which none tells a rate.
    pub(super) fn info(self, frames: u32, metadata: Metadata, container: String) -> ClipInfo {
        let Self { width, height, channels, alpha, association, depth } = self;
        ClipInfo { width, height, frames, rate: None, channels, alpha, association, depth, metadata, container }
    }

    /// Refuses another layout than that of the first frame.
    pub(super) fn check(&self, path: &Path, number: u32, found: &Self) -> Result<(), Error> {
        // Without alpha it means nothing.
        let same = Self { association: self.association, ..*found } == *self
            && (!self.alpha || self.association == found.association);
        if same {
            return Ok(());
        }
        Err(Error::new(path, ClipProblem::Differs { number, found: found.to_string(), first: self.to_string() }))
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, channels, alpha, association, depth } = *self;
        let (colors, depth) = (channels - usize::from(alpha), depth.name());
        write!(f, "{width}x{height} px, {colors} {depth} channel(s)")?;
        match (alpha, association) {
            (false, _) => Ok(()),
            (true, Association::Straight) => write!(f, " and alpha"),
            (true, Association::Premultiplied) => write!(f, " and premultiplied alpha"),
        }
    }
}

/// What frames come from.
pub(super) trait Frames {
    /// The next frame; `None` after the last.
    fn next(&mut self) -> Result<Option<Plane<2>>, Error>;
    /// Passes over the next frame; false after the last.
    fn skip(&mut self) -> Result<bool, Error> {
        Ok(self.next()?.is_some())
    }
    /// Goes back to the first frame.
    fn rewind(&mut self) -> Result<(), Error>;
    /// BLAKE3 of what was read, in hexadecimal: of the file, or of the hashes of the frames' files in order. Known
    /// once all frames were read.
    fn blake3(&self) -> String;
    /// By name and content, the file of each frame that was read, where each has its own.
    fn files(&self) -> Vec<Fingerprint> {
        Vec::new()
    }
    /// What was odd.
    fn warnings(&self) -> &[Warning];
}

/// What makes one file of many frames.
pub(super) trait FrameEncoder {
    /// Takes the next frame.
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem>;
    /// The whole file.
    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem>;
}
