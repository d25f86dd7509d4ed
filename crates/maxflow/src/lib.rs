//! s-t minimum cuts on 2-D and 3-D grids and general sparse graphs, in integers.
#![forbid(unsafe_code)]

mod cut;
pub mod dimacs;
mod energy;
mod engine;
mod error;
mod grid;
mod lattice;
mod network;
#[cfg(feature = "petgraph")]
mod petgraph;
mod quantize;
mod sparse;

pub use cut::{MinCut, Side};
pub use energy::{BinaryEnergy, Minimum, PairwiseTerm};
pub use engine::Engine;
pub use error::{ErrorKind, MaxflowError, Result};
pub use grid::{Diagonal, GridGraph};
pub use quantize::capacity;
pub use sparse::{ArcId, Graph};
