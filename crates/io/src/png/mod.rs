//! PNG: 8 and 16 bits, grey or colour, with or without alpha; palettes and fewer bits are expanded.

mod read;
mod write;

pub(crate) use read::decode;
pub(crate) use write::encode;
