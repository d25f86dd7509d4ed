//! The method's door.

use selvedge_core::{Domain, Exemplars, Guidance, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::options::Options;
use crate::plan::Plan;
use crate::stats::Stats;

/// Synthesises an output from blocks of the exemplars that are split where they do not fit. `[Ding 3]`
///
/// Blocks are laid in raster order. Each is grown by an overlap on the sides where something stands, and looked for by
/// what stands there in all of the exemplars; while the mean error of the overlap exceeds [`Options::max_error`] it is
/// split into four, each of which is looked for anew. What is laid is cut along the path of least error, or, where its
/// error is not below [`Options::k`] times the largest, single samples along it are chosen anew.
///
/// # Errors
/// Options that are wrong by themselves ([`Options::validate`]), exemplars that hold no start block, an empty output,
/// one over the run's limits (its plan's [bytes](crate::Plan::bytes) count against their memory), or no memory for it.
///
/// # Complexity
/// With `n` exemplar samples, `c` channels and `b` searched blocks, splits among them: time `O(b * c * n log n)` at
/// most; `b` grows with the output's area. Space `O(output + c * n)`.
///
/// # Events
/// `"hybrid"` after each start block, with the map so far.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. A block draws from `"hybrid/block"`, keyed by its
/// start block's place in the layout, then from `"hybrid/split"`, keyed by its place in the split tree.
pub fn hybrid(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    Plan::new(exemplars, output, options, run)?.weave(run)
}

/// Like [`hybrid()`], going on from what is there: blocks are laid where something is missing. What stands inside of
/// them, and what is fixed, stays; what else stands beside them may be overlapped and cut. A guide is followed as
/// [`Plan::following`] says.
///
/// # Errors
/// Those of [`hybrid()`], of [`Plan::following`] and of [`Start::check`].
pub fn hybrid_from(
    exemplars: &Exemplars<2>,
    start: Start<2>,
    guidance: Option<Guidance<2>>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    let plan = Plan::new(exemplars, start.map.domain(), options, run)?;
    let plan = match guidance {
        Some(guidance) => plan.following(guidance)?,
        None => plan,
    };
    plan.weave_from(start, run)
}
