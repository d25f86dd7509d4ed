//! Image quilting and texture transfer: synthesis from overlapping square blocks of an exemplar (Efros and Freeman
//! 2001).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`quilt`], and render the map that it answers with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Plane, Render, Role, Run};
//! use selvedge_quilting::{Options, quilt};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of two samples.
//! let board = |y: u32, x: u32| if (y / 2 + x / 2) % 2 == 0 { b'#' } else { b'.' };
//! let bytes: Vec<u8> = (0..16).flat_map(|y| (0..16).map(move |x| board(y, x))).collect();
//! let exemplar = Plane::of_bytes(Role::Color, [16, 16], 1, &bytes)?;
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let options = Options { block: Some(5), overlap: Some(2), ..Options::default() };
//! let woven = quilt(&exemplars, Domain::open([4, 12]), &options, &Run::seeded(0))?;
//! let out = woven.result.render(&[&exemplar])?.to_bytes()?;
//! let rows: Vec<_> = out.chunks(12).map(String::from_utf8_lossy).collect();
//! // The board goes on across every block's edge.
//! assert!(rows.iter().all(|r| r.contains("##..##..##") || r.contains("..##..##..")), "{rows:#?}");
//! # Ok(())
//! # }
//! ```
//!
//! [`transfer`] draws a target in an exemplar's texture: a [`Guide`](selvedge_core::Guide) says what has to lie
//! where (`selvedge-guides` makes maps for it).
//!
//! A quilt takes time in proportion to the areas of output and exemplar; `DESIGN.md` has the figures, and tells why the
//! crate is made as it is.
//!
//! # Features
//! `rayon` (default): blocks and candidates are searched on the caller's pool; the output is the same either way.
//!
//! # Current state
//! Synthesis and transfer (sections 2 and 3 of the paper) in full, with periodic outputs, masks and several exemplars.
//! Every block of every source is searched by `selvedge-fft-ssd`: exactly, or from 384 samples a side on from above
//! ([`SearchBy`]), unless asked otherwise.
//!
//! # Papers
//! `[Efros01]`: A. A. Efros, W. T. Freeman, *Image Quilting for Texture Synthesis and Transfer*, SIGGRAPH 2001.
#![forbid(unsafe_code)]

mod auto_block;
mod block_grid;
pub mod boundary_cut;
mod cloth;
mod estimate;
mod finding;
mod fit;
mod free;
mod options;
mod pass;
mod quilt;
mod quilter;
pub mod search;
mod steering;
mod strip;
mod transfer;
mod transfer_options;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use auto_block::suggest_block;
pub use estimate::measuring;
pub use options::{Continuation, Error, Options, SearchBy, Stage};
pub use quilt::{Plan, Stats, quilt};
pub use transfer::{PassStats, TransferPlan, TransferStats, transfer};
pub use transfer_options::{TransferOptions, suggest_transfer_block};
