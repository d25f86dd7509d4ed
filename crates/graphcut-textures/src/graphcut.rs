//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Woven};

use crate::error::Error;
use crate::estimate::estimate;
use crate::options::{Options, Placement};
use crate::start::Start;
use crate::weaver::Weaver;

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// The placement that was used: never [`Placement::Auto`].
    pub placement: Placement,
    /// What [`Placement::Auto`] chose by: the exemplars' [`periodicity`](selvedge_fft_ssd::periodicity) (1 = 1000).
    pub periodicity: Option<f64>,
    /// Side of the error region that was used.
    pub region: u32,
    /// How far patches could reach beyond it.
    pub reach: u32,
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

/// Synthesises an output from patches of the exemplars, cut along the best seams. `[Kwatra03 3, 4]`
///
/// # Errors
/// Wrong options ([`Options::validate`]), an empty output, regions that no exemplar holds, and too little memory.
///
/// # Complexity
/// For `P` patches over exemplars of `N` samples: time `O(P N log N)` for the searches, and `P` maximum flows over at most
/// a region with its reach, or `N` nodes, whichever is less; `P` grows with the output's area. Space `O(output + N)`.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Step number `i` draws from `"graphcut/draw"`, `i`.
pub fn graphcut<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats>, Error> {
    options.validate()?;
    check_memory(exemplars, output, options, run)?;
    let map = SourceMap::unassigned(exemplars, output)?;
    graphcut_from(exemplars, Start { map, fixed: None, sources: None }, options, run)
}

/// Like [`graphcut`], going on from what is there.
///
/// # Errors
/// Those of [`graphcut`], [`Error::Shape`] and [`Error::ForeignMap`] for a start that does not fit, and
/// [`Error::NoSource`] where a hole may not be filled.
pub fn graphcut_from<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    options: &Options,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats>, Error> {
    options.validate()?;
    start.check(exemplars)?;
    check_memory(exemplars, start.map.domain(), options, run)?;
    let mut weaver = Weaver::new(exemplars, start, options, run)?;
    let outcome = weaver.weave();
    let complete = match outcome {
        Ok(complete) => complete,
        Err(error) if error.is_cancelled() => false,
        Err(error) => return Err(error),
    };
    Ok(Woven { result: weaver.canvas.map, stats: weaver.stats, complete })
}

/// # Errors
/// [`Error::Memory`] if the run would need more than it may have.
fn check_memory<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options,
    run: &Run<'_, D>,
) -> Result<(), Error> {
    let domains: Vec<Domain<D>> = exemplars.sources().iter().map(|s| s.domain()).collect();
    let needed = estimate(&domains, exemplars.channels(), output, options);
    if needed <= run.limits.memory { Ok(()) } else { Err(Error::Memory { needed, limit: run.limits.memory }) }
}
