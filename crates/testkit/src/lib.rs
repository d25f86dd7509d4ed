//! Generated exemplars, comparison of pictures and triptychs for Selvedge's own tests.
//!
//! Everything here is made by pure functions of integers, `+ - * / sqrt` and `libm`, so that a picture is
//! the same on every machine and the committed files can be checked against the code sample for sample.
#![forbid(unsafe_code)]

mod color;
mod compare;
pub mod exemplars;
mod exr;
mod field;
pub mod memory;
mod noise;
pub mod page;
mod picture;
mod relief;
pub mod simple;
pub mod timing;

pub use compare::{Difference, compare, preview, triptych};
pub use exr::to_exr;
pub use noise::Noise;
pub use picture::{bytes, describe, from_png, plane8, plane16, same_samples, to_png};
pub use relief::{Light, Relief, Texel};
