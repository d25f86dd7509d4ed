//! What `animate` holds at once.

use selvedge_core::{Bytes, Domain, Transform};
use selvedge_io::Format;
use selvedge_io::clip::ClipName;
use selvedge_texture_optimization::{
    Animation, Options, animation_estimate, checkpoint_bytes, closing_bytes, estimate,
};

use super::Animate;
use crate::exemplars::Headers;
use crate::inputs::Input;
use crate::memory;

/// Bytes of a run by when they are held.
pub(super) struct Need {
    kept: Bytes,
    reading: Bytes,
    sources: Bytes,
    /// For the first frame, once its start is made.
    first: Bytes,
    each: Bytes,
}

impl Need {
    /// An upper bound of all, with a start that takes so much.
    pub(super) fn with(&self, start: Bytes) -> Bytes {
        let begun = start.then(self.first);
        memory::PROGRAM + self.kept + self.reading.max(self.sources + begun.max(self.each))
    }
}

impl Animate {
    /// What a run with so many fields and masks holds, whose frames are each made from the sources `at_once`.
    pub(super) fn need(
        &self,
        headers: &Headers,
        (first, options): (&Options, &Animation),
        (output, frames): (Domain<2>, u32),
        (known, masks): (u32, usize),
        at_once: &[Domain<2>],
    ) -> Need {
        let sources = headers.sources(&[Transform::IDENTITY]);
        let layout = self.layout(headers);
        let (channels, depth, features) = (layout.channels(), headers.depth, headers.channels());
        let kept = memory::pictures(&headers.infos, channels, depth) + memory::masks(&headers.mask_infos);
        let held: Bytes = headers.inputs.iter().map(Input::held).sum();
        let reading = memory::reading(headers.infos.iter().chain(&headers.mask_infos)) + held;
        let making = memory::making(&sources, features) + headers.light_bytes(&sources);
        let flows = Bytes::of_samples(output, 9) * u64::from(known) + self.body.bytes(output, masks);
        let closing = self.close.map_or(Bytes(0), |frames| closing_bytes(output, frames));
        let format = Format::of_name(&self.output).unwrap_or(Format::Png);
        let one = memory::outputs(output, (channels, depth), format, false);
        // A container is held until its last frame.
        let all = memory::picture(output, channels, depth) * u64::from(frames);
        let container = if ClipName::parse(&self.output).is_some() { Bytes(0) } else { all };
        let checkpoint = if self.kept.is_asked() { checkpoint_bytes(output) } else { Bytes(0) };
        let each = animation_estimate(at_once, features, output, options) + closing + one + container + checkpoint;
        Need {
            kept: kept + flows,
            reading: reading.then(making),
            sources: memory::sources(&sources, features),
            first: estimate(at_once, features, output, first),
            each,
        }
    }
}
