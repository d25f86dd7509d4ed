//! Graphcut textures.
#![forbid(unsafe_code)]

mod blend;
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
mod period;
mod region;
mod window;

pub use blend::{Feathered, Splined};
pub use error::Error;
pub(crate) use graphcut::check_map;
pub use graphcut::{Start, Stats, estimate, graphcut, graphcut_from};
pub use options::{Options, Placement};
pub use period::periodicity;
