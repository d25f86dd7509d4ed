//! What `merge` tells of a run.

use selvedge_core::{Plane, Role, Samples, SourceMap};
use selvedge_graphcut_textures::labels::{Label, LabelStats};
use serde_json::Value;

use super::Merge;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::used::Used;
use crate::values::counts;

impl Merge {
    /// The options as used.
    pub(super) fn used(&self, loom: &Loom<'_>, labels: &[Label<2>]) -> Used {
        self.used_of_all(loom.used()).set("at", places(labels))
    }

    /// The same but for what is known of pictures, or of clips, alone.
    pub(super) fn used_of_all(&self, used: Used) -> Used {
        let kept = |pair: &[String]| vec![pair[0].clone(), selvedge_io::display_name(pair[1].as_ref())];
        used.unless("gain", false).set("keep", self.keep.chunks(2).map(kept).collect::<Vec<_>>())
    }
}

/// Where all but the first lie beside it, as it is typed.
pub(super) fn places<const D: usize>(labels: &[Label<D>]) -> Vec<String> {
    let place = |label: &Label<D>| [D - 1, D - 2].map(|axis| label.offset[axis] - labels[0].offset[axis]);
    labels[1..].iter().map(place).map(|[x, y]| format!("{x},{y}")).collect()
}

/// Counts of a run.
pub(super) fn counts<const D: usize>(stats: &LabelStats, labels: &[Label<D>]) -> Value {
    let mut counts = counts!(stats, shown, expansions, improvements, sweeps, holes, energy);
    counts["at"] = labels.iter().map(|label| [label.offset[D - 1], label.offset[D - 2]]).collect::<Vec<_>>().into();
    counts
}

/// How it was made of pictures or clips, in words.
pub(super) fn how(stats: &LabelStats, what: &str) -> String {
    let shown = stats.shown.iter().filter(|shown| 0 < **shown).count();
    format!("from {shown} of {}{}", n(what, stats.shown.len()), transparent(stats.holes))
}

/// The numbers of the pictures that show; each has one label.
pub(super) fn numbered<const D: usize>(map: &SourceMap<D>) -> Result<Plane<D>, Failure> {
    let numbers = map.ids.map(|id| map.table.locate(id).map_or(0, |(source, _)| source as u8 + 1))?;
    Ok(Plane::new(Role::Scalar, Samples::U8(numbers)))
}

/// How much of an output is in no picture, in words.
pub(super) fn transparent(pixels: usize) -> String {
    if pixels == 0 { String::new() } else { format!(", {} in none of them and transparent", n("pixel", pixels)) }
}
