//! What is told of hybrid synthesis: options as used, counts, how it was made, what is wrong.

use selvedge_hybrid::{Error, Level, Plan, Stats};
use serde_json::{Value, json};

use super::Hybrid;
use super::choices::{self, typed};
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::used::Used;
use crate::values::counts;

impl Hybrid {
    /// The options as used.
    pub(super) fn used(&self, loom: &Loom<'_>, plan: &Plan) -> Used {
        let options = self.options();
        self.guides
            .used(loom, loom.used())
            .set("block", typed(plan.block()))
            .set("overlap", options.overlap)
            .set("max-error", choices::Error(options.max_error).to_string())
            .set("pixel-error", choices::Error(options.pixel_error).to_string())
    }
}

/// Counts of a run.
pub(super) fn counts(stats: &Stats) -> Value {
    let mut all = counts!(stats, max_error, pixel_error, unsplittable, cuts, resyntheses, pixels);
    let level = |level: &Level| counts!(level, blocks, splits, error);
    all["levels"] = json!(stats.levels.iter().map(level).collect::<Vec<_>>());
    all
}

/// For people.
pub(super) fn how(stats: &Stats) -> String {
    let blocks: u64 = stats.levels.iter().map(|level| level.blocks - level.splits).sum();
    let (blocks, pixels) = (n("block", blocks as usize), n("pixel", stats.pixels as usize));
    format!("from {blocks} of {} px and smaller, {pixels} re-synthesised", typed(stats.block))
}

/// Errors about exemplars name the file, and options by their flags.
pub(super) fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    match &error {
        Error::BlockExceedsExemplar { limit, .. } => {
            let remedy = format!("use --block {limit} or a larger exemplar");
            loom.loaded.about(Failure::from(error).remedy(remedy))
        }
        _ => Failure::from(error),
    }
}
