//! Procedural exemplars that look like something: each a surface, a light, and the planes made of both.

mod beach;
mod bricks;
mod cobbles;
mod knit;
mod letters;
mod planks;
mod plaster;
mod scales;
mod tiles;
mod weave;

pub use beach::beach;
pub use bricks::{Bricks, bricks};
pub use cobbles::{cobbles, cobbles_with_hole};
pub use knit::knit;
pub use letters::letters;
pub use planks::planks;
pub use plaster::plaster;
pub use scales::{scales, scales_hdr};
pub use tiles::tiles;
pub use weave::weave;
