//! Source maps rendered with their seams hidden: patches are blended across what no cut avoids. `[Kwatra03 5]`
//!
//! # Usage
//! Take a map from any method, say by source which samples may show, choose a renderer, and lay it over planes of any
//! depth. [`Feathered`] mixes what meets near a seam; [`Splined`] does so for each band of detail over a width of its
//! own; [`Fused`] raises and lowers patches until they meet, which is what heights want.
//!
//! ```
//! use selvedge_blending::Feathered;
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Render, Role, Samples, SourceMap};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two shades side by side.
//! let domain = Domain::open([1, 8]);
//! let grey = Grid::from_vec(domain, 1, vec![0_u8, 0, 0, 0, 90, 90, 90, 90])?;
//! let plane = Plane::new(Role::Scalar, Samples::U8(grey));
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//!
//! // The dark half, and the bright half laid to its left: a seam in the middle.
//! let mut map = SourceMap::unassigned(&exemplars, domain)?;
//! for x in 0..8 {
//!     map.ids.set(0, [0, x], exemplars.table().id(0, [0, (x + 4) % 8]));
//! }
//! let feathered = Feathered::new(&map, exemplars.validity(), 0.5)?;
//! let Samples::U8(out) = feathered.render(&[&plane])?.samples else { unreachable!() };
//! assert_eq!(out.plane(0)[..3], [90, 90, 90], "what no seam is near is copied");
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! `rayon` (default): boxes are blended on the caller's pool; the result is the same without it, and on any number of
//! threads.
//!
//! # Papers
//! `[Kwatra03]`: V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick, *Graphcut Textures: Image and Video Synthesis Using
//! Graph Cuts*, SIGGRAPH 2003. DESIGN.md tells how it works and why.
#![forbid(unsafe_code)]

mod bands;
mod boxes;
mod conjugate;
mod error;
mod feather;
mod fourier;
mod fused;
mod map_view;
mod near;
mod pieces;
mod poisson;
mod region;
mod spline;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use error::Error;
pub use feather::Feathered;
pub use fused::Fused;
pub use spline::Splined;
