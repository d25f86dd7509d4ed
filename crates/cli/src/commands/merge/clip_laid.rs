//! Clips that are merged: as they were looked at, and as they were read.

use selvedge_core::{Domain, Exemplars, Grid, SourceMap};
use selvedge_graphcut_textures::labels::Label;
use selvedge_io::Fingerprint;
use selvedge_io::clip::Rate;

use crate::clips::{Clip, ClipInput};
use crate::used::Used;

/// Clips that were looked at, and where they lie.
pub(super) struct Laid {
    pub(super) clips: Vec<ClipInput>,
    /// Other passes, as many of each kind as there are clips.
    pub(super) passes: Vec<ClipInput>,
    pub(super) labels: Vec<Label<3>>,
    pub(super) output: Domain<3>,
    pub(super) rate: Option<Rate>,
}

impl Laid {
    /// Of each output the clip whose name, samples and tags it has.
    pub(super) fn shown(&self) -> impl Iterator<Item = &ClipInput> {
        let passes = self.passes.iter().step_by(self.clips.len());
        std::iter::once(&self.clips[0]).chain(passes)
    }
}

/// What was read, and how it was merged.
pub(super) struct Merged {
    pub(super) clips: Vec<Clip>,
    /// Other passes, as many of each kind as there are clips.
    pub(super) passes: Vec<Clip>,
    pub(super) exemplars: Exemplars<3>,
    pub(super) map: SourceMap<3>,
    /// What is copied, whatever is fused.
    pub(super) unfused: Option<Grid<bool, 3>>,
    /// Whether something is in no clip.
    pub(super) holes: bool,
    pub(super) rate: Option<Rate>,
    /// The options as used.
    pub(super) used: Used,
    /// What was read beside clips and passes.
    pub(super) others: Vec<Fingerprint>,
    pub(super) complete: bool,
}

impl Merged {
    pub(super) fn frames(&self) -> u32 {
        let Domain { shape: [frames, ..], .. } = self.map.domain();
        frames
    }

    /// The options as used for what shows the clips, or some passes of them.
    pub(super) fn used_for(&self, passes: Option<&[Clip]>) -> Used {
        let used = self.used.clone();
        match passes {
            None if used.has("with") => used.without("with"),
            None => used,
            Some(passes) => {
                used.set("with", passes.iter().map(|pass| selvedge_io::display_name(&pass.path)).collect::<Vec<_>>())
            }
        }
    }
}
