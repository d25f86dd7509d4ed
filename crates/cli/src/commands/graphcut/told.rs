//! What is told of a graph cut: options as used, counts, how it was made, what is wrong.

use selvedge_graphcut_textures::{Error, Settings, Stats, Stutter};
use serde_json::{Value, json};

use super::Graphcut;
use crate::failure::Failure;
use crate::loom::Loom;
use crate::used::Used;
use crate::values::{counts, name_of, sides_typed};

impl Graphcut {
    /// The options as used; with one size where another would be chosen.
    pub(super) fn used(&self, loom: &Loom<'_>, settings: &Settings<2>, has_one: bool) -> Used {
        let used = loom
            .used()
            .without("checkpoint")
            .without("resume")
            .set("placement", name_of(settings.placement))
            .set("region", sides_typed(settings.region))
            .set("reach", sides_typed(settings.reach))
            .set("variety", settings.variety)
            .set("apart", settings.apart)
            .unless("apart", 0)
            .set("stutter", name_of(settings.stutter))
            .unless("stutter", name_of(Stutter::Never))
            .set("levels", settings.levels);
        // Most have one, and would choose it again; where it was asked for, another might be chosen.
        let chosen = self.levels.0.is_none() && !has_one;
        self.sources.used(self.refining.used(if chosen { used.unless("levels", 1) } else { used }))
    }
}

/// Counts of a run.
pub(super) fn counts(stats: &Stats<2>) -> Value {
    let mut all = counts!(stats, patches, refinements, improvements, cuts, cut_nodes, energy);
    all["regularity"] = stats.settings.regularity.into();
    // Energies are those of the smallest of several sizes.
    if 1 < stats.settings.levels {
        (all["levels"], all["settled"]) = (stats.settings.levels.into(), json!(stats.settled));
    }
    all
}

/// For people.
pub(super) fn how(stats: &Stats<2>, untouched: bool) -> String {
    if untouched {
        return "as it was: the picture has no holes, and no --fixed makes some".to_owned();
    }
    let placement = name_of(stats.settings.placement);
    let (patches, improvements) = (stats.patches, stats.improvements);
    let why = stats.settings.regularity.map_or(String::new(), |r| format!(" at a regularity of {r}"));
    format!("from {patches} patches and {improvements} refinements, {placement} placement{why}")
}

/// Exemplars that no region fits into are laid where nothing larger may be.
pub(super) fn warn_of_small(loom: &Loom<'_>, [height, width]: [u32; 2]) {
    let sources = loom.loaded.exemplars.sources();
    for (number, path) in loom.loaded.given().iter().enumerate() {
        let mut own = sources.iter().filter(|s| usize::from(s.origin.exemplar) == number).map(|s| s.domain().shape);
        if own.all(|[h, w]| h < height || w < width) {
            let what =
                format!("smaller than the regions of {width}x{height} px; use a smaller --region to see more of it");
            loom.session.warn(path, &what);
        }
    }
}

/// Errors about exemplars name the file, and options by their flags.
pub(super) fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    match &error {
        Error::RegionExceedsExemplar { largest, .. } => {
            let most = largest.iter().min().copied().unwrap_or(0);
            let remedy = format!("use --region {most} or a larger exemplar");
            loom.loaded.about(Failure::from(error).remedy(remedy))
        }
        Error::Core(selvedge_core::Error::NoSource { .. }) => Failure::from(error).remedy("mask less of the exemplars"),
        _ => Failure::from(error),
    }
}
