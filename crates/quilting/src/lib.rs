//! Image quilting and texture transfer: synthesis from overlapping square blocks of an exemplar (Efros and Freeman 2001).
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
//! [`transfer`] draws a target in an exemplar's texture: a [`Guide`](selvedge_core::Guide) says what has to lie
//! where (`selvedge-guides` makes maps for it).
//!
//! # Growth
//! Processor time of the whole program on one thread of a server with AVX-512 VNNI, in ms (`perf stat -e task-clock` of
//! `selvedge quilt` and `transfer` with `-j 1`, medians of three), cobbles of 192 by 192 samples unless said.
//!
//! | grows with | of | | | |
//! |---|---|---|---|---|
//! | the output's area | quilts of 512^2, 1024^2, 2048^2 by 36 | 75 | 278 | 1121 |
//! | blocks, slowly | quilts of 1024^2 by 24, 48, 72 | 364 | 246 | 176 |
//! | the exemplar's area | quilts of 1024^2 from 96^2, 192^2, 384^2 | 122 | 278 | 1035 |
//! | the target's area | transfers onto 128^2, 256^2, 512^2 by 28 | 239 | 961 | 3872 |
//! | the exemplar's area | transfers onto 256^2 from 96^2, 192^2, 384^2 | 298 | 979 | 3961 |
//! | the last pass's blocks | transfers onto 256^2 by 20, 28, 36 | 2550 | 971 | 715 |
//!
//! Two threads take 48 ms instead of 70 for 512^2, 157 instead of 260 for 1024^2, 571 instead of 1000 for 2048^2, and 2.34 s
//! instead of 4.07 for 4096^2 (from radishes of 192^2 by 48, wall clock of the whole program): 1.5 to 1.75 times as fast. What is left
//! is the program's start, the file's way to the disk, and the ends of waves, where a thread waits for the other.
//!
//! A quilt searches `output / step^2` overlaps of about `2 * block * overlap` samples, a third of each block's area with
//! the overlap of a sixth: smaller blocks are more searches, each of less work, but of the same number of places. In a
//! transfer five passes shrink blocks to a fifth, and the last ones are by far the most: a first block of 20 ends with
//! blocks of 4 that step by 2, one of 36 with 7 that step by 5.
//!
//! # Features
//! `rayon` (default): blocks and candidates are searched on the caller's pool; the output is the same either way.
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

pub use auto_block::suggest_block;
pub use estimate::{estimate, estimate_transfer};
pub use options::{Continuation, Error, Options, Stage};
pub use quilt::{Plan, Stats, quilt};
pub use transfer::{PassStats, TransferPlan, TransferStats, transfer};
pub use transfer_options::{TransferOptions, suggest_transfer_block};
