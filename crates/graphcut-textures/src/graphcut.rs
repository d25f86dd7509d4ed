//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Woven};

use crate::error::Error;
use crate::estimate::estimate;
use crate::matching::singles;
use crate::options::{Options, Placement};
use crate::sizes::Sizes;
use crate::start::Start;
use crate::weaver::Weaver;

/// Counts of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats<const D: usize> {
    /// The placement that was used: never [`Placement::Auto`].
    pub placement: Placement,
    /// What [`Placement::Auto`] chose by: the strength of the exemplars' clearest
    /// [lattice](selvedge_analysis::Lattice::strength) (1 = 1000).
    pub regularity: Option<f64>,
    /// Sides of the error region that was used.
    pub region: [u32; D],
    /// How far patches could reach beyond it along each axis.
    pub reach: [u32; D],
    /// The variety that was used.
    pub variety: f64,
    /// Patches laid until everything was covered.
    pub patches: u64,
    /// Patches tried over bad seams.
    pub refinements: u64,
    /// Those of them that made seams cheaper.
    pub improvements: u64,
    /// Cuts that were solved.
    pub cuts: u64,
    /// Positions that cuts decided, over all cuts.
    pub cut_nodes: u64,
    /// Price of all seams when everything was covered, and after each refinement.
    pub energy: Vec<i64>,
}

impl<const D: usize> Stats<D> {
    /// Before the first patch.
    pub(crate) fn new(placement: Placement, region: [u32; D], reach: [u32; D], variety: f64) -> Self {
        Self {
            placement,
            regularity: None,
            region,
            reach,
            variety,
            patches: 0,
            refinements: 0,
            improvements: 0,
            cuts: 0,
            cut_nodes: 0,
            energy: Vec::new(),
        }
    }
}

/// Synthesises an output from patches of the exemplars, cut along the best seams. `[Kwatra03 3, 4]`
///
/// # Errors
/// Wrong options ([`Options::validate`]), an empty output, regions that no exemplar holds, and too little memory.
///
/// # Complexity
/// For `P` patches over exemplars of `N` samples: time `O(P N log N)` for the searches, and `P` maximum flows over at most
/// a region with its reach, or `N` nodes, whichever is less; `P` grows with the output's area. Space `O(output + N)`.
///
/// # Events
/// `"cover"` after each patch until nothing is empty; `"refine"` once before the first refinement and after each. All of
/// them carry the price of all seams and the map so far ([`Render::as_map`](selvedge_core::Render::as_map)).
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Step number `i` draws from `"graphcut/draw"`, `i`.
pub fn graphcut<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    check(exemplars, output, options, run)?;
    let map = SourceMap::unassigned(exemplars, output)?;
    weave(exemplars, Start { map, fixed: None, sources: None }, options, run)
}

/// Like [`graphcut`], going on from what is there.
///
/// # Errors
/// Those of [`graphcut`], [`Error::Shape`] and [`Error::ForeignMap`] for a start that does not fit, and
/// [`Error::NoSource`] where a hole may not be filled.
pub fn graphcut_from<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    check(exemplars, start.map.domain(), options, run)?;
    weave(exemplars, start, options, run)
}

/// A run of which options and memory were checked.
fn weave<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    start.check(exemplars)?;
    let singles = if start.sources.is_some() { singles(exemplars)? } else { Vec::new() };
    let laid = start.sources.as_ref().map(|field| laid(exemplars, field.plane(0))).transpose()?;
    let sizes = Sizes::new(laid.as_ref().unwrap_or(exemplars), options)?;
    let mut weaver = Weaver::new(exemplars, &singles, sizes, start, options, run)?;
    let outcome = weaver.weave();
    let complete = match outcome {
        Ok(complete) => complete,
        Err(error) if error.is_cancelled() => false,
        Err(error) => return Err(error),
    };
    Ok(Woven { result: weaver.canvas.map, stats: weaver.stats, complete })
}

/// The sources that a field of sources lets show anywhere: what regions and draws are measured by. A picture that stands in the
/// output, to be gone on from, is none of them.
fn laid<const D: usize>(exemplars: &Exemplars<D>, field: &[u64]) -> Result<Exemplars<D>, Error> {
    let bits = field.iter().fold(0, |all, bits| all | bits);
    Ok(exemplars.only((0..exemplars.sources().len()).filter(|number| bits >> number & 1 == 1))?)
}

/// What can be checked before anything is made.
///
/// # Errors
/// Those of [`Options::validate`], and [`Error::Memory`] if the run would need more than it may have.
fn check<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<(), Error> {
    options.validate()?;
    let domains: Vec<Domain<D>> = exemplars.sources().iter().map(|s| s.domain()).collect();
    let needed = estimate(&domains, exemplars.channels(), output, options);
    if needed <= run.limits.memory { Ok(()) } else { Err(Error::Memory { needed, limit: run.limits.memory }) }
}
