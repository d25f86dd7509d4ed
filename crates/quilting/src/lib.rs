//! Image quilting: synthesis from overlapping square blocks of an exemplar (Efros and Freeman 2001).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`quilt`], and render the map that it answers with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Render, Role, Run, Samples};
//! use selvedge_quilting::{Options, quilt};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of two samples.
//! let board = |y: u32, x: u32| if (y / 2 + x / 2) % 2 == 0 { b'#' } else { b'.' };
//! let domain = Domain::open([16, 16]);
//! let samples = domain.positions().map(|[y, x]| board(y, x)).collect();
//! let exemplar = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples)?));
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let options = Options { block: Some(5), overlap: Some(2), ..Options::default() };
//! let woven = quilt(&exemplars, Domain::open([4, 12]), &options, &Run::seeded(0))?;
//! let Samples::U8(out) = woven.result.render(&[&exemplar])?.samples else { unreachable!() };
//! let rows: Vec<_> = out.plane(0).chunks(12).map(String::from_utf8_lossy).collect();
//! // The board goes on across every block's edge.
//! assert!(rows.iter().all(|r| r.contains("##..##..##") || r.contains("..##..##..")), "{rows:#?}");
//! # Ok(())
//! # }
//! ```
//!
//! [`transfer`] draws a target in an exemplar's texture: a [`Guide`](selvedge_core::Guide), made of maps from [`correspondence`],
//! says what has to lie where.
//!
//! # Features
//! `rayon` (default): candidates are searched on the caller's pool; the output is the same either way.
//!
//! # Current state
//! Synthesis and transfer (sections 2 and 3 of the paper) in full, with periodic outputs, masks and several exemplars.
//! Every block of every source is searched, exactly, by `selvedge-fft-ssd`.
//!
//! # Papers
//! `[Efros01]`: A. A. Efros, W. T. Freeman, *Image Quilting for Texture Synthesis and Transfer*, SIGGRAPH 2001.
#![forbid(unsafe_code)]

mod auto_block;
mod block_grid;
mod boundary_cut;
pub mod correspondence;
mod estimate;
mod options;
mod quilt;
mod quilter;
mod search;
mod strip;
mod transfer;
mod usage;

pub use auto_block::suggest_block;
pub use estimate::{estimate, estimate_transfer};
pub use options::{Continuation, Error, Options, Stage};
pub use quilt::{Stats, quilt};
pub use transfer::{PassStats, TransferOptions, TransferStats, suggest_transfer_block, transfer};
