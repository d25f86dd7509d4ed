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

/// The file with one of its `n` planes alone.
pub(super) fn alone(file: &[u8], plane: usize, n: usize) -> Result<Vec<u8>, Problem> {
    let directory = Directory::of(file)?;
    let mut out = Vec::new();
    let refused = |_| selvedge_core::Error::Allocation { bytes: file.len() as u64 };
    out.try_reserve(file.len()).map_err(refused)?;
    out.extend_from_slice(file);
    let mut patch = || {
        for tag in TILES {
            let all = directory.numbers(file, tag)?;
            let one = all.len().checked_div(n).filter(|one| one * n == all.len())?;
            directory.set_all(&mut out, tag, all.get(plane * one..(plane + 1) * one)?)?;
        }
        for tag in [BITS, SAMPLE_FORMAT] {
            if let Some(value) = directory.numbers(file, tag).and_then(|v| u16::try_from(*v.first()?).ok()) {
                directory.set(&mut out, tag, value)?;
            }
        }
        directory.set(&mut out, SAMPLES, 1)?;
        directory.set(&mut out, PHOTOMETRIC, 1)?;
        directory.set(&mut out, PLANAR, 1)?;
        let _ = directory.rename(&mut out, EXTRA_SAMPLES, NOTHING);
        Some(())
    };
    patch().ok_or_else(|| Problem::damaged(Format::Tiff, "its tiles do not belong to its planes"))?;
    Ok(out)
}
