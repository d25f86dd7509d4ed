//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use selvedge_core::{Domain, Exemplars, Grid, Limits, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::estimate::{estimate, estimate_whole};
use crate::levels;
use crate::options::Options;
use crate::plan::{Plan, measured};
use crate::stats::Stats;
use crate::weaver::weave_at;
use crate::work::{Weighed, Work};

/// Synthesises an output from patches of the exemplars, cut along the best seams. `[Kwatra03 3, 4]`
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
    let plan = plan(exemplars, output, None, options, &run.limits)?;
    let map = SourceMap::unassigned(exemplars, output)?;
    plan.weave(exemplars, Start { map, fixed: None, sources: None }, options, run)
}

/// What [`graphcut_from`] would do with these exemplars, an output and a field of sources ([`Start::sources`], `None`
/// for all everywhere), without doing any of it: all that a run chooses by itself.
///
/// # Errors
/// Those of [`graphcut_from`] that are known before the first patch is laid, but for what is wrong with the start
/// itself.
///
/// # Complexity
/// Time `O(samples log(samples))` of the exemplars, however large the output is.
pub fn plan<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    field: Option<&Grid<u64, D>>,
    options: &Options<D>,
    limits: &Limits,
) -> Result<Plan<D>, Error> {
    check(exemplars, output, field.is_none(), options, limits)?;
    measured(exemplars, output, field, options)
}

/// What can be checked before anything is measured.
fn check<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    is_fresh: bool,
    options: &Options<D>,
    limits: &Limits,
) -> Result<(), Error> {
    options.validate()?;
    let domains = exemplars.domains();
    let is_whole = exemplars.sources().iter().all(|s| s.valid.is_none());
    let estimate = if is_fresh && is_whole { estimate_whole } else { estimate };
    Ok(limits.admit(output, estimate(&domains, exemplars.channels(), output, options))?)
}

/// True where nothing is there, or asked for, that a run at several sizes could not begin from.
fn is_fresh<const D: usize>(start: &Start<D>) -> bool {
    start.fixed.is_none() && start.sources.is_none() && start.map.holes() == start.map.domain().len()
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
    let output = start.map.domain();
    check(exemplars, output, is_fresh(&start), options, &run.limits)?;
    start.check(exemplars)?;
    measured(exemplars, output, start.sources.as_ref(), options)?.weave(exemplars, start, options, run)
}

impl<const D: usize> Plan<D> {
    /// Weaves as planned, from what is there; exemplars, output, field and options are those of the plan.
    ///
    /// # Errors
    /// Those of [`graphcut_from`].
    pub fn weave(
        &self,
        exemplars: &Exemplars<D>,
        start: Start<D>,
        options: &Options<D>,
        run: &Run<'_, D>,
    ) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        start.check(exemplars)?;
        if self.levels == 1 {
            return at_one_size(exemplars, start, self, options, run);
        }
        let output = start.map.domain();
        if is_fresh(&start) {
            return levels::weave(exemplars, output, self, options, run);
        }
        match options.levels {
            Some(levels) => Err(Error::LevelsOfStart { levels }),
            None => {
                check(exemplars, output, false, options, &run.limits)?;
                at_one_size(exemplars, start, &Self { levels: 1, ..*self }, options, run)
            }
        }
    }
}

/// A run at the size of its output, which says how far it is.
fn at_one_size<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    plan: &Plan<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    let work = Work::of(plan, start.map.domain(), 0, options);
    let observer = &Weighed { observer: run.observer, work };
    weave_at(exemplars, start, plan, options, &Run { observer, ..*run })
}
