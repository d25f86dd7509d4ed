//! s-t minimum cuts on 2-D and 3-D grids and general sparse graphs, in integers, without `unsafe`.
//!
//! A cut divides the nodes of a graph between a *source* and a *sink*; its capacity is the sum of the capacities of
//! the arcs from the source's side to the sink's. This crate finds the cut of least capacity, which equals the largest
//! flow from source to sink.
//!
//! # Usage
//!
//! 1. Make a [`GridGraph`] (pixels, voxels) or a [`Graph`] (anything). 2. Give it capacities: `link` or `arc` between
//!    nodes, `terminal` with source and sink; `pin` what must be on one side. 3. [`GridGraph::solve`] returns a
//!    [`MinCut`]. 4. Change capacities or pins and solve again, or `clear` and start over in the same memory.
//!
//! ```
//! use selvedge_maxflow::{GridGraph, Side};
//!
//! // Where should a seam run from the top to the bottom of this strip? A link across costs what its digits say.
//! let costs = [[9, 1, 8, 9], [9, 2, 7, 9], [8, 9, 1, 9], [9, 8, 2, 9]];
//! let mut graph = GridGraph::new([4, 5], [false, false])?;
//! for (row, costs) in costs.iter().enumerate() {
//!     graph.pin(graph.node([row, 0]), Side::Source)?;
//!     graph.pin(graph.node([row, 4]), Side::Sink)?;
//!     for (column, &cost) in costs.iter().enumerate() {
//!         graph.link(graph.node([row, column]), 1, cost, cost)?;
//!     }
//!     for column in 0..if row < 3 { 5 } else { 0 } {
//!         graph.link(graph.node([row, column]), 0, 3, 3)?;
//!     }
//! }
//! let cut = graph.solve()?;
//! assert_eq!(cut.flow, 1 + 2 + 3 + 1 + 2);
//! let picture: Vec<String> = cut.source_side().chunks(5)
//!     .map(|row| row.iter().map(|&source| if source { '#' } else { '.' }).collect())
//!     .collect();
//! assert_eq!(picture, ["##...",
//!                      "##...",
//!                      "###..",
//!                      "###.."]);
//! # Ok::<(), selvedge_maxflow::MaxflowError>(())
//! ```
//!
//! # Which cut
//!
//! There may be several minimum cuts. This crate always returns the one with the *smallest source side*, which is
//! unique: the same nodes from every [`Engine`], from a grid and from the same graph in lists, from a fresh solve and
//! from one that started at an earlier flow, on every machine.
//!
//! # Features
//!
//! `petgraph`: [`Graph`] from a petgraph graph.
//!
//! # Current state
//!
//! One thread. Links join direct neighbours (2-D also diagonal ones), 1 to 3 axes. Capacities are `i32` on grids
//! and `i64` elsewhere; floating-point costs go through [`capacity`].
//!
//! # How it works, and who found it
//!
//! `DESIGN.md` in this crate is a lesson that starts at augmenting paths. The engines come from Boykov and Kolmogorov
//! (PAMI 2004), Hochbaum (Operations Research 2008) and Chandran and Hochbaum (2009), planar duality from Ford and
//! Fulkerson (1956), the pairwise construction from Kolmogorov and Zabih (PAMI 2004), solving again from Kohli and Torr
//! (PAMI 2007). `[Kwatra03]` is Kwatra et al., Graphcut Textures (SIGGRAPH 2003).
#![forbid(unsafe_code)]

mod cut;
pub mod dimacs;
mod energy;
mod engine;
mod error;
mod forms;
mod grid;
mod lattice;
mod network;
#[cfg(feature = "petgraph")]
mod petgraph;
mod quantize;
mod sparse;

pub use cut::{MinCut, Side};
pub use energy::{BinaryEnergy, GraphEnergy, Minimum, PairwiseTerm};
pub use engine::Engine;
pub use error::{ErrorKind, MaxflowError, Result};
pub use grid::{Diagonal, GridGraph};
pub use quantize::capacity;
pub use sparse::{ArcId, Graph};
