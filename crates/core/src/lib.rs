//! What every method of Selvedge shares: domains, grids, exemplars, source maps, seeds and runs.
//!
//! A method looks at [`Exemplars`] (8-bit features in match space) and answers with a [`SourceMap`]: for each output
//! sample, *which* exemplar sample stands there. Pictures are rendered from the map afterwards, over planes of any
//! depth.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Plane, Render, Role, SampleId, SourceMap};
//! # fn main() -> Result<(), selvedge_core::Error> {
//! let plane = Plane::of_bytes(Role::Scalar, [1, 3], 1, &[10, 20, 30])?; // one row of three, one channel
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//!
//! let mut map = SourceMap::unassigned(&exemplars, Domain::open([1, 2]))?;
//! map.ids.plane_mut(0).copy_from_slice(&[SampleId::new(2), SampleId::new(0)]);
//! assert_eq!(map.render(&[&plane])?.to_bytes()?, [30, 10]);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! `rayon` (default): work is split over the caller's pool; the result is the same without it. `image`: planes from
//! buffers of the `image` crate, version 0.25 (`Plane::try_from(&picture)`), back (`DynamicImage::try_from(&plane)`,
//! then such as `into_rgb8()`), and masks from grey ones (`Grid::try_from(&picture)`).
//!
//! # Conventions
//! Axes are listed slowest first: `[height, width]`, `[frames, height, width]`. Grids are planar: channel by channel,
//! each channel in row-major order. Colours are compared as sRGB-encoded 8-bit values.
#![forbid(unsafe_code)]

mod averaging;
mod bytes;
mod came_from;
mod coherence;
mod crop;
mod domain;
mod encoder;
mod error;
mod error_kind;
mod exemplars;
mod extended;
mod few_places;
mod firsts;
mod flow;
mod grid;
mod guidance;
mod guide;
#[cfg(feature = "image")]
mod image_buffers;
mod light;
mod look;
mod memory;
mod normals;
pub mod par;
mod patch;
mod payload;
mod plane;
mod pyramid;
mod rebase;
mod render;
mod resample;
mod resampling;
mod run;
mod seam_costs;
mod seed;
mod source_map;
mod source_table;
mod start;
mod transform;
mod usage;
mod votes;
mod weights;
mod window;

pub use averaging::Averaging;
pub use bytes::Bytes;
pub use came_from::{CameFrom, Direction};
pub use coherence::Coherence;
pub use crop::ValidBoxes;
pub use domain::Domain;
pub use encoder::{Encoder, srgb_decode, srgb_encode};
pub use error::Error;
pub use error_kind::ErrorKind;
pub use exemplars::{Exemplar, Exemplars, Source};
pub use flow::Flow;
pub use grid::Grid;
pub use guidance::Guidance;
pub use guide::Guide;
#[cfg(feature = "image")]
pub use image_buffers::ImageSample;
pub use look::Look;
pub use memory::{collected, reserve, try_vec};
pub use normals::NormalCoding;
pub use patch::Patch;
pub use payload::Payload;
pub use plane::{Association, Depth, Plane, Role, Samples};
pub use render::Render;
pub use run::{Event, Limits, Observer, Run, Silent, SimdLevel, Within, Woven};
pub use seam_costs::{SeamCosts, SeamMeasure};
pub use seed::{Rng, Seed};
pub use source_map::SourceMap;
pub use source_table::{SampleId, SourceTable};
pub use start::Start;
pub use transform::{Origin, Transform};
pub use usage::Usage;
pub use votes::Votes;
pub use window::Window;
