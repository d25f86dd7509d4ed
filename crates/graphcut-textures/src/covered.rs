//! A run in two parts: everything is covered, which tells what it will be worth, and seams are refined.

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::graphcut::plan;
use crate::options::Options;
use crate::plan::Plan;
use crate::stats::Stats;
use crate::weaver::{Past, worked};

/// An output that is covered, of which no seam was refined: a sixth of the work, from where [`refine`](Self::refine)
/// goes on as if it had not stopped; at several levels it begins again, but measures nothing twice.
#[derive(Clone, Debug)]
pub struct Covered<const D: usize> {
    /// The map so far.
    pub woven: Woven<SourceMap<D>, Stats<D>>,
    plan: Plan<D>,
    /// `None` at several levels, where nothing is left to go on from.
    past: Option<Past<D>>,
}

/// The first part of [`graphcut`](crate::graphcut()). At several levels it decides finer ones as well.
///
/// # Errors
/// Those of [`graphcut`](crate::graphcut()).
pub fn cover<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Covered<D>, Error> {
    let plan = plan(exemplars, output, None, options, &run.limits)?;
    if plan.levels != 1 {
        let start = Start::empty(exemplars, output)?;
        let woven = plan.weave(exemplars, start, &Options { refine: Some(0), ..*options }, run)?;
        return Ok(Covered { woven, plan, past: None });
    }
    run.limits.admit(output, plan.bytes(exemplars, output, options))?;
    let start = Start::empty(exemplars, output)?;
    let (woven, past) = worked(exemplars, start, &plan, options, run, |weaver| weaver.cover_all())?;
    Ok(Covered { woven, plan, past: Some(past) })
}

impl<const D: usize> Covered<D> {
    /// The second part: what [`graphcut`](crate::graphcut()) answers with these exemplars, options and run, which are
    /// those of [`cover`]. What was cancelled stays as it is.
    ///
    /// # Errors
    /// Those of [`graphcut`](crate::graphcut()).
    pub fn refine(
        self,
        exemplars: &Exemplars<D>,
        options: &Options<D>,
        run: &Run<'_, D>,
    ) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        if !self.woven.complete {
            return Ok(self.woven);
        }
        let (plan, Some(past)) = (self.plan, self.past) else {
            let start = Start::empty(exemplars, self.woven.result.domain())?;
            return self.plan.weave(exemplars, start, options, run);
        };
        let start = Start { map: self.woven.result, fixed: None, sources: None };
        start.check(exemplars)?;
        let stats = self.woven.stats;
        let refine = |weaver: &mut crate::weaver::Weaver<'_, D>| {
            (weaver.history, weaver.step, weaver.stats) = (past.history, past.step, stats);
            weaver.refine()
        };
        worked(exemplars, start, &plan, options, run, refine).map(|(woven, _)| woven)
    }
}
