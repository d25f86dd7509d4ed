//! OpenEXR: half and float of any layer or channels, bit for bit.

mod blocks;
mod read;
mod select;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::encode;
