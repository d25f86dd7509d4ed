//! What runs of constrained synthesis tell: errors with their remedies, and counts.

use selvedge_cms_analogies::Stats;
use serde_json::json;

use crate::failure::Failure;

/// Errors with the options that mend them.
pub(in crate::commands) fn failure(error: selvedge_cms_analogies::Error) -> Failure {
    use selvedge_cms_analogies::Error;
    let remedy = match &error {
        Error::Neighborhood { .. } => Some("use a smaller -N, or larger pictures"),
        Error::Range { option: "weight", .. } => Some("change --weight, or -K"),
        _ => None,
    };
    let failure = Failure::from(error);
    match remedy {
        Some(remedy) => failure.remedy(remedy),
        None => failure,
    }
}

pub(in crate::commands) fn counts(stats: &Stats) -> serde_json::Value {
    let parts = |e: selvedge_cms_analogies::Energy| {
        let mut parts = json!({ "agreement": e.agreement, "boundary": e.boundary });
        if e.usage != 0 {
            parts["usage"] = e.usage.into();
        }
        parts
    };
    json!({
        "searches": stats.searches,
        "expansions": stats.expansions,
        "improvements": stats.improvements,
        "nodes": stats.nodes,
        "pruned": stats.pruned,
        "truncated": stats.truncated,
        "saturated": stats.saturated,
        "model": parts(stats.model),
        "truth": parts(stats.truth),
        "energy": stats.energy,
    })
}
