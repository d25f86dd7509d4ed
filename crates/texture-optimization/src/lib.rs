//! Texture optimization: synthesis of a whole texture at once, by minimising how far each of its neighborhoods is from
//! the nearest one of the exemplars (Kwatra, Essa, Bobick, Kwatra 2005).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`optimize`], and render what it answers with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Plane, Render, Role, Run};
//! use selvedge_texture_optimization::{Options, optimize};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Stripes of two samples.
//! let bytes: Vec<u8> = (0..24).flat_map(|_| (0..24).map(move |x| if x / 2 % 2 == 0 { b'#' } else { b'.' })).collect();
//! let exemplar = Plane::of_bytes(Role::Color, [24, 24], 1, &bytes)?;
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let woven = optimize(&exemplars, Domain::open([8, 12]), &Options::paper(), &Run::seeded(0))?;
//! let out = woven.result.render(&[&exemplar])?.to_bytes()?;
//! let row = String::from_utf8_lossy(&out[..12]);
//! assert!("#..##..##..##..#".contains(&*row), "{row}");
//! # Ok(())
//! # }
//! ```
//!
//! [`optimize_from`] goes on from a map of any method, which is what the defaults are for: a quilt mended by
//! neighborhoods is better than one made of noise. [`Control`] asks for colours, follows guides and keeps samples.
//! [`Animator`] makes a texture flow, frame after frame.
//!
//! `DESIGN.md` tells why the crate is made as it is, and what each default is worth.
//!
//! # Current state
//! Sections 3 and 4 of the paper; an exact search stands where it has a tree, which is there to compare with.
//!
//! # Features
//! `rayon` (default): averages and searches run on the caller's pool; the output is the same either way.
//!
//! # Papers
//! `[Kwatra05]`: V. Kwatra, I. Essa, A. Bobick, N. Kwatra, *Texture Optimization for Example-based Synthesis*, SIGGRAPH
//! 2005.
#![forbid(unsafe_code)]

mod assignment;
mod average;
mod came;
mod cg;
mod control;
mod error;
mod estimate;
mod falloff;
mod finish;
mod flow;
mod gradient;
mod level;
mod neighborhoods;
mod optimize;
mod optimized;
mod options;
mod picture;
mod robust;
mod schedule;
mod search;
mod so_far;
mod stats;
#[cfg(test)]
mod testing;
mod weaver;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use control::{Control, Wanted};
pub use error::Error;
pub use estimate::estimate;
pub use flow::{
    Animation, Animator, Beside, Checkpoint, Field, FrameStats, Motion, Shown, animation_estimate, checkpoint_bytes,
    closing_bytes,
};
pub use level::Level;
pub use optimize::{Plan, optimize, optimize_from};
pub use optimized::Optimized;
pub use options::{Finish, Options, Search};

pub use stats::{LevelStats, Stats};
