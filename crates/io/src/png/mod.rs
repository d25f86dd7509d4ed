//! PNG: 8 and 16 bits, grey or colour, with or without alpha; palettes and fewer bits are expanded.

mod pack;
mod palette;
mod read;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::encode;

/// The keyword under which provenance stands.
const KEYWORD: &str = "selvedge";
