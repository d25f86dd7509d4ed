//! Writing clips, frame by frame.

use std::path::{Path, PathBuf};

use selvedge_core::Plane;

use super::manifest::Manifest;
use super::names::ClipName;
use super::problem::ClipProblem;
use super::rate::Rate;
use crate::error::Error;
use crate::{Format, Metadata, WriteOptions, display_name, encode, write_bytes};

/// How to write a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipWriteOptions {
    /// How each of its frames is written.
    pub frame: WriteOptions,
    /// How fast it plays.
    pub rate: Option<Rate>,
    /// Frames after which it begins again, for a loop.
    pub period: Option<u32>,
}

/// A file of a clip, whole.
pub type ClipFile = (PathBuf, Vec<u8>);

/// A clip that is written frame by frame.
#[derive(Debug)]
pub struct ClipWriter {
    name: ClipName,
    metadata: Metadata,
    options: ClipWriteOptions,
    frames: u32,
    size: [u32; 2],
    written: Vec<(String, String)>,
}

impl ClipWriter {
    /// Begins a clip of so many frames. Nothing is written yet.
    ///
    /// # Errors
    /// [`ClipProblem::NoClip`], and those of a picture of the frames' name.
    pub fn create(
        path: impl AsRef<Path>,
        frames: u32,
        metadata: Metadata,
        options: ClipWriteOptions,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        let no_clip = || Error::new(path, ClipProblem::NoClip);
        let name = ClipName::parse(path).ok_or_else(no_clip)?;
        options.frame.format_of(name.file(1).ok_or_else(no_clip)?)?;
        Ok(Self { name, metadata, options, frames, size: [0, 0], written: Vec::new() })
    }

    /// All files that will be there at the end.
    pub fn files(&self) -> Vec<PathBuf> {
        let frames = (1..=self.frames).filter_map(|number| self.name.file(number));
        frames.chain([self.name.manifest()]).collect()
    }

    /// Frames of a longer clip of this name, which nothing replaces.
    pub fn left_over(&self) -> Vec<PathBuf> {
        let ClipName::Sequence(_) = self.name else { return Vec::new() };
        let found = self.name.found().unwrap_or_default();
        let mut left: Vec<_> = found
            .into_iter()
            .filter_map(|(number, file)| Some((number?, file)))
            .filter(|(number, _)| !(1..=self.frames).contains(number))
            .collect();
        left.sort();
        left.into_iter().map(|(_, file)| file).collect()
    }

    /// The format of its frames.
    ///
    /// # Errors
    /// Those of [`WriteOptions::format_of`].
    pub fn format(&self) -> Result<Format, Error> {
        self.options.frame.format_of(self.name.file(1).unwrap_or_default())
    }

    /// The next frame, as a file to be written.
    ///
    /// # Errors
    /// Those of a picture.
    pub fn encoded(&mut self, plane: &Plane<2>) -> Result<ClipFile, Error> {
        let number = self.written.len() as u32 + 1;
        let path = self.name.file(number).unwrap_or_default();
        let bytes = encode(plane, &self.metadata, &path, &self.options.frame)?;
        let [height, width] = plane.domain().shape;
        self.size = [width, height];
        self.written.push((display_name(&path), blake3::hash(&bytes).to_hex().to_string()));
        Ok((path, bytes))
    }

    /// Writes the next frame: the file appears whole or not at all.
    ///
    /// # Errors
    /// Those of [`write`](crate::write()).
    pub fn frame(&mut self, plane: &Plane<2>) -> Result<(), Error> {
        let (path, bytes) = self.encoded(plane)?;
        write_bytes(&path, &bytes, self.options.frame.no_clobber)
    }

    /// What is written after the last frame: the file that tells of them all.
    ///
    /// # Errors
    /// [`ClipProblem::Count`].
    pub fn ended(&self) -> Result<ClipFile, Error> {
        let (path, found, expected) = (self.name.manifest(), self.written.len() as u32, self.frames);
        if found != expected {
            return Err(Error::new(&path, ClipProblem::Count { expected, found }));
        }
        let (rate, period) = (self.options.rate, self.options.period);
        let manifest = Manifest { size: self.size, rate, period, frames: self.written.clone(), more: Vec::new() };
        Ok((path, manifest.json().into_bytes()))
    }

    /// Writes what comes last.
    ///
    /// # Errors
    /// Those of [`ended`](Self::ended) and of [`write_bytes`].
    pub fn finish(self) -> Result<(), Error> {
        let (path, bytes) = self.ended()?;
        write_bytes(&path, &bytes, self.options.frame.no_clobber)
    }
}
