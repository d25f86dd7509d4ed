//! Constrained texture synthesis by energy minimisation: a picture that looks like one and follows another.
//!
//! Given exemplars `S`, for each of them a picture `Q` of the same size, and a picture `C` of the output's size, the
//! output `O` is to `C` what `S` is to `Q`: `Q : S :: C : O`, image analogies by graph cuts. `[CMS III]`
//! - *texture by numbers*: `Q` and `C` are maps of labels;
//! - *detail synthesis*: `Q` is `S` at low resolution, `C` a low-resolution picture ([`low_resolution`]);
//! - *artistic filters*: `Q` and `S` are a picture before and after;
//! - *texture transfer*: `Q` is the luminance of `S`.
//!
//! ```
//! use selvedge_cms_analogies::{Constraint, Options, analogy};
//! use selvedge_core::{Domain, Exemplars, Grid, Guide, Plane, Render, Role, Run, Samples};
//! # fn main() -> Result<(), selvedge_cms_analogies::Error> {
//! // Dots where the label is 0, stripes where it is 255.
//! let of = |domain: Domain<2>, f: &dyn Fn([u32; 2]) -> u8| {
//!     Grid::from_vec(domain, 1, domain.positions().map(f).collect())
//! };
//! let source = Domain::open([16, 32]);
//! let dots = |y: u32, x: u32| [b'.', b' '][(x + y) as usize % 2];
//! let picture = of(source, &|[y, x]| if x < 16 { dots(y, x) } else { [b'|', b' '][x as usize % 2] })?;
//! let labels = of(source, &|[_, x]| if x < 16 { 0 } else { 255 })?;
//! let plane = Plane::new(Role::Scalar, Samples::U8(picture));
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//! // The output has stripes above and dots below.
//! let target = of(Domain::open([20, 20]), &|[y, _]| if y < 10 { 255 } else { 0 })?;
//!
//! let constraints = [Constraint::new(Guide::new(&exemplars, &[labels], target)?)];
//! let options = Options { constraint_weight: 5.0, neighborhood: 0, tolerance: Some(0.0), ..Options::default() };
//! let woven = analogy(&exemplars, &constraints, &options, &Run::seeded(0))?;
//! let Samples::U8(out) = woven.result.render(&[&plane])?.samples else { unreachable!() };
//! assert!(out.plane(0)[..100].contains(&b'|') && !out.plane(0)[..100].contains(&b'.'));
//! assert!(out.plane(0)[300..].contains(&b'.') && !out.plane(0)[300..].contains(&b'|'));
//! # Ok(())
//! # }
//! ```
//!
//! # What `K` and `N` do
//! The energy has two parts: `K` times the squared difference between `Q` and `C` over a neighborhood, and the price of
//! seams in `O`. A large [`constraint_weight`](Options::constraint_weight) follows the constraint, a small one keeps
//! the texture whole. A large [`neighborhood`](Options::neighborhood) takes structures as they are, a small one follows
//! curves. The paper's choices, `K / N`: detail 7 / 7 (curved 7 / 3), filters 20 / 5, transfer 0.2 / 5 to 0.4 / 4,
//! texture by numbers 0.5 / 9, 10 / 2 and 0.6 / 1. `[CMS V-H]`
//!
//! # Coarse to fine
//! With [`levels`](Options::levels) the output is solved at a fraction of the size first. Of brick, grass and sky by
//! numbers (256 x 256 samples, `K` 2, `N` 4) the energy ends at .88e9 with three levels and 1.00e9 with one, in .9 and
//! 6.5 s of processor time. With a [`spread`](Options::spread) no part of an exemplar shows over and over.
//!
//! # Low resolution
//! Taps of a constraint that is `r` times coarser lie `r` samples apart, so that `N` counts its samples. Reaching as
//! far as the paper's 15 samples is enough: of chickpeas, bricks and dirt enlarged four- and eightfold, each from
//! another part of its picture, the reduction is nearer to what was given with `N` 1 than with 3 by 1.2 to 2.4 dB, in
//! half the time. [`match_low`] adds what is lacking still. How the picture was reduced is a [`Kernel`]; where that is
//! another one than it was, `Q` is blurrier or sharper than `C` and nothing agrees well.
//!
//! # Sequences
//! [`carried`] moves a frame's labelling by a flow, for the next frame to go on from, and [`as_shown`] makes what it
//! shows one more constraint.
//!
//! # Determinism
//! Prices are integers; the search runs on many threads, what is accepted is decided on one, in order.
//!
//! # Features
//! `rayon` (default): labels are searched on the caller's pool; the result is the same without it.
//!
//! # Papers
//! `[CMS]`: G. Ramanarayanan, K. Bala, *Constrained Texture Synthesis via Energy Minimization*, IEEE TVCG 13(1), 2007.
#![forbid(unsafe_code)]

mod agreement;
mod boxes;
mod constraint;
#[cfg(test)]
mod edge_tests;
mod error;
mod estimate;
mod expansion;
mod fitness;
mod kernel;
mod labelling;
#[cfg(test)]
mod level_tests;
mod levels;
mod low;
mod options;
mod pieces;
mod plan;
mod ranking;
mod sequence;
mod stats;
mod synthesis;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod turned_tests;
mod uses;
mod worst;

use selvedge_core::{Exemplars, Run, SourceMap, Start, Woven};

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use constraint::Constraint;
pub use error::Error;
pub use estimate::{Sizes, estimate};
pub use fitness::{Fitness, fitness, fitness_from};
pub use kernel::Kernel;
pub use low::{low_resolution, match_low};
pub use options::Options;
pub use plan::Plan;
pub use sequence::{as_shown, carried};
pub use stats::{Energy, Stats};

/// An output that follows constraints; it has the size of what they lie over.
///
/// # Errors
/// Those of [`Plan::new`] and [`Plan::weave`].
pub fn analogy(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    Plan::new(exemplars, constraints, options, run)?.weave(run)
}

/// The same, going on from what is there.
///
/// # Errors
/// Those of [`Plan::new`] and [`Plan::weave_from`].
pub fn analogy_from(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    start: &Start<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    Plan::new(exemplars, constraints, options, run)?.weave_from(start, run)
}
