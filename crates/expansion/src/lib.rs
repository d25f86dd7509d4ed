//! One expansion move over a source map: what stands, what is offered, and the cut of least price between them.
//!
//! Graph cuts that paste a patch, alpha-expansion over labels, the merging of two pictures and a transition between
//! clips are one step, taken again and again: some samples of a window are offered another exemplar sample, and a
//! minimum cut decides which of them take it. This crate is that step, over pictures and clips, open and periodic.
//!
//! # Usage
//! 1. A [`Frame`] holds what stands in a window of a map, and what is offered there: mostly a
//!    [`Patch`](selvedge_core::Patch).
//! 2. [`Frame::choices`] says which samples have a choice; the user may pin some ([`Pin`]).
//! 3. [`expand`] asks [`Prices`] what neighbours and samples cost, and answers with a [`Proposal`].
//! 4. [`Proposal::lay`] takes it, if the caller likes the [`gain`](Proposal::gain).
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Patch, Plane, Render, Role, Samples};
//! use selvedge_core::{SeamCosts, SeamMeasure, SourceMap, Window};
//! use selvedge_expansion::{Frame, Holes, Scratch, expand};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two rows with a period of four.
//! let row = b"#..+#..+#..+";
//! let grid = Grid::from_vec(Domain::open([2, 12]), 1, [*row, *row].concat())?;
//! let plane = Plane::new(Role::Scalar, Samples::U8(grid));
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//! let prices = SeamCosts::new(&exemplars, SeamMeasure::Difference)?;
//!
//! let output = Domain::open([2, 16]);
//! let mut map = SourceMap::unassigned(&exemplars, output)?;
//! let mut scratch = Scratch::default();
//! // The first patch fills, the second goes on from it four samples further, where the pattern repeats itself.
//! for offset in [[0, 0], [0, 4]] {
//!     let patch = Patch { source: 0, offset };
//!     let all = Window::all(output);
//!     let Some(window) = patch.footprint(&exemplars, &all).shared(&all) else { continue };
//!     let frame = Frame::of_patch(&exemplars, &map, &patch, &window)?;
//!     let choices = frame.choices(Holes::Fill, |_| None)?;
//!     let proposal = expand(&frame, &choices, &prices, &mut scratch, &|| false)?;
//!     proposal.lay(&frame, &mut map);
//! }
//! assert_eq!((map.holes(), prices.total(&map)), (0, 0));
//! let Samples::U8(out) = map.render(&[&plane])?.samples else { unreachable!() };
//! assert_eq!(out.plane(0)[..16], *b"#..+#..+#..+#..+");
//! # Ok(())
//! # }
//! ```
//!
//! # What a move promises
//! The model is an energy of one binary label a sample: keep, or take. Between `s` and `t` the pairwise term is the
//! price of the neighbours that each of the four decisions would leave, so that seams which are there already need no
//! nodes of their own `[Kwatra03 3.1]`:
//!
//! | | `t` keeps | `t` takes |
//! |---|---|---|
//! | **`s` keeps** | `old_s old_t`: the old seam, `c3` | `old_s new_t`: `c1` |
//! | **`s` takes** | `new_s old_t`: `c2` | `new_s new_t`: 0 within one patch |
//!
//! A graph can hold the term only if `c3 <= c1 + c2`. That is so for every metric (eq. 1); then the cut is the best of
//! all decisions, and equals the paper's with its seam nodes. For other prices (eq. 5) the model takes
//! `min(c3, c1 + c2)` for keeping both, *and nothing else is changed*. So for any decision `x` the model's price is at
//! most the true one, with equality wherever no such pair keeps both, and the price of keeping all is lowered at least
//! as much as that of any `x`:
//!
//! ```text
//! true(keep all) - true(x)  >=  model(keep all) - model(x)  >=  0 for the cut x
//! ```
//!
//! A gain in the model is at least that gain in truth: prices never rise. (The literal seam node of eq. 5 would lower
//! the mixed terms too, to `min(c1, c2 + c3)`, and would pay for moves that make the picture worse.) [`Proposal`] tells
//! true prices, and how many terms were lowered.
//!
//! # Pruning
//! Where samples have prices of their own, most of them keep what they have, and can be seen to: taking the offer costs
//! more than all neighbours together could save by it. Such a sample is decided before the cut, then its neighbours can
//! save less, and so on outward. That is exact where no term is lowered: the same samples take the offer. Where terms
//! are, a sample that is decided has none, so that fewer are lowered; prices never rise either way. Alpha-expansions of
//! labels that fit nowhere cost next to nothing by it.
//!
//! # Near seams alone
//! A map that was solved at half the size, where all is a fourth of the work, and carried up
//! ([`SourceMap::finer`](selvedge_core::SourceMap::finer)) has its seams to within two samples, and its patches to
//! within one. [`shift`] moves whole patches by a sample where seams become cheaper, and [`settle`] offers the patches
//! of each tile to the band around its seams ([`Frame::band`]) `[Lombaert05]`. Both work on any map, and never make it
//! dearer.
//!
//! # Determinism
//! Prices are integers. Of several cuts of least price that in which most samples take the offer is made, on any
//! machine.
//!
//! # Features
//! `rayon` (default): passed on to `selvedge-core`. A move itself runs on one thread; callers cut many windows at once.
//!
//! # Papers
//! `[Kwatra03]`: V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick, *Graphcut Textures: Image and Video Synthesis Using
//! Graph Cuts*, SIGGRAPH 2003. `[Lombaert05]`: H. Lombaert, Y. Sun, L. Grady, C. Xu, *A Multilevel Banded Graph Cuts
//! Method for Fast Image Segmentation*, ICCV 2005.
#![forbid(unsafe_code)]

mod band;
mod choice;
mod error;
mod estimate;
mod expand;
mod frame;
mod prices;
mod prune;
mod settle;
mod shift;
mod span;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use choice::{Choice, Holes, Pin};
pub use error::Error;
pub use estimate::estimate;
pub use expand::{Proposal, Scratch, expand};
pub use frame::Frame;
pub use prices::{Prices, Quad};
pub use settle::{Pins, estimate_settled, settle};
pub use shift::shift;
