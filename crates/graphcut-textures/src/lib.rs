//! Graphcut textures.
#![forbid(unsafe_code)]

mod blend;
mod candidates;
mod canvas;
mod cut;
mod error;
mod error_cells;
mod estimate;
mod frame;
mod graphcut;
mod history;
mod matching;
mod options;
mod patch;
mod period;
mod region;
mod start;
mod window;

pub use blend::{Feathered, Splined};
pub use error::Error;
pub use estimate::estimate;
pub use graphcut::{Stats, graphcut, graphcut_from};
pub use options::{Options, Placement};
pub use period::periodicity;
pub use start::Start;
pub(crate) use start::check_map;
