//! What `animate` holds at once.

use selvedge_core::{Bytes, Domain, Transform};
use selvedge_io::clip::ClipName;
use selvedge_texture_optimization::{Animation, Options, animation_estimate, closing_bytes, estimate};

use super::Animate;
use crate::exemplars::Headers;
use crate::memory;

impl Animate {
    /// An upper bound of the memory of a run with so many fields and masks.
    pub(super) fn need(
        &self,
        headers: &Headers,
        (first, options): (&Options, &Animation),
        (output, frames): (Domain<2>, u32),
        (known, masks): (u32, usize),
    ) -> Bytes {
        let sources = headers.sources(&[Transform::IDENTITY]);
        let layout = self.layout(headers);
        let (channels, depth, features) = (layout.channels(), headers.depth, headers.channels());
        let kept = memory::pictures(&headers.infos, channels, depth) + memory::masks(&headers.mask_infos);
        let reading = memory::reading(headers.infos.iter().chain(&headers.mask_infos));
        let making = memory::making(&sources, features) + headers.light_bytes(&sources);
        let begun = self.init.bytes(&sources, features, output).then(estimate(&sources, features, output, first));
        let flows = Bytes::of_samples(output, 9) * u64::from(known) + self.body.bytes(output, masks);
        let closing = self.close.map_or(Bytes(0), |frames| closing_bytes(output, frames));
        let one = memory::outputs(output, channels, depth, false);
        // A container is held until its last frame.
        let all = memory::picture(output, channels, depth) * u64::from(frames);
        let container = if ClipName::parse(&self.output).is_some() { Bytes(0) } else { all };
        let each = animation_estimate(&sources, features, output, options) + closing + one + container;
        memory::PROGRAM + kept + flows + reading.then(making).max(memory::sources(&sources, features) + begun.max(each))
    }
}
