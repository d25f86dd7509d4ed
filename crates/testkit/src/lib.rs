//! Generated exemplars, comparison of pictures and triptychs for Selvedge's own tests.
//!
//! Everything here is made by pure functions of integers, `+ - * / sqrt` and `libm`, so that a picture is
//! the same on every machine and the committed files can be checked against the code sample for sample.
#![forbid(unsafe_code)]

mod color;
pub mod exemplars;
mod field;
mod noise;
mod picture;
mod relief;
pub mod simple;

pub use noise::Noise;
pub use picture::{bytes, describe, from_png, plane8, plane16, same_samples, to_png};
pub use relief::{Light, Relief, Texel};
