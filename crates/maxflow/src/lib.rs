//! s-t minimum cuts on 2-D and 3-D grids and on graphs of any form: exact, in integers, deterministic, without
//! `unsafe`.
//!
//! A cut divides the nodes of a graph between a *source* and a *sink*; its capacity is the sum of the capacities of
//! the arcs from the source's side to the sink's. This crate finds the cut of least capacity, which equals the largest
//! flow from source to sink.
//!
//! # Usage
//!
//! Choose by what you have:
//!
//! - *A picture or a volume to segment* (or any labelling of its points by 0 and 1): [`BinaryEnergy`], with `unary` for
//!   what either label costs at a point and `pairwise` for what neighbours pay that differ; [`Minimum::labels`] is the
//!   mask. [`GraphEnergy`] does the same for regions with any neighbours.
//! - *A seam to find through a grid*: [`GridGraph`], below.
//! - *A network with arcs of any form*: [`Graph`], which tells the flow on each arc as well. [`dimacs::Problem`] reads
//!   other people's files.
//!
//! Then give capacities (`link` or `arc` between nodes, `terminal` with source and sink) and `pin` what must be on one
//! side. [`GridGraph::solve`] returns a [`MinCut`]. Change capacities or pins and solve again, from the flow that was
//! found, or `clear` and start over in the same memory.
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
//! | | |
//! |---|---|
//! | `GridGraph::new(shape, periodic)` | open or periodic, an axis; 1-D to 3-D; `with_diagonals` for 8 neighbours |
//! | `node(position)`, `position(node)` | nodes are row-major: a pixel's index is its node |
//! | `mask(node)` | not there; masks come first |
//! | `pin(node, side)`, `unpin(node)` | hard constraints; there are no "infinite" capacities |
//! | `terminal(node, from_source, to_sink)` | a second call adds; `terminals(&all)` in node order |
//! | `link(node, axis, forward, backward)` | to the next along `axis`, adds too; `links(axis, &all)` |
//! | `solve()` | `solve_until(closure)` may be stopped; `solve_into(&mut cut, ..)` allocates nothing anew |
//! | `cut.flow`, `cut.side(node)`, `cut.source_side()`, `cut.sink_side()` | the answer; `cut_links(&cut)` is the seam |
//! | `change_terminal`, `change_link` | after a solve; the next one starts from its flow |
//! | `clear()` | the next problem, in the same memory |
//!
//! `capacity(cost, scale)` turns a float cost into a capacity, rounding up, so that a metric stays one. Pairwise terms
//! that are not regular have their `e00` lowered and are counted, so an energy that falls in the model falls in truth.
//!
//! # Which cut
//!
//! There may be several minimum cuts. This crate always returns the one with the *smallest source side*, which is
//! unique: the same nodes from every [`Engine`], from a grid and from the same graph in lists, from a fresh solve and
//! from one that started at an earlier flow, on every machine.
//!
//! # Features
//!
//! `petgraph`: [`Graph`] from a graph of petgraph 0.8. Without it there are no dependencies but `thiserror`.
//!
//! # Current state
//!
//! One thread. Links join direct neighbours (2-D also diagonal ones), 1 to 3 axes. Capacities are `i32` on grids
//! and `i64` elsewhere; floating-point costs go through [`capacity`].
//!
//! # Examples
//!
//! - `cargo run --release -p selvedge-maxflow --example segment` cuts an object out of a picture, and mends the cut
//! - `cargo run --release -p selvedge-maxflow --example dimacs -- FILE.max` solves a DIMACS file
//! - `cargo run --release -p selvedge-maxflow --example growth` measures time and memory from 64^2 to 2048^2
//!
//! # How it works, and who found it
//!
//! `DESIGN.md` in this crate is a lesson that starts at augmenting paths, and tells how fast it is. The engines come
//! from Boykov and Kolmogorov (PAMI 2004), Hochbaum (Operations Research 2008) and Chandran and Hochbaum (2009), planar
//! duality from Ford and Fulkerson (1956), the pairwise construction from Kolmogorov and Zabih (PAMI 2004), solving
//! again from Kohli and Torr (PAMI 2007). `[Kwatra03]` is Kwatra et al., Graphcut Textures (SIGGRAPH 2003).
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
