//! What a run takes from its exemplars before it begins: the way of matching, regions, reach, and the scale of its draws.

use selvedge_analysis::{feature_size, periodicity};
use selvedge_core::Exemplars;

use crate::candidates::variance;
use crate::error::Error;
use crate::graphcut::Stats;
use crate::options::{Options, Placement};

/// From this periodicity on, all that patches reach is matched. Of some sixty textures that it was tried on, text, keyboards,
/// baskets and nets reach 1030 and more, kilims and the like stay below 880, fruit, peas, crowds and brick walls with uneven
/// courses below 830.
const PERIODIC: u32 = 1000;

/// What was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes<const D: usize> {
    pub(crate) placement: Placement,
    /// Thousandths; measured where the placement hangs on it.
    periodicity: Option<u32>,
    /// Sides of regions, whatever the output.
    pub(crate) sides: [u32; D],
    pub(crate) reach: [u32; D],
    /// `k sigma^2`. `[Kwatra03 eq. 3]`
    pub(crate) scale: f64,
}

impl<const D: usize> Sizes<D> {
    /// Measures the sources that may be laid.
    ///
    /// # Errors
    /// [`Error::RegionExceedsExemplar`], and [`Error::Search`] if memory is short.
    pub(crate) fn new(exemplars: &Exemplars<D>, options: &Options<D>) -> Result<Self, Error> {
        let periodicity = (options.placement == Placement::Auto).then(|| periodicity(exemplars)).transpose()?;
        let placement = match options.placement {
            Placement::Auto if PERIODIC <= periodicity.unwrap_or(0) => Placement::Entire,
            Placement::Auto => Placement::Sub,
            chosen => chosen,
        };
        let sides = region_sides(exemplars, options)?;
        // At most far beyond any output, and still far from the end of positions.
        let reach = options.reach.unwrap_or(sides.map(|n| n.div_ceil(2))).map(|n| n.min(1 << 24));
        let scale = options.randomness * variance(exemplars);
        Ok(Self { placement, periodicity, sides, reach, scale })
    }

    /// The beginning of a run's counts.
    pub(crate) fn stats(&self) -> Stats<D> {
        let periodicity = self.periodicity.map(|p| f64::from(p) / 1000.0);
        Stats::new(self.placement, periodicity, self.sides, self.reach)
    }
}

/// The sides of error regions: as asked, or three fifths of the largest structures, so that a region with its
/// surroundings holds one of them; but no less than an eighth of the exemplar's shortest side (at most 28), for
/// repetitions of small patches are seen, and no more than a quarter of it (at most 76), for few large ones fit. Of several
/// exemplars that of the shortest side counts, but not one under half of the largest: it is laid where nothing else fits.
fn region_sides<const D: usize>(exemplars: &Exemplars<D>, options: &Options<D>) -> Result<[u32; D], Error> {
    let shapes = || exemplars.sources().iter().map(|s| s.domain().shape);
    let shortest = |shape: &[u32; D]| shape.iter().copied().min().unwrap_or(0);
    let largest = shapes().max_by_key(shortest).unwrap_or([0; D]);
    let Some(region) = options.region else {
        let counts = |side: &u32| shortest(&largest) <= side.saturating_mul(2);
        let most = shapes().map(|shape| shortest(&shape)).filter(counts).min().unwrap_or(0);
        let side = (feature_size(exemplars)? * 3 / 5).clamp(least_region(most), largest_region(most));
        return Ok([side; D]);
    };
    if shapes().any(|shape| (0..D).all(|a| region[a] <= shape[a])) {
        return Ok(region);
    }
    Err(Error::RegionExceedsExemplar { region: region.to_vec(), largest: largest.to_vec() })
}

/// No region that the program chooses is larger, for exemplars whose longest shortest side is `side`.
pub(crate) fn largest_region(side: u32) -> u32 {
    (side / 4).clamp(least_region(side), 76)
}

fn least_region(side: u32) -> u32 {
    (side / 8).min(28).max(side.min(8)).max(1)
}
