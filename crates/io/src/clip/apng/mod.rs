//! Animated PNG: 8 and 16 bits, grey and colour, with and without alpha.

mod blend;
mod read;
mod write;

pub(super) use read::Apng;
pub(super) use write::ApngWriter;
