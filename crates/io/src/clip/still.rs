//! A picture that stands for all frames of a clip.

use std::path::Path;

use selvedge_core::Plane;

use super::info::{ClipInfo, Frames, Layout};
use crate::error::Error;
use crate::read::{Picture, decode, read};
use crate::{ReadOptions, Warning};

/// A picture, read once, as so many frames.
pub(super) struct Still {
    plane: Plane<2>,
    blake3: String,
    warnings: Vec<Warning>,
    frames: u32,
    at: u32,
}

impl Still {
    /// Reads the picture.
    pub(super) fn open(path: &Path, frames: u32, options: &ReadOptions) -> Result<(ClipInfo, Self), Error> {
        Ok(Self::of(read(path, options)?, frames))
    }

    /// The same of one that was read as bytes.
    pub(super) fn of_bytes(
        bytes: &[u8],
        path: &Path,
        frames: u32,
        options: &ReadOptions,
    ) -> Result<(ClipInfo, Self), Error> {
        Ok(Self::of(decode(bytes, path, options)?, frames))
    }

    fn of(picture: Picture, frames: u32) -> (ClipInfo, Self) {
        let container = format!("{} picture", picture.format);
        let info = Layout::of(&picture.plane).info(frames, picture.metadata, container);
        let (plane, blake3, warnings) = (picture.plane, picture.blake3, picture.warnings);
        (info, Self { plane, blake3, warnings, frames, at: 0 })
    }
}

impl Frames for Still {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        Ok(self.skip()?.then(|| self.plane.clone()))
    }

    fn skip(&mut self) -> Result<bool, Error> {
        let is_left = self.at < self.frames;
        self.at += u32::from(is_left);
        Ok(is_left)
    }

    fn rewind(&mut self) -> Result<(), Error> {
        self.at = 0;
        Ok(())
    }

    fn blake3(&self) -> String {
        self.blake3.clone()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}
