//! Graphcut textures from outside: what a run promises, and what it holds. One binary: each is a link.
#![forbid(unsafe_code)]

mod checkpoint;
mod clips;
mod closing;
mod common;
mod constraints;
mod defaults;
mod footage;
mod levels;
mod memory;
mod strokes;
mod synthesis;
mod video;
mod windows;
