//! What a run takes from its exemplars before it begins: the way of matching, regions, reach, and the scale of its draws.

use selvedge_analysis::{Texture, feature_size};
use selvedge_core::Exemplars;

use crate::candidates::variance;
use crate::error::Error;
use crate::graphcut::Stats;
use crate::options::{Options, Placement};

/// Varieties that are chosen: copies in rows are avoided at four times the exemplar's size, yet pieces stay whole. With 1 they
/// are crumbs, with 0 the same stones stand in rows. On a lattice all patches stand to each other as others do: more
/// of it is needed, and does no harm.
const VARIETY: f64 = 0.25;
const ORDERLY_VARIETY: f64 = 0.5;

/// A region holds no more than so many times the largest structures: of fine textures larger patches are no better, and cost
/// more.
const STRUCTURES: u32 = 4;

/// What was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes<const D: usize> {
    pub(crate) placement: Placement,
    /// Thousandths; measured where the placement hangs on it.
    regularity: Option<u32>,
    /// Sides of regions, whatever the output.
    pub(crate) sides: [u32; D],
    pub(crate) reach: [u32; D],
    /// `k sigma^2`. `[Kwatra03 eq. 3]`
    pub(crate) scale: f64,
    pub(crate) variety: f64,
}

impl<const D: usize> Sizes<D> {
    /// Measures the sources that may be laid.
    ///
    /// # Errors
    /// [`Error::RegionExceedsExemplar`], and [`Error::Search`] if memory is short.
    pub(crate) fn new(exemplars: &Exemplars<D>, options: &Options<D>) -> Result<Self, Error> {
        let measured = match options.placement {
            Placement::Auto => Texture::of_each(exemplars)?,
            _ => Vec::new(),
        };
        let placement = match options.placement {
            Placement::Auto if measured.iter().any(Texture::is_orderly) => Placement::Entire,
            Placement::Auto => Placement::Sub,
            chosen => chosen,
        };
        let regularity = measured.iter().map(|t| t.lattice.map_or(0, |l| l.strength)).max();
        let sides = region_sides(exemplars, &measured, options)?;
        // What a lattice is matched by should hold more of it than the region.
        let reach = options.reach.unwrap_or(match placement {
            Placement::Entire => sides.map(|n| n.saturating_mul(3).div_ceil(2)),
            _ => sides,
        });
        // At most far beyond any output, and still far from the end of positions.
        let reach = reach.map(|n| n.min(1 << 24));
        let scale = options.randomness * variance(exemplars);
        let chosen = if placement == Placement::Entire { ORDERLY_VARIETY } else { VARIETY };
        Ok(Self { placement, regularity, sides, reach, scale, variety: options.variety.unwrap_or(chosen) })
    }

    /// The beginning of a run's counts.
    pub(crate) fn stats(&self) -> Stats<D> {
        let mut stats = Stats::new(self.placement, self.sides, self.reach, self.variety);
        stats.regularity = self.regularity.map(|r| f64::from(r) / 1000.0);
        stats
    }
}

/// The sides of error regions: as asked, or a fourth of the exemplar's shortest side, but no more than four times its largest
/// structures. Smaller regions make crumbs of what is larger than they are, larger ones leave few places to take
/// patches from. Of several exemplars that of the shortest side counts, but not one under half of the largest: it is laid
/// where nothing else fits.
fn region_sides<const D: usize>(
    exemplars: &Exemplars<D>,
    measured: &[Texture],
    options: &Options<D>,
) -> Result<[u32; D], Error> {
    let shapes = || exemplars.sources().iter().map(|s| s.domain().shape);
    let shortest = |shape: &[u32; D]| shape.iter().copied().min().unwrap_or(0);
    let largest = shapes().max_by_key(shortest).unwrap_or([0; D]);
    let Some(region) = options.region else {
        let counts = |side: &u32| shortest(&largest) <= side.saturating_mul(2);
        let most = shapes().map(|shape| shortest(&shape)).filter(counts).min().unwrap_or(0);
        let known = measured.iter().map(|t| t.feature_size).max();
        let structure = known.map_or_else(|| feature_size(exemplars), Ok)?;
        let side = largest_region(most).min(structure.saturating_mul(STRUCTURES)).max(most.min(LEAST)).max(1);
        return Ok([side; D]);
    };
    if shapes().any(|shape| (0..D).all(|a| region[a] <= shape[a])) {
        return Ok(region);
    }
    Err(Error::RegionExceedsExemplar { region: region.to_vec(), largest: largest.to_vec() })
}

/// Smaller regions hold nothing that could be matched.
const LEAST: u32 = 8;

/// No region that the program chooses is larger, for exemplars whose longest shortest side is `side`.
pub(crate) fn largest_region(side: u32) -> u32 {
    (side / 4).max(side.min(LEAST)).max(1)
}
