//! Graphcut textures.
#![forbid(unsafe_code)]

mod candidates;
mod canvas;
mod cut;
mod error;
mod error_cells;
mod frame;
mod graphcut;
mod history;
mod matching;
mod options;
mod patch;
mod region;
mod window;

pub use error::Error;
pub use graphcut::{Start, Stats, graphcut, graphcut_from};
pub use options::{Options, Placement};
