//! What `video` holds at once.

use rayon::ThreadPool;
use selvedge_core::{Bytes, Domain};
use selvedge_graphcut_textures::video::{self, FrameDistances};

use super::modes::Way;
use super::{Video, blended};
use crate::clips::{self, ClipInput};
use crate::failure::Failure;
use crate::memory;
use crate::reel::Reel;
use crate::session::Session;

impl Video {
    /// Whether frames are made one by one as they are written: into files of their own, none of which may have to be
    /// kept of a run that is ended.
    pub(super) fn streams(&self, session: &Session<'_>, way: &Way) -> bool {
        way.at_once.is_some() && self.may_be_streamed(session)
    }

    /// The same of what is woven some frames at a time.
    pub(super) fn may_be_streamed(&self, session: &Session<'_>) -> bool {
        let into_files = clips::is_pattern(&self.write.output) && self.write.needs_few_frames();
        into_files && !session.global.keep_partial
    }

    /// An upper bound of the memory of a run.
    pub(super) fn need(&self, session: &Session<'_>, clips: &[ClipInput], way: &Way) -> Result<Bytes, Failure> {
        self.need_on(session, clips, way, None)
    }

    /// The same on the threads of a pool, those that there are without one.
    pub(super) fn need_on(
        &self,
        session: &Session<'_>,
        clips: &[ClipInput],
        way: &Way,
        pool: Option<&ThreadPool>,
    ) -> Result<Bytes, Failure> {
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let kept: Bytes = clips.iter().map(|clip| clip.held() + clip.bytes()).sum();
        let colors = info.channels - usize::from(info.alpha);
        let features = memory::sources(&[domain], colors);
        let mut work = Bytes(0);
        if way.jumps() {
            let options = self.transition.options(domain);
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
            let woven = || self.woven.bytes(clip, colors, (way, is_streamed), &options);
            work = work.max(pool.map_or_else(woven, |pool| pool.install(woven)) + refused);
        }
        // The map, one rendered clip, and all of them as files that were not compressed.
        let longest = Bytes::of_samples(Domain::open(way.most(domain)), 1);
        work += self.still.bytes(domain, colors, Domain::open(way.most(domain)));
        let times = |bytes: Bytes| Bytes(bytes.0.saturating_mul(longest.0) / Bytes::of_samples(domain, 1).0.max(1));
        let most = clips.iter().map(ClipInput::bytes).max().unwrap_or_default();
        let maps = if self.write.map.is_some() { longest * 12 } else { Bytes(0) };
        let blended = blended::bytes(self.write.blending, &clips[0], Domain::open(way.most(domain)));
        if self.streams(session, way) {
            if let (Some(at_once), true) = (way.at_once, way.is_read_again) {
                let readers: Bytes = clips.iter().map(Reel::bytes).sum();
                return Ok(memory::PROGRAM + readers + features * 2 + work.max(rendered(clips, way, at_once)));
            }
            // Frames are made and written one by one.
            return Ok(memory::PROGRAM + kept + features * 2 + work.max(longest * 4 + Bytes(16 << 20)));
        }
        let output =
            blended + longest * 4 + times(most) + times(kept) * u64::from(self.write.repeat) + maps + Bytes(64 << 20);
        Ok(memory::PROGRAM + kept + features * 2 + work.max(output))
    }
}

/// What is held of clips that are read again beside the features, where that is most: all of the first, until these are
/// made of it, or as many frames as are woven at once, and which samples they show.
fn rendered(clips: &[ClipInput], way: &Way, at_once: u32) -> Bytes {
    let [frames, height, width] = way.output.shape;
    let once = Bytes::of_samples(Domain::open([at_once, height, width]), 1);
    let frame = |clip: &ClipInput| {
        let pixels = Bytes::of_samples(Domain::open(clip.domain().shape), 1);
        Bytes(clip.bytes().0 / pixels.0.max(1))
    };
    let most = clips.iter().map(frame).max().unwrap_or_default();
    let map = Bytes::of_samples(Domain::open([frames, height, width]), 4);
    clips[0].bytes().max(map + once * (4 + most.0)) + Bytes(16 << 20)
}
