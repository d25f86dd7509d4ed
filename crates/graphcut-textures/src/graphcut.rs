//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::options::Options;
use crate::plan::{plan, supported};
use crate::stats::Stats;

/// Synthesises an output from patches of the exemplars, cut along the best seams. `[Kwatra03 3, 4]`
///
/// An output that one exemplar covers is mostly a piece of it, since that has no seams at all; give
/// [`Options::region`] and [`Options::reach`] for another weave. One to three axes: the line that asks for a fourth
/// does not compile.
///
/// ```compile_fail,E0080
/// use selvedge_core::{Domain, Exemplars, Run};
/// use selvedge_graphcut_textures::{Options, graphcut};
///
/// let four = |e: &Exemplars<4>| graphcut(e, Domain::open([9; 4]), &Options::default(), &Run::seeded(0)).is_ok();
/// None.map(four);
/// ```
///
/// # Errors
/// Wrong options ([`Options::validate`]), an empty output, regions that no exemplar holds, and too little memory.
///
/// # Complexity
/// For `P` patches over exemplars of `N` samples: time `O(P N log N)` for the searches, and `P` maximum flows over at
/// most a region with its reach, or `N` nodes, whichever is less; `P` grows with the output's area. Space `O(output +
/// N)`.
///
/// # Events
/// `"cover"` after each patch until nothing is empty; `"refine"` once before the first refinement and after each. All
/// of them carry the price of all seams and the map so far ([`Render::as_map`](selvedge_core::Render::as_map)), these
/// of the smallest of several levels but no map; `"settle"` as finer levels are decided, with the price once one is.
/// All tell their part of the whole [work](selvedge_core::Event::work).
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Step number `i` draws from `"graphcut/draw"`, `i`.
pub fn graphcut<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    const { supported(D) };
    let plan = plan(exemplars, output, None, options, &run.limits)?;
    plan.weave(Start::empty(exemplars, output)?, run)
}

/// Like [`graphcut`], going on from what is there.
///
/// # Errors
/// Those of [`graphcut`] and of [`Start::check`].
pub fn graphcut_from<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    const { supported(D) };
    let output = start.map.domain();
    start.check(exemplars)?;
    plan(exemplars, output, start.sources.as_ref(), options, &run.limits)?.weave(start, run)
}
