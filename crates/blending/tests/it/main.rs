//! Tests of the crate, in one binary.

mod clips;
mod memory;
mod rendering;
