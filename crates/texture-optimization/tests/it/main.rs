//! Tests of the crate as others use it.

mod bad_input;
mod flow;
mod memory;
mod runs;
