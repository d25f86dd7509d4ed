//! What a run takes from its exemplars before it begins: the way of matching, regions, reach, and the scale of its
//! draws.

use selvedge_analysis::{Kind, Texture};
use selvedge_core::{Domain, Exemplars, Grid, ValidBoxes};

use crate::candidates::variance;
use crate::error::Error;
use crate::options::{Options, Placement, Stutter};
use crate::regions::{CLIP, held, region_sides};
use crate::sizes::sizes;

/// Varieties that are chosen: copies in rows are avoided at four times the exemplar's size, yet pieces stay whole. With
/// 1 they are crumbs, with 0 the same stones stand in rows. On a lattice all patches stand to each other as others do:
/// more of it is needed, and does no harm.
const VARIETY: f64 = 0.25;
const ORDERLY_VARIETY: f64 = 0.5;

/// What a run has chosen before it lays the first patch ([`Plan::settings`](crate::Plan::settings)).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings<const D: usize> {
    /// Never [`Placement::Auto`].
    pub placement: Placement,
    /// What [`Placement::Auto`] chose by: the strength of the exemplars' clearest
    /// [lattice](selvedge_analysis::Lattice::strength) (1 = 1000).
    pub regularity: Option<f64>,
    /// True if some exemplar was measured and is [orderly](selvedge_analysis::Texture::is_orderly).
    pub is_orderly: bool,
    /// Sides of error regions. No region is longer than the output.
    pub region: [u32; D],
    /// How far patches may reach beyond their region along each axis.
    pub reach: [u32; D],
    /// How much patches avoid to stand to each other as others do.
    pub variety: f64,
    /// How far patches lie from where a neighbour shows the same.
    pub apart: u32,
    /// Which of them may lie nearer all the same: never [`Stutter::Auto`].
    pub stutter: Stutter,
    /// At how many sizes the map is solved.
    pub levels: u32,
    /// `k sigma^2`. `[Kwatra03 eq. 3]`
    pub(crate) scale: f64,
    /// The longest sides of sources.
    pub(crate) longest: [u32; D],
}

/// The settings for the sources that a field of sources lets show anywhere: regions and draws are measured by them. A
/// picture that stands in the output, to be gone on from, is none of them.
///
/// # Errors
/// Those of [`Settings::new`].
pub(crate) fn measured<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    field: Option<&Grid<u64, D>>,
    options: &Options<D>,
) -> Result<Settings<D>, Error> {
    let whole = |sides: [u32; D]| std::array::from_fn(|a| if options.free[a] { sides[a] } else { output.shape[a] });
    let bound = Options { region: options.region.map(whole), ..*options };
    let mut settings = unbound(exemplars, output, field, &bound)?;
    if options.free.contains(&false) {
        settings.region = whole(settings.region);
        held(exemplars, settings.region)?;
    }
    Ok(settings)
}

/// The same, whatever is not free.
fn unbound<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    field: Option<&Grid<u64, D>>,
    options: &Options<D>,
) -> Result<Settings<D>, Error> {
    let Some(field) = field else {
        return Settings::new(exemplars, output, options, true);
    };
    let bits = field.plane(0).iter().fold(0, |all, bits| all | bits);
    let shown = exemplars.only((0..exemplars.sources().len()).filter(|number| bits >> number & 1 == 1))?;
    Settings::new(&shown, output, options, false)
}

/// An output of so many times the samples of the largest source shows few copies, and whole patches are what the eye
/// prefers then: over regions of a fourth on 10 of 13 textures without order at twice the sides by two readers, on none
/// of 4 at four times. Between them the bound is a guess: two and a half times the sides.
const FEW_COPIES: u64 = 6;

/// True for a picture that is hardly larger than its exemplar; of clips nothing was ranked.
fn shows_few_copies<const D: usize>(boxes: &ValidBoxes<'_, D>, output: Domain<D>) -> bool {
    let samples = |domain: Domain<D>| domain.shape.iter().fold(1, |n: u64, &side| n.saturating_mul(side.into()));
    let largest = boxes.domains().map(samples).max().unwrap_or(0);
    D == 2 && samples(output) <= largest.saturating_mul(FEW_COPIES)
}

impl<const D: usize> Settings<D> {
    /// Measures the sources that may be laid. Only if `may_show_few` may an output be one that shows few copies of
    /// them.
    ///
    /// # Errors
    /// [`Error::RegionExceedsExemplar`], and [`Error::Search`] if memory is short.
    pub(crate) fn new(
        exemplars: &Exemplars<D>,
        output: Domain<D>,
        options: &Options<D>,
        may_show_few: bool,
    ) -> Result<Self, Error> {
        let boxes = ValidBoxes::of(exemplars);
        let shows_few = shows_few_copies(&boxes, output);
        let few_copies = may_show_few && shows_few;
        // What was asked for by regions is laid by regions.
        let named = options.region.is_some() || options.reach.is_some();
        let lies_apart = options.apart.is_none() && options.region.is_none() && options.placement != Placement::Random;
        let chooses = lies_apart || options.placement == Placement::Auto;
        let measured = if chooses && D != CLIP { Texture::of_each(exemplars)? } else { Vec::new() };
        let is_orderly = measured.iter().any(Texture::is_orderly);
        let placement = match options.placement {
            Placement::Auto if few_copies && !named || is_orderly => Placement::Entire,
            Placement::Auto => Placement::Sub,
            chosen => chosen,
        };
        let told = if options.placement == Placement::Auto { &measured[..] } else { &[] };
        let regularity = told.iter().map(|t| t.lattice.map_or(0, |l| l.strength)).max();
        let sides = region_sides(exemplars, &boxes, &measured, options)?;
        let longest = longest(boxes.domains());
        let reach = reach(options, placement, sides, longest);
        // At most far beyond any output, and still far from the end of positions.
        let reach = reach.map(|n| n.min(1 << 24));
        let scale = options.randomness * variance(exemplars);
        let chosen = if placement == Placement::Entire { ORDERLY_VARIETY } else { VARIETY };
        let variety = options.variety.unwrap_or(chosen);
        let regularity = regularity.map(|r| f64::from(r) / 1000.0);
        let apart = options.apart.unwrap_or(if lies_apart { apart(sides, &measured) } else { 0 });
        let stutter = match options.stutter {
            Stutter::Auto if lies_apart && 0 < apart && shows_few => Stutter::Once,
            Stutter::Auto => Stutter::Never,
            chosen => chosen,
        };
        let levels = sizes(exemplars, output, (&measured, sides), options)?;
        let region = sides;
        Ok(Self { placement, regularity, is_orderly, region, reach, variety, apart, stutter, levels, scale, longest })
    }

    /// The same at the size of these exemplars, the coarsest.
    pub(crate) fn coarser(&self, exemplars: &Exemplars<D>, options: &Options<D>) -> Self {
        let small = |sides: [u32; D]| Domain::halved(sides, self.levels - 1);
        let (region, reach) = (small(self.region).map(|n| n.max(1)), small(self.reach));
        let apart = self.apart >> (self.levels - 1);
        let (scale, longest) = (options.randomness * variance(exemplars), small(self.longest));
        Self { region, reach, apart, levels: 1, scale, longest, ..*self }
    }
}

/// How far patches lie from where a neighbour shows the same: one and a half regions. With less, stripes of a region's
/// width were left on a floor of boards; with two regions structures broke. Two readers preferred it without exception
/// ([`Stutter::Never`]) on 5 of 7 textures each at four times the sides, on 8 and 9 of 18 at twice; there with each
/// move once ([`Stutter::Once`]) on 20 of the 28 sheets where they saw a difference. On a lattice the same comes again
/// by nature, in less than that: without its periods seams cost a fifth more. Of clips nothing was looked at.
fn apart<const D: usize>(sides: [u32; D], measured: &[Texture]) -> u32 {
    let lattice = measured.iter().any(|t| t.kind == Kind::Lattice);
    if D == CLIP || lattice { 0 } else { sides.into_iter().min().unwrap_or(0) * 3 / 2 }
}

/// How far patches reach: as asked; half of a region that was asked for; else a region, and for entire placement as far
/// as the exemplar goes: preferred to three eighths of its lesser side on 9 and 7 of 11 orderly textures at twice the
/// sides by two readers, on 5 of 6 at four times.
pub(crate) fn reach<const D: usize>(
    options: &Options<D>,
    placement: Placement,
    sides: [u32; D],
    longest: [u32; D],
) -> [u32; D] {
    options.reach.unwrap_or(match (options.region, placement) {
        // What moves in time alone is the whole clip. `[Kwatra03 7B]` Pieces of it settle where nothing moves: of a
        // candle a third of the motion was left, at seams that cost a tenth more.
        _ if options.free.contains(&false) => longest,
        (Some(_), _) => sides.map(|n| n.div_ceil(2)),
        (None, Placement::Entire | Placement::Auto) => longest,
        // Of a river as much moves as in the clip then. With a region's sides a fourth less does, at seams that cost 44
        // % more; with twice its sides steps begin to show.
        (None, _) if D == 3 => {
            std::array::from_fn(|a| if a == 0 { 2 * sides[0] } else { sides[a].saturating_mul(3) / 2 })
        }
        (None, _) => sides,
    })
}

/// The longest sides of sources; without end along axes on which one tiles. Patches are no longer.
pub(crate) fn longest<const D: usize>(sources: impl Iterator<Item = Domain<D>>) -> [u32; D] {
    let side = |source: &Domain<D>, a: usize| if source.periodic[a] { u32::MAX } else { source.shape[a] };
    sources.fold([0; D], |longest, source| std::array::from_fn(|a| longest[a].max(side(&source, a))))
}
