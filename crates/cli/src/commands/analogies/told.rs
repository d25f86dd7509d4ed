//! What runs of constrained synthesis tell: errors with their remedies, and counts.

use std::path::Path;

use selvedge_cms_analogies::{Energy, Stats};
use selvedge_core::{SourceMap, Woven};
use serde_json::Value;

use crate::failure::{Failure, n};
use crate::outcome::Outcome;
use crate::session::Session;
use crate::values::counts;

/// Errors with the options that mend them.
pub(in crate::commands) fn failure(error: selvedge_cms_analogies::Error) -> Failure {
    use selvedge_cms_analogies::Error;
    let remedy = match &error {
        Error::Neighborhood { .. } => Some("use a smaller -N, or larger pictures"),
        Error::Core(selvedge_core::Error::Range { option: "weight", .. }) => {
            Some("change --weight, or -K: weights are 0 to 10000, times K as well")
        }
        _ => None,
    };
    let failure = Failure::from(error);
    match remedy {
        Some(remedy) => failure.remedy(remedy),
        None => failure,
    }
}

/// Says that costs were too large to be told apart, if some were.
pub(in crate::commands) fn warn_of_saturation(session: &Session<'_>, stats: &Stats, target: &Path) {
    if stats.saturated != 0 {
        let prices = n("price", stats.saturated as usize);
        session.warn(
            target,
            &format!("{prices} of agreement as large as there are, and so alike: use a smaller -K or -N"),
        );
    }
}

/// What was made, with its counts.
pub(in crate::commands) fn outcome(woven: Woven<SourceMap<2>, Stats>) -> Outcome {
    let stats = &woven.stats;
    let places = n("place", stats.searches as usize);
    let how = format!("from {} of {} labels for {places}", stats.improvements, stats.expansions);
    Outcome::new(Box::new(woven.result), woven.complete, counts(stats), how)
}

fn counts(stats: &Stats) -> Value {
    let parts = |e: Energy| {
        let mut parts = counts!(e, agreement, boundary);
        if e.usage != 0 {
            parts["usage"] = e.usage.into();
        }
        parts
    };
    let mut all = counts!(stats, searches, expansions, improvements, nodes, pruned, truncated, saturated, energy);
    (all["model"], all["truth"]) = (parts(stats.model), parts(stats.truth));
    all
}
