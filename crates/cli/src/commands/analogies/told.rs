//! What runs of constrained synthesis tell: errors with their remedies, and counts.

use selvedge_cms_analogies::{Energy, Stats};
use serde_json::Value;

use crate::failure::Failure;
use crate::values::counts;

/// Errors with the options that mend them.
pub(in crate::commands) fn failure(error: selvedge_cms_analogies::Error) -> Failure {
    use selvedge_cms_analogies::Error;
    let remedy = match &error {
        Error::Neighborhood { .. } => Some("use a smaller -N, or larger pictures"),
        Error::Core(selvedge_core::Error::Range { option: "weight", .. }) => Some("change --weight, or -K"),
        _ => None,
    };
    let failure = Failure::from(error);
    match remedy {
        Some(remedy) => failure.remedy(remedy),
        None => failure,
    }
}

pub(in crate::commands) fn counts(stats: &Stats) -> Value {
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
