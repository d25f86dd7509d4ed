//! What `video` holds at once.

use selvedge_core::{Bytes, Domain};
use selvedge_graphcut_textures::video::{self, FrameDistances};

use super::modes::Way;
use super::{Video, blended};
use crate::clips::{self, ClipInput};
use crate::failure::Failure;
use crate::memory;
use crate::session::Session;

/// What it would be on as many threads as regions of a clip are decided on: how many frames are woven at once follows
/// from it, and must not depend on how many there are.
fn on_most_threads(bytes: impl FnOnce() -> Bytes + Send) -> Result<Bytes, Failure> {
    let refused = |e| Failure::new(6, format!("the system starts no threads ({e})")).remedy("free some memory");
    Ok(rayon::ThreadPoolBuilder::new().num_threads(8).build().map_err(refused)?.install(bytes))
}

impl Video {
    /// Whether frames are made one by one as they are written: into files of their own, none of which may have to be
    /// kept of a run that is ended.
    pub(super) fn streams(&self, session: &Session<'_>, way: &Way) -> bool {
        let into_files = clips::is_pattern(&self.write.output) && self.write.needs_few_frames();
        way.at_once.is_some() && into_files && !session.global.keep_partial
    }

    /// An upper bound of the memory of a run.
    pub(super) fn need(&self, session: &Session<'_>, clips: &[ClipInput], way: &Way) -> Result<Bytes, Failure> {
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let kept: Bytes = clips.iter().map(|clip| clip.held() + clip.bytes()).sum();
        let colors = info.channels - usize::from(info.alpha);
        let features = memory::sources(&[domain], colors);
        let mut work = Bytes(0);
        if way.jumps() {
            let options = self.transition.options();
            work = video::estimate(domain, colors, &options) + FrameDistances::bytes(domain, colors);
            // A walk keeps the surface of each jump.
            work += Bytes::of_samples(domain, 2) * u64::from(way.play.is_some());
        }
        if way.weaves() {
            let options = self.woven.options(way, self.transition.measure(), self.transition.levels())?;
            // Beside a jump that was refused: its map and pictures.
            let refused = if way.jumps() { Bytes::of_samples(domain, 6) } else { Bytes(0) };
            let clip = (domain, info.alpha);
            let is_streamed = self.streams(session, way);
            let woven = on_most_threads(|| self.woven.bytes(clip, colors, (way, is_streamed), &options))?;
            work = work.max(woven + refused);
        }
        // The map, one rendered clip, and all of them as files that were not compressed.
        let longest = Bytes::of_samples(Domain::open(way.most(domain)), 1);
        work += self.still.bytes(domain, colors, Domain::open(way.most(domain)));
        let times = |bytes: Bytes| Bytes(bytes.0.saturating_mul(longest.0) / Bytes::of_samples(domain, 1).0.max(1));
        let most = clips.iter().map(ClipInput::bytes).max().unwrap_or_default();
        let maps = if self.write.map.is_some() { longest * 12 } else { Bytes(0) };
        let blended = blended::bytes(self.write.blending, &clips[0], Domain::open(way.most(domain)));
        if self.streams(session, way) {
            // Frames are made and written one by one.
            return Ok(memory::PROGRAM + kept + features * 2 + work.max(longest * 4 + Bytes(16 << 20)));
        }
        let output =
            blended + longest * 4 + times(most) + times(kept) * u64::from(self.write.repeat) + maps + Bytes(64 << 20);
        Ok(memory::PROGRAM + kept + features * 2 + work.max(output))
    }
}
