//! Where does a (masked) piece of output fit the exemplars best? Exact sums of squared differences at every position,
//! in pictures and clips.
//!
//! 1. [`SsdSearcher::new`] prepares the exemplars once.
//! 2. [`search`](SsdSearcher::search) compares a [`Template`] at every position of a [`Placement`]; the answer is a
//!    [`Costs`], one integer a position. [`Scratch`] and [`Costs`] are the caller's and are used again.
//! 3. [`best`](Costs::best), [`best_k`](Costs::best_k) and [`within`](Costs::within) choose, each with a variant that
//!    excludes positions; [`blend`](Costs::blend) sums the costs of several searches.
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Samples};
//! use selvedge_fft_ssd::{Costs, Placement, Scratch, SsdSearcher, Template};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let grey = Grid::from_vec(Domain::open([2, 4]), 1, vec![1_u8, 2, 3, 4, 5, 6, 7, 8])?;
//! let plane = Plane::new(Role::Scalar, Samples::U8(grey));
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
//! let near = costs.within(selvedge_fft_ssd::Tolerance { per_mille: 0, floor: 1 });
//! assert_eq!(near.len(), 3);
//! # Ok(())
//! # }
//! ```
//!
//! # Direction of the offset
//! At position `p`, sample `x` of the template is compared with source sample `x + p`. If the template was cut from the
//! output at `o`, copying the source there is a translation by the offset `o - p` (output position = exemplar position
//! plus offset, the `t` of `[Kwatra03 eq. 4]`).
//!
//! # Features
//! `rayon` (default): a search is split over the caller's pool; the result is the same without it.
#![deny(unsafe_code)]

mod axes;
mod candidates;
mod costs;
mod cover;
mod direct;
mod error;
mod extension;
mod fft;
mod job;
mod kernel;
mod pack;
mod placement;
mod prepared;
mod scratch;
mod searcher;
mod source;
mod sums;
mod taps;
mod template;
mod word;

pub use candidates::{Candidate, Candidates, Tolerance};
pub use costs::{Costs, Errors, Positioned};
pub use error::Error;
pub use placement::{Cover, Placement, Positions};
pub use scratch::Scratch;
pub use searcher::{Engine, Options, SsdSearcher};
pub use template::Template;
