//! What `merge` of clips holds at once.

use selvedge_core::{Bytes, Depth, Domain};
use selvedge_graphcut_textures::labels::estimate_labels;

use super::clip_laid::Laid;
use super::{Merge, clip_blended, clip_seen, gain};
use crate::clips::ClipInput;
use crate::failure::Failure;
use crate::memory;
use crate::session::Session;

/// What is known of clips before they are read.
pub(super) struct Needs {
    sources: Vec<Domain<3>>,
    colors: usize,
    depth: Depth,
    /// Of clips and other passes.
    kept: Bytes,
    /// Channels and depth of each output.
    shown: Vec<(usize, Depth)>,
}

impl Needs {
    pub(super) fn of(laid: &Laid) -> Self {
        let info = laid.clips[0].info();
        Self {
            sources: laid.clips.iter().map(ClipInput::domain).collect(),
            colors: info.channels - usize::from(info.alpha),
            depth: info.depth,
            kept: laid.clips.iter().chain(&laid.passes).map(ClipInput::bytes).sum(),
            shown: laid.shown().map(|clip| (clip.info().channels, clip.info().depth)).collect(),
        }
    }

    /// Refuses an output for which there is too little memory; how much it takes.
    pub(super) fn check(&self, session: &Session<'_>, merge: &Merge, output: Domain<3>) -> Result<Bytes, Failure> {
        let needed = self.bytes(merge, output);
        memory::check_fixed(&session.limits, needed)?;
        Ok(needed)
    }

    /// An upper bound of the memory of a run.
    fn bytes(&self, merge: &Merge, output: Domain<3>) -> Bytes {
        let Self { sources, colors, .. } = self;
        // What may show, and what each label costs by itself.
        let own = if merge.prefer.is_some() { 4 * sources.len() as u64 } else { 0 };
        let masks: Bytes = sources.iter().map(|source| Bytes::of_samples(*source, 2)).sum();
        let masks = if merge.weaving.input.mask.is_empty() { Bytes(0) } else { masks };
        let work = estimate_labels(sources, *colors, output) + Bytes::of_samples(output, own + 8 + 1);
        let gained = if merge.gain { gain::bytes(sources, *colors, output) } else { Bytes(0) };
        let work = work.max(gained).max(merge.found_bytes(sources, *colors));
        let features = memory::sources(sources, *colors) * 2;
        memory::PROGRAM + self.kept + masks + features + work.max(self.output(merge, output))
    }

    /// The map and what its files take, and what is rendered, as files.
    fn output(&self, merge: &Merge, output: Domain<3>) -> Bytes {
        let files: Bytes = self.shown.iter().map(|(channels, depth)| memory::picture(output, *channels, *depth)).sum();
        let maps = if merge.weaving.map.is_some() { 12 } else { 0 };
        let seen = if merge.is_seen() { clip_seen::bytes(output, self.colors, self.depth) } else { Bytes(0) };
        let kept = merge.fuse_keep.of(merge.blending).is_ok_and(|path| path.is_some());
        let blended = clip_blended::bytes(merge.blending, output, self.colors, (kept, self.depth.bytes()));
        blended + seen + files * 2 + Bytes::of_samples(output, 4 + 2 + maps)
    }
}
