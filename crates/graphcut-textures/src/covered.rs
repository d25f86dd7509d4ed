//! A run in two parts: everything is covered, which tells what it will be worth, and seams are refined.

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::options::Options;
use crate::plan::{Plan, plan};
use crate::settings::Settings;
use crate::stats::Stats;
use crate::weaver::{Past, worked};

/// An output that is covered, of which no seam was refined: a sixth of the work, from where [`refine`](Self::refine)
/// goes on as if it had not stopped; at several levels it begins again, but measures nothing twice.
#[derive(Clone, Debug)]
pub struct Covered<const D: usize> {
    /// The map so far.
    pub woven: Woven<SourceMap<D>, Stats<D>>,
    settings: Settings<D>,
    options: Options<D>,
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
    let (start, settings, options) = (Start::empty(exemplars, output)?, plan.settings, *options);
    if settings.levels != 1 {
        let draft = Plan { options: Options { refine: Some(0), ..options }, ..plan };
        return Ok(Covered { woven: draft.weave(start, run)?, settings, options, past: None });
    }
    run.limits.admit(output, plan.bytes())?;
    let (woven, past) = worked(exemplars, start, &settings, &options, run, |weaver| weaver.cover_all(&mut |_| ()))?;
    Ok(Covered { woven, settings, options, past: Some(past) })
}

impl<const D: usize> Covered<D> {
    /// The second part: what [`graphcut`](crate::graphcut()) answers with these exemplars and run, which are those
    /// of [`cover`]. What was cancelled stays as it is.
    ///
    /// # Errors
    /// Those of [`graphcut`](crate::graphcut()).
    pub fn refine(self, exemplars: &Exemplars<D>, run: &Run<'_, D>) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        if !self.woven.complete {
            return Ok(self.woven);
        }
        let (settings, options, output) = (self.settings, self.options, self.woven.result.domain());
        let Some(past) = self.past else {
            return Plan { exemplars, output, options, settings }.weave(Start::empty(exemplars, output)?, run);
        };
        let start = Start { map: self.woven.result, fixed: None, sources: None };
        start.check(exemplars)?;
        let stats = self.woven.stats;
        let refine = |weaver: &mut crate::weaver::Weaver<'_, D>| {
            (weaver.history, weaver.step, weaver.stats) = (past.history, past.step, stats);
            weaver.refine(&mut |_| ())
        };
        worked(exemplars, start, &settings, &options, run, refine).map(|(woven, _)| woven)
    }
}
