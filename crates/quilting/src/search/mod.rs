//! Block search: which block of the exemplars fits best, drawn so that exemplars are used evenly and not repeated
//! verbatim. `[Efros01 2.2]`
//!
//! ```
//! use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Samples, Seed, SimdLevel, Usage};
//! use selvedge_fft_ssd::Template;
//! use selvedge_quilting::search::{BlockScratch, BlockSearch, Preference, Space, Term};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let ramp = Grid::from_vec(Domain::open([2, 6]), 1, vec![1_u8, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6])?;
//! let plane = Plane::new(Role::Scalar, Samples::U8(ramp));
//! let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
//! let search = BlockSearch::new(&exemplars, None, SimdLevel::Auto)?;
//!
//! // Blocks of 2 by 3 whose first column fits a column of 4.
//! let (features, overlap) = ([4, 0, 0, 4, 0, 0], [true, false, false, true, false, false]);
//! let template = Template::new([2, 3], &features).masked(&overlap);
//! let terms = [Term { space: Space::Texture, template, weight: 1 }];
//! let preference = Preference { per_mille: 0, usage: &Usage::new(&exemplars, [2, 3], 0.0)?, continued: &[] };
//! let drawn = search.draw(&terms, &preference, &mut Seed(1).rng(), &mut BlockScratch::default())?;
//! let (chosen, of) = drawn.expect("a block fits");
//! assert_eq!((chosen.error, chosen.at, of), (0, [0, 3], 1));
//! # Ok(())
//! # }
//! ```

mod block_search;
mod continued;
mod few;
mod from_above;
#[cfg(test)]
pub(crate) mod plain;

use selvedge_core::{Look, Rng, Usage, reserve};
use selvedge_fft_ssd::Template;

use crate::options::Error;

pub use block_search::{BlockScratch, BlockSearch};
pub use continued::Successor;
pub(crate) use from_above::{FromAbove, Reduced, halved, halvings, halvings_of_whole};

/// Which features are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Those of the exemplars.
    Texture,
    /// Those of the guide under the exemplars.
    Guide,
}

/// One thing that a block has to agree with.
#[derive(Clone, Copy, Debug)]
pub struct Term<'a> {
    /// The features that `template` has.
    pub space: Space,
    /// What lies there, and where it is compared.
    pub template: Template<'a, 2>,
    /// How often its squared differences count.
    pub weight: u64,
}

impl<'a> Term<'a> {
    /// A term of weight 1: what a look at a window of this shape knows.
    pub fn new(space: Space, shape: [u32; 2], look: &'a Look) -> Self {
        Self { space, template: Template::new(shape, look.features()).masked(look.known()), weight: 1 }
    }
}

/// One block of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate {
    /// Sum over the terms of weight times squared feature differences, each channel by its own weight.
    pub error: u64,
    /// The source.
    pub source: usize,
    /// The block's top left sample.
    pub at: [u32; 2],
}

/// By what one is drawn of the blocks that fit.
#[derive(Clone, Copy, Debug)]
pub struct Preference<'a> {
    /// How much more than the least an error may count, in thousandths.
    pub per_mille: u32,
    /// Errors count more where parts were used more; [`Usage::new`] with a spread of 0 for errors as they are.
    pub usage: &'a Usage<2>,
    /// Where neighbours would go on: no block near one of these is drawn as long as there is any other.
    pub continued: &'a [Successor],
}

/// What a squared difference counts in each of two means, given as thousandths of the sum of both and as how much is
/// averaged (samples times channels' weights): fixed point, to the nearest.
///
/// The unit is the same for both. It leaves weights 32 bits at most, which searches sum fastest, and sums of squared
/// 8-bit steps 60.
///
/// ```
/// use selvedge_quilting::search::mean_weights;
/// // Three tenths of the mean of 12 differences, and seven tenths of that of 6.
/// let [a, b] = mean_weights([(300, 12), (700, 6)]);
/// assert!((a * 12 * 7).abs_diff(b * 6 * 3) < 200 && a <= u64::from(u32::MAX));
/// ```
pub fn mean_weights(means: [(u32, u64); 2]) -> [u64; 2] {
    let least = means.iter().map(|m| m.1).filter(|&n| n != 0).min().unwrap_or(1);
    let unit = (u128::from(least) << 31).min(1 << 44);
    means.map(|(share, n)| {
        let n = 1000 * u128::from(n);
        (u128::from(share) * unit + n / 2).checked_div(n).unwrap_or(0) as u64
    })
}

/// Which candidates are passed over while there are others: by source and top left sample.
pub(crate) type Avoid<'a> = &'a dyn Fn(usize, [u32; 2]) -> bool;

/// How much worse than the best a candidate may be, in thousandths, if that is the best.
pub(crate) type Within<'a> = &'a dyn Fn(&Candidate) -> u32;

/// Finds the blocks within a tolerance of the best.
pub(crate) trait Search: Sync {
    /// Working memory of one search after the other.
    type Scratch: Default + Send + Sync;

    /// Places that a search holds an answer for at once: no more run beside each other than there is memory for.
    fn places(&self) -> u64;

    /// Of all candidates that `avoid` lets pass (of all, if it lets none pass), those `within` a tolerance of the first
    /// by error, source and position, in the order of source and position. None if no valid block fits.
    ///
    /// There is at least one term, and all templates have one shape.
    fn near<'s>(
        &self,
        terms: &[Term<'_>],
        within: Within<'_>,
        avoid: Avoid<'_>,
        scratch: &'s mut Self::Scratch,
    ) -> Result<&'s [Candidate], Error>;
}

/// Of all blocks whose error counts within the tolerance of the least, one by a uniform draw, and how many there were;
/// `None` if no valid block fits.
pub(crate) fn draw<S: Search>(
    search: &S,
    terms: &[Term<'_>],
    preference: &Preference<'_>,
    rng: &mut Rng,
    scratch: &mut S::Scratch,
) -> Result<Option<(Candidate, u32)>, Error> {
    let mut one = Vec::new();
    let n = draw_some(search, terms, preference, (rng, 1), scratch, &mut one)?;
    Ok(one.pop().map(|chosen| (chosen, n)))
}

/// The same for up to so many different ones, in the order in which they are drawn; how many there are to draw from.
pub(crate) fn draw_some<S: Search>(
    search: &S,
    terms: &[Term<'_>],
    preference: &Preference<'_>,
    (rng, most): (&mut Rng, usize),
    scratch: &mut S::Scratch,
    drawn: &mut Vec<Candidate>,
) -> Result<u32, Error> {
    drawn.clear();
    let Preference { per_mille, usage, continued } = *preference;
    let avoid = |source: usize, at: [u32; 2]| continued.iter().any(|c| c.is_near(source, at));
    let within = |best: &Candidate| usage.widened(per_mille, best.source, best.at);
    let candidates = search.near(terms, &within, &avoid, scratch)?;
    let counted = |c: &Candidate| usage.counted(c.error, c.source, c.at);
    let Some(least) = candidates.iter().map(counted).min() else { return Ok(0) };
    let limit = least * (1000 + u128::from(per_mille));
    let near = || candidates.iter().filter(|c| counted(c) * 1000 <= limit);
    let n = near().count() as u32;
    reserve(drawn, most.min(n as usize))?;
    let mut numbers = Vec::new();
    for left in (n.saturating_sub(most as u32)..n).rev().take(most) {
        // The number among those that were not drawn yet.
        let mut number = rng.below(left + 1);
        for &before in &numbers {
            number += u32::from(before <= number);
        }
        numbers.insert(numbers.partition_point(|&before| before < number), number);
        drawn.extend(near().nth(number as usize));
    }
    Ok(n)
}
