//! Textures that flow: frame after frame, each as near to the one before, moved, as a texture can be. `[Kwatra05 4.1]`

mod animator;
#[cfg(test)]
mod came_from_tests;
mod carry;
mod checkpoint;
mod closing;
mod drift;
mod fields;
mod trust;

pub use animator::{Animation, Animator, FrameStats, animation_estimate, closing_bytes};
pub(crate) use carry::Carried;
pub use checkpoint::{Checkpoint, checkpoint_bytes};
pub use drift::{Beside, Shown};
pub use fields::{Field, Motion};
