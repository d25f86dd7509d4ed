//! Graphcut textures: synthesis from patches of any shape, cut along the best seams (Kwatra et al. 2003).
//!
//! # Usage
//! Encode one or more exemplars, choose the output's domain, call [`graphcut`], and render the map that it answers with.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Render, Role, Run, Samples};
//! use selvedge_graphcut_textures::{Options, graphcut};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A checkerboard with squares of four samples.
//! let board = |y: u32, x: u32| if (y / 4 + x / 4) % 2 == 0 { b'#' } else { b'.' };
//! let domain = Domain::open([20, 20]);
//! let samples = domain.positions().map(|[y, x]| board(y, x)).collect();
//! let exemplar = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples)?));
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&exemplar)])?;
//! let woven = graphcut(&exemplars, Domain::open([8, 44]), &Options::default(), &Run::seeded(0))?;
//! // The board goes on across every seam, so that seams cost nothing.
//! assert_eq!(woven.stats.energy.last(), Some(&0));
//! let Samples::U8(out) = woven.result.render(&[&exemplar])?.samples else { unreachable!() };
//! assert!(out.plane(0).chunks(44).all(|row| String::from_utf8_lossy(row).contains("####....####....####")));
//! # Ok(())
//! # }
//! ```
//!
//! # How it works
//! 1. While the output has holes, the error region is laid around the first one, so that it holds both filled and empty
//!    samples, and a patch is drawn from all translations of all sources that cover it ([`Placement`]). Then patches go
//!    over the regions whose seams cost most.
//! 2. A minimum cut decides where the patch shows. Old seams, and the two patches that each of them parts, are read off
//!    the map; the cut may cover them, keep them or replace them.
//! 3. The map is rendered bit for bit, or by `selvedge-blending` with its seams blended.
//!
//! Everything is written over the number of axes: clips are woven by the same code as pictures. Outputs may be periodic
//! on any axis. [`graphcut_from`] starts from what is there already, with fixed samples and a field of sources.
//!
//! # Speed and growth
//! Processor time of `selvedge graphcut --refine 10 -j 1` on an exemplar of 192^2 (radishes, sub-patch placement, regions
//! of 35 samples), with reading and writing of the files, and the largest memory of the process:
//!
//! | output | seconds | MiB |
//! |---|---|---|
//! | 512^2 | 0.41 | 18 |
//! | 1024^2 | 1.6 | 21 |
//! | 2048^2 | 6.2 | 51 |
//! | 4096^2 | 25 | 153 |
//!
//! Time grows with the output's area: a cut sees a window of the output, never all of it, and the worst region is kept
//! up to date in a tree. By default refinement goes on until seams settle, which takes four to five times as long. Cuts take
//! about half of the time, searches a fifth.
//!
//! Every source is searched for every patch, so that time grows with the samples of all of them: turned by 15 angles as
//! well, 512^2 took 2.9 s instead of 0.41 with sub-patch placement, and 6.5 s instead of 0.50 with entire-patch placement.
//! Where [`Start`] says which sources may show, only those that may show in a region are searched for it: a field of scales
//! from 0.4 to 1.6 took 0.84 s for 512^2, against 2.0 with all of them searched. Blending takes the same for any number of
//! sources.
//!
//! Sizes of regions and reach were chosen by measure on ten textures at 1024^2: with them no texture repeats itself more
//! than image quilting does, and seams cost less than quilting's on nine (eq. 1, relative to random joins). Structured
//! textures such as text and keyboards come out cleaner with a reach of the whole exemplar (`Options::paper`), at the
//! price of whole words and keys that come again in sight of each other.
//!
//! # Features
//! `rayon` (default): candidates are searched and cut on the caller's pool; the output is the same either way.
//!
//! # Papers
//! `[Kwatra03]`: V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick, *Graphcut Textures: Image and Video Synthesis Using
//! Graph Cuts*, SIGGRAPH 2003.
#![forbid(unsafe_code)]

mod candidates;
mod canvas;
mod choice;
mod error;
mod error_cells;
mod estimate;
mod graphcut;
mod history;
mod matching;
mod options;
mod plan;
mod refine;
mod reflection;
mod start;
mod stats;
mod usable;
mod weaver;

pub use error::Error;
pub use estimate::estimate;
pub use graphcut::{graphcut, graphcut_from, plan};
pub use options::{Options, Placement};
pub use plan::Plan;
pub use start::Start;
pub use stats::Stats;
