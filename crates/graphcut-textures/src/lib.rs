//! Graphcut textures: synthesis from patches of any shape, cut along the best seams (Kwatra et al. 2003).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`graphcut`], and render the map that it answers
//! with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Plane, Render, Role, Run};
//! use selvedge_graphcut_textures::{Options, graphcut};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of four samples.
//! let board = |y: u32, x: u32| if (y / 4 + x / 4) % 2 == 0 { b'#' } else { b'.' };
//! let bytes: Vec<u8> = (0..20).flat_map(|y| (0..20).map(move |x| board(y, x))).collect();
//! let exemplar = Plane::of_bytes(Role::Color, [20, 20], 1, &bytes)?;
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let woven = graphcut(&exemplars, Domain::open([8, 44]), &Options::default(), &Run::seeded(0))?;
//! // The board goes on across every seam, so that seams cost nothing.
//! assert_eq!(woven.stats.energy.last(), Some(&0));
//! let out = woven.result.render(&[&exemplar])?.to_bytes()?;
//! assert!(out.chunks(44).all(|row| String::from_utf8_lossy(row).contains("####....####....####")));
//! # Ok(())
//! # }
//! ```
//!
//! # How it works
//! 1. While the output has holes, the error region is laid around the first one, so that it holds both filled and empty
//!    samples, and a patch is drawn from all translations of all sources that cover it ([`Placement`]). Then patches go
//!    over the regions whose seams cost most.
//! 2. A minimum cut decides where the patch shows. Old seams, and the two patches that each of them parts, are read off
//!    the map; the cut may cover them, keep them or replace them.
//! 3. The map is rendered bit for bit, or by `selvedge-blending` with its seams blended.
//!
//! Everything is written over the number of axes, one to three: clips are woven by the same code as pictures. Outputs
//! may be periodic on any axis. [`graphcut_from`] starts from what is there already, with fixed samples and a field of
//! sources.
//!
//! [`video`] makes clips loop, by a jump whose seam is a surface in space and time.
//! [`labels`] decides which of a few labels shows where: pictures that are merged, or one picture moved over itself.
//!
//! `DESIGN.md` in this crate tells how it works and why, and how time and memory grow.
//!
//! # Features
//! `rayon` (default): candidates are searched and cut on the caller's pool; the output is the same either way.
//!
//! # Papers
//! `[Kwatra03]`: V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick, *Graphcut Textures: Image and Video Synthesis Using
//! Graph Cuts*, SIGGRAPH 2003.
//!
//! `[Schodl00]`: A. Schödl, R. Szeliski, D. Salesin, I. Essa, *Video Textures*, SIGGRAPH 2000.
#![forbid(unsafe_code)]

mod candidates;
mod canvas;
mod checkpoint;
mod choice;
mod covered;
mod error;
mod error_cells;
mod estimate;
mod few;
mod gaps;
mod graphcut;
mod history;
pub mod labels;
mod levels;
mod matching;
mod options;
mod plan;
mod refine;
mod reflection;
mod regions;
mod scales;
mod settings;
mod sizes;
mod sliding;
mod squares;
mod stats;
mod stills;
mod usable;
pub mod video;
mod weaver;
mod words;
mod work;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use checkpoint::Checkpoint;
pub use covered::{Covered, cover};
pub use error::Error;
pub use estimate::{estimate, estimate_clip, measuring};
pub use graphcut::{graphcut, graphcut_from};
pub use options::{Options, Placement, Stutter};
pub use plan::{Plan, plan};
pub use scales::{Scales, WantedScale};
pub use selvedge_core::Start;
pub use settings::Settings;
pub use stats::Stats;
