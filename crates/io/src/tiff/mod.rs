//! TIFF: 8 and 16 bits, half and float, in strips, tiles or planes; fewer bits and palettes are expanded.

mod channels;
mod chosen;
mod colors;
mod compression;
mod directory;
mod palette;
mod planes;
mod read;
mod said;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::encode;
