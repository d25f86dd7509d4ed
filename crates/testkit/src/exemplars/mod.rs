//! Procedural exemplars that look like something: each a surface, a light, and the planes made of both.

mod bricks;
mod cobbles;
mod scales;
mod weave;

pub use bricks::{Bricks, bricks};
pub use cobbles::{cobbles, cobbles_with_hole};
pub use scales::{scales, scales_hdr};
pub use weave::weave;
