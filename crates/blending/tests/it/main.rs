//! Tests of the crate, in one binary.

mod clips;
mod fused;
mod memory;
mod rendering;
