//! A run in two parts: everything is covered, which tells what it will be worth, and seams are refined.

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::graphcut::{graphcut, plan};
use crate::options::Options;
use crate::plan::Plan;
use crate::stats::Stats;
use crate::weaver::{Past, worked};

/// An output that is covered, of which no seam was refined: a sixth of the work, from where [`refine`](Self::refine)
/// goes on as if it had not stopped.
#[derive(Clone, Debug)]
pub struct Covered<const D: usize> {
    /// The map so far.
    pub woven: Woven<SourceMap<D>, Stats<D>>,
    /// `None` at several levels, where nothing is left to go on from.
    rest: Option<(Plan<D>, Past<D>)>,
}

/// The first part of [`graphcut`]. At several levels it decides finer ones as well.
///
/// # Errors
/// Those of [`graphcut`].
pub fn cover<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Covered<D>, Error> {
    let plan = plan(exemplars, output, None, options, &run.limits)?;
    if plan.levels != 1 {
        let woven = graphcut(exemplars, output, &Options { refine: Some(0), ..*options }, run)?;
        return Ok(Covered { woven, rest: None });
    }
    run.limits.admit(output, plan.bytes(exemplars, output, options))?;
    let map = SourceMap::unassigned(exemplars, output)?;
    let start = Start { map, fixed: None, sources: None };
    let (woven, past) = worked(exemplars, start, &plan, options, run, |weaver| weaver.cover_all())?;
    Ok(Covered { woven, rest: Some((plan, past)) })
}

impl<const D: usize> Covered<D> {
    /// The second part: what [`graphcut`] answers with these exemplars, options and run, which are those of [`cover`].
    /// What was cancelled stays as it is.
    ///
    /// # Errors
    /// Those of [`graphcut`].
    pub fn refine(
        self,
        exemplars: &Exemplars<D>,
        options: &Options<D>,
        run: &Run<'_, D>,
    ) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        if !self.woven.complete {
            return Ok(self.woven);
        }
        let Some((plan, past)) = self.rest else {
            return graphcut(exemplars, self.woven.result.domain(), options, run);
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
