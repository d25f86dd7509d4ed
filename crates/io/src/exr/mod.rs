//! OpenEXR: half and float of any layer or channels, bit for bit.

mod attributes;
mod blocks;
mod map;
mod read;
mod select;
mod write;

pub(crate) use map::{assemble, decode_map, encode_map};
pub(crate) use read::{decode, describe};
pub(crate) use write::{encode, renamed};
