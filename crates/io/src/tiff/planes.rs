//! Tiles of separate planes. The decoder takes the last row of tiles of every plane but the first for whole ones, so it
//! is shown one plane after the other, as a grey picture of its own.

use super::directory::{Directory, EXTRA_SAMPLES, PHOTOMETRIC, SAMPLES, TILES};
use crate::Format;
use crate::error::Problem;

const BITS: u16 = 258;
const PLANAR: u16 = 284;
const SAMPLE_FORMAT: u16 = 339;
/// A tag that nobody reads.
const NOTHING: u16 = 65_000;

/// Whether a file has tiles of separate planes.
pub(super) fn are_tiled(file: &[u8]) -> bool {
    let number = |tag| Directory::of(file).ok()?.first(file, tag);
    number(PLANAR) == Some(2) && number(TILES[0]).is_some()
}

/// A file whose planes are shown alone, one after the other.
pub(super) struct Planes {
    file: Vec<u8>,
    /// As it was, with its directory and its entries.
    len: usize,
    directory: Directory,
    entries: Vec<u8>,
    /// Where the tiles of all planes are, and how long.
    tiles: [Vec<u64>; 2],
    /// Planes.
    n: usize,
}

impl Planes {
    /// Of a file of `n` planes.
    pub(super) fn of(file: Vec<u8>, n: usize) -> Result<Self, Problem> {
        let directory = Directory::of(&file)?;
        let found = || {
            let entries = file.get(directory.entries()?)?.to_vec();
            let [Some(at), Some(len)] = TILES.map(|tag| directory.numbers(&file, tag)) else { return None };
            (0 < n && at.len().is_multiple_of(n) && len.len() == at.len()).then_some((entries, [at, len]))
        };
        let (entries, tiles) = found().ok_or_else(unlike)?;
        Ok(Self { len: file.len(), file, directory, entries, tiles, n })
    }

    /// The file with this plane alone.
    pub(super) fn alone(&mut self, plane: usize) -> Result<&[u8], Problem> {
        self.restore();
        self.patch(plane).ok_or_else(unlike)?;
        Ok(&self.file)
    }

    fn patch(&mut self, plane: usize) -> Option<()> {
        let (directory, file) = (self.directory, &mut self.file);
        for (tag, all) in TILES.into_iter().zip(&self.tiles) {
            let one = all.len() / self.n;
            directory.set_all(file, tag, all.get(plane * one..(plane + 1) * one)?)?;
        }
        for tag in [BITS, SAMPLE_FORMAT] {
            if let Some(value) = directory.numbers(file, tag).and_then(|v| u16::try_from(*v.first()?).ok()) {
                directory.set(file, tag, value)?;
            }
        }
        directory.set(file, SAMPLES, 1)?;
        directory.set(file, PHOTOMETRIC, 1)?;
        directory.set(file, PLANAR, 1)?;
        let _ = directory.rename(file, EXTRA_SAMPLES, NOTHING);
        Some(())
    }

    /// The file as it was.
    pub(super) fn whole(mut self) -> Vec<u8> {
        self.restore();
        self.file
    }

    fn restore(&mut self) {
        self.file.truncate(self.len);
        let entries = self.directory.entries().expect("its entries were read");
        self.file[entries].copy_from_slice(&self.entries);
    }
}

fn unlike() -> Problem {
    Problem::damaged(Format::Tiff, "its tiles do not belong to its planes")
}
