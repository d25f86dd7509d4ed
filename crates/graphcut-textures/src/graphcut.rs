//! The method: lay patches until everything is covered, then lay more over the worst seams. `[Kwatra03 3, 4]`

use selvedge_core::{Domain, Exemplars, Grid, Limits, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::estimate::measuring;
use crate::levels;
use crate::options::Options;
use crate::plan::{Plan, measured};
use crate::stats::Stats;
use crate::weaver::weave_at;
use crate::work::{Weighed, Work};

/// Refuses other numbers of axes than one to three, at the line that calls what users call.
const fn supported(axes: usize) {
    assert!(1 <= axes && axes <= 3, "textures have one to three axes");
}

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
    plan.weave(exemplars, Start::empty(exemplars, output)?, options, run)
}

/// What [`graphcut_from`] would do with these exemplars, an output and a field of sources ([`Start::sources`], `None`
/// for all everywhere), without doing any of it: all that a run chooses by itself.
///
/// # Errors
/// Those of [`graphcut_from`] that are known before the first patch is laid, but for what is wrong with the start
/// itself, and for memory that only the work needs.
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
    const { supported(D) };
    check(exemplars, output, options, limits)?;
    measured(exemplars, output, field, options)
}

/// What can be checked before anything is measured.
fn check<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    limits: &Limits,
) -> Result<(), Error> {
    options.validate()?;
    let (sources, masked) = (exemplars.domains(), exemplars.is_masked());
    Ok(limits.admit(output, measuring(&sources, exemplars.channels(), masked, options))?)
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
    const { supported(D) };
    let output = start.map.domain();
    start.check(exemplars)?;
    plan(exemplars, output, start.sources.as_ref(), options, &run.limits)?.weave(exemplars, start, options, run)
}

impl<const D: usize> Plan<D> {
    /// The same for a run that goes on from `start`: where anything is there, or asked for, it has one size.
    ///
    /// # Errors
    /// [`Error::LevelsOfStart`] if the options ask for several.
    pub fn on(&self, start: &Start<D>, options: &Options<D>) -> Result<Self, Error> {
        match options.levels {
            _ if self.levels == 1 || is_fresh(start) => Ok(*self),
            None => Ok(Self { levels: 1, ..*self }),
            Some(levels) => Err(Error::LevelsOfStart { levels }),
        }
    }

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
        let (output, plan) = (start.map.domain(), self.on(&start, options)?);
        run.limits.admit(output, plan.bytes(exemplars, output, options))?;
        match plan.levels {
            1 => at_one_size(exemplars, start, &plan, options, run),
            _ => levels::weave(exemplars, output, &plan, options, run),
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
