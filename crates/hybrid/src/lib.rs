//! Hybrid texture synthesis: large blocks where they fit, small ones where they must, single samples where nothing fits
//! (Ding et al.; Nealen and Alexa 2003).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`hybrid()`], and render the map that it answers
//! with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Plane, Render, Role, Run};
//! use selvedge_hybrid::{Options, hybrid};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of two samples.
//! let board = |y: u32, x: u32| if (y / 2 + x / 2) % 2 == 0 { b'#' } else { b'.' };
//! let bytes: Vec<u8> = (0..16).flat_map(|y| (0..16).map(move |x| board(y, x))).collect();
//! let exemplar = Plane::of_bytes(Role::Color, [16, 16], 1, &bytes)?;
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let options = Options { block: Some([4, 4]), ..Options::default() };
//! let woven = hybrid(&exemplars, Domain::open([4, 12]), &options, &Run::seeded(0))?;
//! let out = woven.result.render(&[&exemplar])?.to_bytes()?;
//! let rows: Vec<_> = out.chunks(12).map(String::from_utf8_lossy).collect();
//! // The board goes on across every block's edge.
//! assert!(rows.iter().all(|r| r.contains("##..##..##") || r.contains("..##..##..")), "{rows:#?}");
//! # Ok(())
//! # }
//! ```
//!
//! `DESIGN.md` in this crate tells how it works and why.
//!
//! # Features
//! `rayon` (default): candidates are searched on the caller's pool; the output is the same either way.
//!
//! # Papers
//! `[Ding]`: X. Ding, S. Ganesan, J. Chen, *An Adaptive Texture Synthesis Algorithm*. HTS: A. Nealen, M. Alexa, *Hybrid
//! Texture Synthesis*, EGSR 2003.
#![forbid(unsafe_code)]

mod canvas;
mod changes;
mod composite;
mod dilation;
mod error;
mod estimate;
mod features;
mod followed;
mod ground;
mod hybrid;
mod layout;
mod neighborhood;
mod options;
mod pixel;
mod plan;
mod repair;
mod site;
mod stats;
mod thresholds;
mod usable;
mod weave;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use error::Error;
pub use estimate::{estimate_repair, measuring};
pub use hybrid::{hybrid, hybrid_from};
pub use options::{Layout, Options, PixelSearch, Resynthesize, Split, Threshold};
pub use plan::Plan;
pub use repair::{RepairOptions, RepairStats, repair};
pub use stats::{Level, Stats};
pub use thresholds::weighed;
