//! PNG: 8 and 16 bits, grey or colour, with or without alpha; palettes and fewer bits are expanded.

mod pack;
mod palette;
mod read;
mod write;

pub(crate) use read::{complaint, decode, describe, header, metadata};
pub(crate) use write::{encode, info_of};

/// The keyword under which provenance stands.
pub(crate) const KEYWORD: &str = "selvedge";
pub(crate) use pack::packing_room;
