//! What kind of texture is it? One analysis for all that choose by themselves: sizes, placements, defaults, advice.
//!
//! - [`Texture`] says what kind of texture an exemplar is: lattice, lines, rows of text, bodies, grain, uneven light.
//! - [`periods()`] lists the translations under which an exemplar resembles itself.
//! - [`feature_size()`] is the side of a box that holds the largest structures.
//!
//! All of it follows from exact integer sums over the exemplars' features: the same on any machine and any number of
//! threads. Nothing here knows which method asks.
//!
//! # Features
//! `rayon` (default): searches are split over the caller's pool; the result is the same without it.
#![forbid(unsafe_code)]

mod estimate;
mod feature_size;
mod lattice;
mod lines;
mod near;
mod periods;
mod picture;
mod reach;
mod texture;

pub use estimate::{estimate, estimate_size, estimate_texture};
pub use feature_size::{feature_size, feature_size_of};
pub use lattice::Lattice;
pub use lines::Lines;
pub use periods::{Period, periods};
/// What an analysis can fail with is what its searches can.
pub use selvedge_fft_ssd::Error;
pub use texture::{Kind, Texture};
