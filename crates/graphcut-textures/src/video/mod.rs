//! Video textures: clips that go on without end, over seams that are surfaces in space and time. `[Kwatra03 7]`
//!
//! A loop is a *jump*: after one frame comes an earlier one. Where no two frames are alike enough, the jump is made at
//! another time at each pixel, along the surface of least price. So nothing is blended, and what is farther from the
//! jump than half a window stays as it is. `[Kwatra03 7A]`
//!
//! 1. [`FrameDistances`] tells how alike frames are, and [`best`](FrameDistances::best) which jumps promise most.
//! 2. [`looped`] cuts each of them and answers with the one whose seam is seen least ([`Closure`]): a [`Loop`], whose
//!    [`map`](Loop::map) renders any pass.
//! 3. [`walk`] plays several loops by turns, drawn by the seed: no period is seen.
//!
//! Where no jump will do, or another length or size is wanted, clips are woven as pictures are, by
//! [`graphcut_from`](crate::graphcut_from): of patches that are moved [in time alone](crate::Options::free), or along
//! all axes; [`woven_in_windows`] does so some frames at a time. They loop on a time axis without end, or between
//! [`Ends`] that are the same. `[Kwatra03 7B]` `[Kwatra03 7C]` `[Kwatra03 7D]` `[Kwatra03 7E]`
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Render, Role, Run, Samples};
//! use selvedge_graphcut_textures::video::{DistanceOptions, FrameDistances, JumpOptions, LoopOptions, looped};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // 20 frames of a wave that comes again after 8.
//! let wave = |t: u32, x: u32| if (t + x) % 8 < 4 { b'#' } else { b'.' };
//! let domain = Domain::open([20, 2, 16]);
//! let samples = domain.positions().map(|[t, _, x]| wave(t, x)).collect();
//! let clip = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples)?));
//!
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&clip)])?;
//! let run = Run::seeded(0);
//! let distances = FrameDistances::new(&exemplars, &DistanceOptions::default(), &run)?;
//! let jumps = distances.best(&JumpOptions::default(), &run)?;
//! let woven = looped(&exemplars, &jumps, &LoopOptions::default(), &run)?;
//! assert_eq!(woven.result.jump.period(), 8);
//! assert_eq!(woven.stats.tried[woven.stats.chosen].price, 0);
//! let out = woven.result.map()?.render(&[&clip])?;
//! assert_eq!(out.domain().shape, [8, 2, 16]);
//! # Ok(())
//! # }
//! ```

mod banded;
mod bounds;
mod distances;
mod ends;
mod footage;
mod jumps;
mod kept;
mod looping;
mod options;
mod play;
mod room;
mod sides;
mod spans;
mod steps;
mod still;
mod surface;
mod transition;
mod trials;
mod windows;

pub use distances::{DistanceOptions, FrameDistances};
pub use ends::Ends;
pub use footage::Footage;
pub use jumps::{Jump, JumpOptions};
pub use kept::WindowsCheckpoint;
pub use looping::{Loop, LoopStats, looped};
pub use options::LoopOptions;
pub use play::walk;
pub use room::estimate;
pub use steps::{CLOSES, Closure, Step, Usual, median, over_seams, step};
pub use still::{estimate_still, hold_still};
pub use surface::Surface;
pub use trials::Trial;
pub use windows::{estimate_in_windows, least_at_once, woven_in_windows, woven_in_windows_on};
