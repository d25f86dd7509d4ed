//! Clips of one file a frame.

use std::path::{Path, PathBuf};

use selvedge_core::Plane;

use super::info::{ClipInfo, Frames, Layout};
use super::problem::ClipProblem;
use crate::error::Error;
use crate::read::read;
use crate::{Fingerprint, ReadOptions, Warning, display_name, probe};

/// Files, read one after the other.
pub(super) struct Sequence {
    files: Vec<PathBuf>,
    options: ReadOptions,
    layout: Layout,
    /// Of the files read so far.
    hashes: Vec<String>,
    warnings: Vec<Warning>,
    at: usize,
}

impl Sequence {
    /// Looks at the files: the first is read, of the others the headers.
    pub(super) fn open(path: &Path, files: Vec<PathBuf>, options: &ReadOptions) -> Result<(ClipInfo, Self), Error> {
        let first = files.first().ok_or_else(|| Error::new(path, ClipProblem::NoFrames))?;
        let (header, read) = (probe(first, options)?, read(first, options)?);
        for (file, number) in files.iter().zip(1..).skip(1) {
            let found = probe(file, options)?;
            let headed = |info: &crate::Info| Layout {
                width: info.width,
                height: info.height,
                channels: info.channels,
                alpha: info.alpha,
                association: info.association,
                depth: info.depth,
            };
            headed(&header).check(file, number, &headed(&found))?;
        }
        let layout = Layout::of(&read.plane);
        let info = layout.info(files.len() as u32, read.metadata, format!("{} sequence", read.format));
        let (hashes, warnings) = (Vec::new(), Vec::new());
        Ok((info, Self { files, options: options.clone(), layout, hashes, warnings, at: 0 }))
    }
}

impl Frames for Sequence {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let Some(file) = self.files.get(self.at) else { return Ok(None) };
        let picture = read(file, &self.options)?;
        self.at += 1;
        // Headers were compared, but files may change meanwhile, and GIF tells with its samples what it holds.
        self.layout.check(file, self.at as u32, &Layout::of(&picture.plane))?;
        match self.hashes.get(self.at - 1) {
            Some(hash) if *hash != picture.blake3 => return Err(Error::new(file, ClipProblem::Changed)),
            Some(_) => {}
            None => self.hashes.push(picture.blake3),
        }
        for warning in picture.warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        Ok(Some(picture.plane))
    }

    fn skip(&mut self) -> Result<bool, Error> {
        // What was not read yet has no hash.
        if self.at < self.hashes.len() {
            self.at += 1;
            return Ok(true);
        }
        Ok(self.next()?.is_some())
    }

    fn rewind(&mut self) -> Result<(), Error> {
        self.at = 0;
        Ok(())
    }

    fn blake3(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for hash in &self.hashes {
            hasher.update(hash.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    fn files(&self) -> Vec<Fingerprint> {
        let named = |(file, hash): (&PathBuf, &String)| Fingerprint { name: display_name(file), blake3: hash.clone() };
        self.files.iter().zip(&self.hashes).map(named).collect()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}
