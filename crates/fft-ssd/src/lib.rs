//! Where does a (masked) piece of output fit the exemplars best? Exact sums of squared differences at every position,
//! in pictures and clips.
//!
//! 1. [`SsdSearcher::new`] prepares the exemplars once.
//! 2. [`search`](SsdSearcher::search) compares a [`Template`] at every position of a [`Placement`]; the answer is a
//!    [`Costs`], one integer a position. [`Scratch`] and [`Costs`] are the caller's and are used again.
//! 3. [`best`](Costs::best), [`best_k`](Costs::best_k) and [`within`](Costs::within) choose, each with a variant that
//!    excludes positions; [`sum_of`](Costs::sum_of) sums the costs of several searches, and [`search_sum`] searches and
//!    sums in one go.
//! 4. [`compare`](SsdSearcher::compare) tells the error at single places, as far as it matters.
//!
//! ```
//! use selvedge_core::{Exemplars, Plane, Role};
//! use selvedge_fft_ssd::{Costs, Placement, Scratch, SsdSearcher, Template};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let plane = Plane::of_bytes(Role::Scalar, [2, 4], 1, &[1, 2, 3, 4, 5, 6, 7, 8])?;
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//!
//! let searcher = SsdSearcher::new(&exemplars)?;
//! let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
//! // Two samples side by side, of which only the right one counts.
//! let template = Template::new([1, 2], &[99, 7]).masked(&[false, true]);
//! searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs)?;
//!
//! let best = costs.best().expect("the template fits");
//! assert_eq!((best.position, best.error), ([1, 1], 0));
//! // 6, 7 and 8 are at most 1 away: 0 and twice 1^2.
//! let near = costs.within(selvedge_fft_ssd::Tolerance { per_mille: 0, floor: 1 })?;
//! assert_eq!(near.len(), 3);
//! # Ok(())
//! # }
//! ```
//!
//! Where *every* window of a picture is asked for, [`nearest`] answers by displacement, which shares the work of
//! windows that overlap; [`alike`] counts the windows of a picture that stand in it again.
//!
//! # Direction of the offset
//! At position `p`, sample `x` of the template is compared with source sample `x + p`. If the template was cut from the
//! output at `o`, copying the source there is a translation by the offset `o - p` (output position = exemplar position
//! plus offset, the `t` of `[Kwatra03 eq. 4]`).
//!
//! # Units of the cost
//! Errors are `sum of W_c * (template - source)^2` over compared samples and channels: exact integers in squared 8-bit
//! steps times the exemplars' weights, in 32 bits where no error of the search can pass them, else in 64. They are not
//! divided by anything; [`Candidate::samples`] says by what a mean would be. Other depths are quantised to 8 bits by
//! the encoder before they come here, so for them the costs are exact only for what was quantised.
//!
//! # Validity of the border
//! [`Positions`] says whether the template must lie inside, may wrap around or may stick out; [`Cover`] says how much
//! of it must stand on valid samples. What is left out never counts as 0: it is not compared.
//!
//! # Engines
//! - *Direct* multiplies sample by sample: vector lanes are positions, four rows of them at once (`vpdpbusd` on four
//!   bytes with AVX-512 or AVX VNNI, `vpmaddwd` on pairs with AVX2, plain loops elsewhere). Weights above 1 take two
//!   passes with VNNI. Sums of squares come from summed-area tables through the mask's corners.
//! - *Sums* of direct searches ([`search_sum`]) are taken chunk by chunk: no map but the sum's is written, and
//!   templates of one searcher and weight are multiplied as one.
//! - *FFT* transforms tiles of the source once and keeps the spectra; a search transforms the template, sums the
//!   channels in the spectrum, transforms back and rounds. Rounding is exact: its bound is derived in `fft/bound.rs`,
//!   holds for every block of a template before it is searched, and is checked on every value.
//!
//! [`Engine::Auto`] compares two models of their time. With AVX-512 VNNI and three channels the direct engine is faster
//! up to about 900 compared samples over 192^2 and 600 over 512^2; with AVX2 up to about 200; without vectors the
//! transforms win from some 30 samples on. Leaving a position early, once it is worse than the best, does not pay: the
//! kernels are faster than the branches, and choices within a tolerance need every cost.
//!
//! # Memory
//! [`estimate()`] tells it from sizes. Spectra are the largest part: some 13 bytes a sample and channel. They are
//! kept while they fit [`Options::cache`]; beyond that they are made again for each search.
//!
//! `DESIGN.md` in this crate tells how it works and why, how fast it is beside its peers, and how time grows.
//!
//! # Features
//! `rayon` (default): a search is split over the caller's pool; the result is the same without it.
#![deny(unsafe_code)]

mod apart;
mod axes;
mod candidates;
mod costs;
mod cover;
mod direct;
mod error;
mod estimate;
mod extension;
mod fft;
mod job;
mod kernel;
mod memory;
mod nearest;
mod pack;
mod pick;
mod placement;
mod places;
mod prepared;
mod scratch;
mod searcher;
mod source;
mod stretch;
mod sum;
mod sums;
mod taps;
mod template;
mod word;

/// What this crate takes and answers with: exemplars, domains, planes, maps.
pub use selvedge_core as core;

pub use candidates::{Candidates, Tolerance};
pub use costs::{Costs, Errors, PositionGrid};
pub use error::Error;
pub use estimate::{Holdings, Sizes, estimate, held, held_in_box, held_of_part};
pub use nearest::{Coverage, Field, Neighbor, Windows, alike, nearest};
pub use pick::Candidate;
pub use placement::{Cover, Placement, Positions};
pub use places::{Pattern, Place};
pub use scratch::Scratch;
pub use searcher::{Engine, Options, SsdSearcher};
pub use sum::{SumScratch, Term, search_sum};
pub use template::Template;
